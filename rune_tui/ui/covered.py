"""Lists and questions over the view get the keys, but the stop key still stops."""

from __future__ import annotations

from abc import abstractmethod

from textual import events

from rune_tui.ui.mouse import MouseApp
from rune_tui.ui.question import Question

_CLOSE = "escape"


class CoveredApp(MouseApp, inherit_bindings=False):
    """Checks each key for a stop before a list or a question gets it.

    | over the view | action of the stop key |
    | --- | --- |
    | the list | stops |
    | a question, and the key types nothing | stops |
    | a question, and the key types a character | types it; twice in a row, it also stops |
    """

    _typed = ""
    """The last key typed into a question, if it was a stop key; else empty."""

    @abstractmethod
    def stop_key(self, event: events.Key) -> str:
        """The input name of a stop key; else empty."""

    @abstractmethod
    def stop_below(self, name: str) -> None:
        """Stop the robots that the key of this name stops."""

    @property
    def covered(self) -> bool:
        """Whether a list or a question lies over the view and gets the inputs."""
        return len(self.screen_stack) > 1

    async def on_event(self, event: events.Event) -> None:
        """Handle an event before Textual does."""
        key = event if isinstance(event, events.Key) and not event.is_forwarded else None
        if key is None or not self.covered or not self._takes(key):
            await super().on_event(event)

    def _takes(self, key: events.Key) -> bool:
        """Stop, if the key is a stop key; returns whether the key has no other use."""
        name = self.stop_key(key)
        types = isinstance(self.screen, Question) and key.is_printable
        again, self._typed = name == self._typed, name
        if name and (again or not types):
            self.stop_below(name)
        return bool(name) and not types and name != _CLOSE
