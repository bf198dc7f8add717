"""How words are meant, and the ink that says so; the words say it as well."""

from __future__ import annotations

import enum

from rune_tui.model.theme import Colour, Theme


class Mood(enum.Enum):
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


def ink_of(mood: Mood, theme: Theme) -> Colour:
    """The colour of words that are meant so."""
    return {
        Mood.PLAIN: theme.ink,
        Mood.FAINT: theme.faint,
        Mood.GOOD: theme.good,
        Mood.WARNING: theme.warning,
        Mood.ALARM: theme.alarm_ink,
    }[mood]
