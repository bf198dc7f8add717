"""Lists and questions that lie over the view have the keys, but the stop still stops."""

from __future__ import annotations

from abc import abstractmethod

from textual import events

from rune_tui.ui.mouse import MouseApp
from rune_tui.ui.question import Question

_CLOSE = "escape"


class CoveredApp(MouseApp, inherit_bindings=False):
    """Looks at each key before what lies over the view takes it.

    | over the view | the stop key |
    | --- | --- |
    | the list | stops |
    | a question, and the key types nothing | stops |
    | a question, and the key types a character | is typed; twice in a row, it stops as well |
    """

    _typed = ""
    """The stop key that was typed last into a question; empty: another key was."""

    @abstractmethod
    def stop_key(self, event: events.Key) -> str:
        """The name of a key that stops a robot; empty if it stops none."""

    @abstractmethod
    def stop_below(self, name: str) -> None:
        """Stop the robots that the key of this name stops."""

    @property
    def covered(self) -> bool:
        """Whether something lies over the view and has the keys and the mouse."""
        return len(self.screen_stack) > 1

    async def on_event(self, event: events.Event) -> None:
        """An event, before Textual gives it to anybody."""
        key = event if isinstance(event, events.Key) and not event.is_forwarded else None
        if key is None or not self.covered or not self._takes(key):
            await super().on_event(event)

    def _takes(self, key: events.Key) -> bool:
        """Stop if a key does; whether it means nothing else."""
        name = self.stop_key(key)
        types = isinstance(self.screen, Question) and key.is_printable
        again, self._typed = name == self._typed, name
        if name and (again or not types):
            self.stop_below(name)
        return bool(name) and not types and name != _CLOSE
