"""What the doctor finds: one thing that is well, or not quite, or wrong, and what to do."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Level(enum.Enum):
    """How bad it is; with a problem the hub does not run, or not as the robot file wants it."""

    OK = "ok"
    WARNING = "warning"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One line of the doctor's.

    Attributes:
        level: How bad it is.
        text: What was seen.
        advice: What to do; empty where nothing has to be done.
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


def problem(text: str, advice: str) -> Finding:
    """Something that is wrong."""
    return Finding(level=Level.PROBLEM, text=text, advice=advice)
