"""How words are meant, and the ink that says so; the words say it as well."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from rune_tui.model.theme import Colour, Theme


class Severity(enum.Enum):
    """How words are meant.

    Attributes:
        PLAIN: As they are.
        FAINT: They matter less.
        GOOD: All is well.
        WARNING: It needs a look.
        ALARM: It needs a hand.
    """

    PLAIN = "plain"
    FAINT = "faint"
    GOOD = "good"
    WARNING = "warning"
    ALARM = "alarm"


@dataclass(frozen=True, slots=True)
class Part:
    """A piece of what is said of a robot.

    Attributes:
        text: What it says.
        weight: Where room is short, parts of the least weight go first.
        mood: How it is meant.
        short: The same in fewer words, for where room is short; empty if there are none.
        gauge: Whether panes for nothing but that say it too: speed, battery, link.
    """

    text: str
    weight: float
    mood: Severity = Severity.PLAIN
    short: str = ""
    gauge: bool = False


def ink_of(mood: Severity, theme: Theme) -> Colour:
    """The colour of words that are meant so."""
    return {
        Severity.PLAIN: theme.ink,
        Severity.FAINT: theme.faint,
        Severity.GOOD: theme.good,
        Severity.WARNING: theme.warning,
        Severity.ALARM: theme.alarm_ink,
    }[mood]
