"""Prepares notices for display: merges equal ones, and shortens paths; pure."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Sequence

from rune_tui.model.console_state import Notice

KEPT_S = 10.0
"""Time in which an alarm stays before other notices [s]."""
_PATH = re.compile(r"(?:~|/)(?:[^\s/]+/)+([^\s/]+)")


def merged(notices: Sequence[Notice]) -> tuple[Notice, ...]:
    """The notices, with equal neighbours merged and counted."""
    found: list[Notice] = []
    counts: list[int] = []
    for notice in notices:
        last = found[-1] if found else None
        if last is not None and _same(last, notice):
            found[-1] = notice
            counts[-1] += 1
        else:
            found.append(notice)
            counts.append(1)
    return tuple(
        notice if count == 1 else dataclasses.replace(notice, text=f"{notice.text} ({count} times)")
        for notice, count in zip(found, counts, strict=True)
    )


def _same(one: Notice, other: Notice) -> bool:
    return (one.text, one.robot, one.alarm) == (other.text, other.robot, other.alarm)


def shortened(text: str) -> str:
    """A text with each path reduced to its file name."""
    return _PATH.sub(r"…/\1", text)


def by_importance(notices: Iterable[Notice], now: float) -> list[Notice]:
    """The notices in order of importance, then newest first.

    Recent alarms come first, and recent confirmations of orders come last.
    """

    def weight(place: tuple[int, Notice]) -> tuple[int, int]:
        number, notice = place
        fresh = now - notice.when < KEPT_S
        rank = 0 if not fresh else 2 if notice.alarm else 0 if notice.routine else 1
        return rank, number

    ordered = sorted(enumerate(notices), key=weight, reverse=True)
    return [notice for _, notice in ordered]
