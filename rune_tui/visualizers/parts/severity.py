"""The severity of words, and its ink; the words show it too."""

from __future__ import annotations

import enum

from hub.values import dataclass
from rune_tui.model.theme import Colour, Theme


class Severity(enum.Enum):
    """The severity of words.

    Attributes:
        PLAIN: None.
        FAINT: Less important.
        GOOD: All is well.
        WARNING: The operator should look.
        ALARM: The operator must act.
    """

    PLAIN = "plain"
    FAINT = "faint"
    GOOD = "good"
    WARNING = "warning"
    ALARM = "alarm"


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the words about a robot.

    Attributes:
        text: Its text.
        weight: If room is short, parts with the least weight are left out first.
        severity: Its severity.
        short: The same in fewer words, if room is short; empty: none.
        gauge: Whether a gauge shows it too: speed, battery, link.
        cause: The cause of a robot's problem, or the subject, which stays while its words change;
            empty: it is none, or one that the operator made.
    """

    text: str
    weight: float
    severity: Severity = Severity.PLAIN
    short: str = ""
    gauge: bool = False
    cause: str = ""


def ink_of(severity: Severity, theme: Theme) -> Colour:
    """The colour of words of a severity."""
    return {
        Severity.PLAIN: theme.ink,
        Severity.FAINT: theme.faint,
        Severity.GOOD: theme.good,
        Severity.WARNING: theme.warning,
        Severity.ALARM: theme.alarm_ink,
    }[severity]
