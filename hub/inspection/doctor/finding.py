"""A finding of the doctor: its level and its remedy."""

from __future__ import annotations

import enum

from hub.values import dataclass


class Level(enum.Enum):
    """The level of a finding.

    With a problem the hub does not run, or not by the robot file. What could not be looked at is
    unknown, and as bad.
    """

    OK = "ok"
    WARNING = "warning"
    UNKNOWN = "unknown"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One line of the doctor's.

    Attributes:
        level: How bad it is.
        text: The finding.
        advice: The remedy; empty: none needed.
    """

    level: Level
    text: str
    advice: str = ""


def ok(text: str) -> Finding:
    """Something that is well."""
    return Finding(level=Level.OK, text=text)


def warning(text: str, advice: str) -> Finding:
    """Something that will do, but not well or not for long."""
    return Finding(level=Level.WARNING, text=text, advice=advice)


def unknown(text: str, advice: str) -> Finding:
    """Something that could not be looked at."""
    return Finding(level=Level.UNKNOWN, text=text, advice=advice)


def problem(text: str, advice: str) -> Finding:
    """Something that is wrong."""
    return Finding(level=Level.PROBLEM, text=text, advice=advice)
