"""The topic and the field that the operator of a replay looks at, and their keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

SECONDS: Final = (5.0, 10.0, 30.0, 60.0, 300.0)
"""Times that a plot may cover [s]."""
HELP: Final = "up down topic  Tab field  Z time of the plot"
_PAGE: Final = 10


class TopicChoice:
    """What is looked at; all sources of one replay share it.

    Attributes:
        topic: Name of the topic; empty: the first one with numbers.
        field: Path of the field; empty: its first number.
        seconds: Time that the plot covers [s].
    """

    def __init__(self) -> None:
        self.topic = ""
        self.field = ""
        self.seconds = 30.0

    def press(self, key: str, topics: Sequence[str], fields: Sequence[str]) -> bool:
        """Handle a key; returns whether it was one of the choice.

        Args:
            key: Its name.
            topics: Names of all topics, in their order.
            fields: Paths of the chosen topic's numbers, in their order.
        """
        steps = {"up": -1, "down": 1, "pageup": -_PAGE, "pagedown": _PAGE}
        if key in steps and topics:
            at = topics.index(self.topic) if self.topic in topics else 0
            self.topic = topics[max(0, min(len(topics) - 1, at + steps[key]))]
            self.field = ""
        elif key in ("tab", "shift+tab") and fields:
            step = 1 if key == "tab" else -1
            at = fields.index(self.field) if self.field in fields else -step
            self.field = fields[(at + step) % len(fields)]
        elif key == "z":
            at = SECONDS.index(self.seconds) if self.seconds in SECONDS else 0
            self.seconds = SECONDS[(at + 1) % len(SECONDS)]
        else:
            return key in steps or key in ("tab", "shift+tab")
        return True
