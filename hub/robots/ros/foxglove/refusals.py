"""Which topics and services a bridge does not serve, by the errors that it says; pure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from hub.robots.ros.foxglove.bridge_events import BridgeStatus

MOST_KEPT = 64
"""Most topics whose refusal is kept."""


class BridgeRefusals:
    """The errors of a bridge about topics and services that are used here.

    Bridges say an error once, in words: with the name of the topic, its type, or the number of the
    channel. It holds until the topic is given up or the connection ends.

    Attributes:
        words: The error about each of them, by its name.
    """

    def __init__(self) -> None:
        self.words: dict[str, str] = {}
        self._said: dict[str, str] = {}

    def note(
        self,
        status: BridgeStatus,
        published: Mapping[str, tuple[int, str]],
        named: Iterable[str],
    ) -> None:
        """Take a sentence of the bridge.

        Args:
            status: The sentence.
            published: Number of the channel and type of each own topic, by its name.
            named: Names of topics that are subscribed to, and of services that were called.
        """
        if not status.is_error:
            return
        for name, (number, kind) in published.items():
            if _has(status.text, name, kind, kind.replace("/msg/", "/"), f"channel {number}"):
                self._keep(name, status)
        for name in named:
            if _has(status.text, name):
                self._keep(name, status)

    def take_back(self, ids: Iterable[str]) -> None:
        """Forget sentences that do not hold any more."""
        gone = [name for name, each in self._said.items() if each in ids]
        for name in gone:
            self.drop(name)

    def drop(self, name: str) -> None:
        """Forget what was said about a topic."""
        self.words.pop(name, None)
        self._said.pop(name, None)

    def clear(self) -> None:
        """Drop all errors, as for a new connection."""
        self.words.clear()
        self._said.clear()

    def _keep(self, name: str, status: BridgeStatus) -> None:
        if len(self.words) < MOST_KEPT or name in self.words:
            self.words[name] = status.text
            if status.id:
                self._said[name] = status.id


def _has(text: str, *names: str) -> bool:
    """Whether a text has one of these names, and not as a part of a longer one."""
    return any(re.search(rf"(?<![\w/]){re.escape(each)}(?![\w/])", text) for each in names if each)
