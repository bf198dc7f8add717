"""Copies of the view along a recording."""

from __future__ import annotations

import bisect
from collections import OrderedDict
from typing import Final

from rune_tui.replay.drawing import FrameDrawer

EVERY_NS: Final = 3_000_000_000
"""Least log time between two copies of the view [ns]."""
_MOST: Final = 2000
"""Copies of a long recording; they are further apart then."""
_MOST_NEAR: Final = 40


class ViewCopies:
    """Copies of a drawer by the time of their last frame; each remembers all frames before.

    Attributes:
        every: Log time between two copies [ns].
    """

    def __init__(self, length: int) -> None:
        """Begin without copies.

        Args:
            length: Length of the recording [ns].
        """
        self.every = max(EVERY_NS, length // _MOST)
        self._stamps: list[int] = []
        self._drawers: list[FrameDrawer] = []
        self._near: OrderedDict[int, FrameDrawer] = OrderedDict()

    def keep(self, stamp: int, drawer: FrameDrawer) -> None:
        """Keep a copy of a drawer that remembers all frames up to a time."""
        place = bisect.bisect_left(self._stamps, stamp - self.every + 1)
        if place == len(self._stamps) or self._stamps[place] >= stamp + self.every:
            place = bisect.bisect_left(self._stamps, stamp)
            self._stamps.insert(place, stamp)
            self._drawers.insert(place, drawer.copied())

    def keep_near(self, stamp: int, drawer: FrameDrawer) -> None:
        """Keep one for the frames that follow it, which are asked for next."""
        self._near[stamp] = drawer.copied()
        while len(self._near) > _MOST_NEAR:
            self._near.popitem(last=False)

    def end_from(self, stamp: int) -> int:
        """The time of the last copy that others lead to from a time, without a longer way."""
        for each in self._stamps[bisect.bisect_left(self._stamps, stamp) :]:
            if each - stamp > 2 * self.every:
                break
            stamp = each
        return stamp

    def before(self, stamp: int) -> tuple[int, FrameDrawer] | None:
        """The last copy at or before a time, and its time; None: there is none."""
        place = bisect.bisect_right(self._stamps, stamp) - 1
        found = (self._stamps[place], self._drawers[place]) if place >= 0 else None
        near = max((each for each in self._near if each <= stamp), default=None)
        if near is not None and (found is None or near > found[0]):
            found = near, self._near[near]
        return (found[0], found[1].copied()) if found is not None else None
