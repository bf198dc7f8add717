"""The interest points: victims and landmarks, marked, replaced and removed; pure."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hub.errors import MissionError
from hub.gcm.mapping import InterestPoint

MAX_POINTS = 128
"""Points on one sheet."""
MAX_NOTE = 500
"""Largest number of characters; longer texts are cut."""
MAX_BY = 64
"""Largest number of characters; longer texts are cut."""
MAX_THUMBNAIL_BYTES = 4096
"""Largest picture of a point [bytes]; all points are sent every few seconds."""
FARTHEST = 1e5
"""Largest x or y of a point [m]."""
MAX_NUMBER = 2**32 - 1
LATEST = 1e10
"""Latest time of a mark [s since the epoch]."""

NO_THUMBNAIL = np.empty(0, np.uint8)


class PointBook:
    """The points; numbers of removed points are not used again.

    Attributes:
        earlier: Points of sheets before the newest, by number, each with the number of its sheet.
    """

    def __init__(self) -> None:
        self.earlier: dict[int, tuple[int, InterestPoint]] = {}
        self._points: dict[int, InterestPoint] = {}
        self._next = 1

    @property
    def points(self) -> tuple[InterestPoint, ...]:
        """Those of the newest sheet, in the order of their numbers."""
        return tuple(self._points[number] for number in sorted(self._points))

    def checked(self, point: InterestPoint, by: str, now: float) -> InterestPoint:
        """The point as it would be stored; nothing changes yet.

        Args:
            point: New if its number is 0, else another version of one that is there; a long note is
                cut, a large picture is left out, and an impossible uncertainty or distance is NaN.
            by: Its operator, if the point has none.
            now: Time of the mark [s since the epoch], if the point has none.

        Raises:
            MissionError: It is refused; the text gives the reason.
        """
        if not (abs(point.x) <= FARTHEST and abs(point.y) <= FARTHEST):
            text = f"({point.x:g}, {point.y:g}) is nowhere"
            raise MissionError(text)
        version = self._version_after(point)
        small = len(point.thumbnail) <= MAX_THUMBNAIL_BYTES
        thumbnail = point.thumbnail.copy() if small else NO_THUMBNAIL
        return dataclasses.replace(
            point,
            number=point.number or self._next,
            uncertainty=_possible(point.uncertainty),
            distance=_possible(point.distance),
            stamp=point.stamp if 0.0 < point.stamp <= LATEST else now,
            by=_who(point, by),
            note=point.note.replace("\0", "")[:MAX_NOTE],
            thumbnail=thumbnail,
            version=version,
            kept=0,
        )

    def same(self, point: InterestPoint, by: str) -> InterestPoint | None:
        """The point that is equal to the last bit; None: there is none.

        A client without an answer sends a mark or a change again: it must not become two marks, and
        it must not be refused.
        """
        changed = self._points.get(point.number)
        if changed is not None and changed.version == point.version + 1:
            now = (changed.kind, changed.x, changed.y, changed.note)
            if now == (point.kind, point.x, point.y, point.note):
                return changed
        for known in self._points.values():
            alike = (known.kind, known.x, known.y) == (point.kind, point.x, point.y)
            if alike and known.by == _who(point, by) and point.number == 0:
                return known
        return None

    def check_removal(self, number: int, version: int) -> None:
        """Whether a point can be removed; version 0 is any.

        Raises:
            MissionError: It is refused; the text gives the reason.
        """
        known = self._known(number)
        if version not in (0, known.version):
            raise MissionError(_changed(known))

    def put(self, point: InterestPoint) -> None:
        """Add a point that was checked, or replace the one with its number."""
        self._points[point.number] = point
        self._next = max(self._next, point.number + 1)

    def with_thumbnail(self, point: InterestPoint) -> InterestPoint:
        """The point with the picture of the known point of its number."""
        known = self._points.get(point.number)
        if known is None:
            return point
        return dataclasses.replace(point, thumbnail=known.thumbnail)

    def has_thumbnail(self, point: InterestPoint) -> bool:
        """Whether the known point of this number has the same picture, and has one."""
        known = self._points.get(point.number)
        return (
            known is not None
            and known.thumbnail.size > 0
            and np.array_equal(known.thumbnail, point.thumbnail)
        )

    def drop(self, number: int) -> None:
        """Remove a point, if it exists."""
        self._points.pop(number, None)

    def begin_sheet(self, before: int) -> None:
        """Begin a new sheet; `before` is the number of the sheet that the points stay on."""
        self.earlier |= {number: (before, point) for number, point in self._points.items()}
        self._points.clear()

    def mark(self, point: InterestPoint, by: str, now: float) -> str:
        """Check and put a point; returns why it is refused, or an empty string."""
        try:
            self.put(self.checked(point, by, now))
        except MissionError as error:
            return str(error)
        return ""

    def _version_after(self, point: InterestPoint) -> int:
        if point.number:
            known = self._known(point.number)
            if point.version != known.version:
                raise MissionError(_changed(known))
            return known.version + 1
        if self._next > MAX_NUMBER:
            text = "there are no numbers left"
            raise MissionError(text)
        if len(self._points) >= MAX_POINTS:
            text = f"there are {MAX_POINTS} already"
            raise MissionError(text)
        return 1

    def _known(self, number: int) -> InterestPoint:
        known = self._points.get(number)
        if known is None:
            sheet = f": it is on sheet {self.earlier[number][0]}" if number in self.earlier else ""
            text = f"there is no point {number} on this sheet{sheet}"
            raise MissionError(text)
        return known


def _who(point: InterestPoint, by: str) -> str:
    """The operator who marked a point, as stored."""
    return (point.by or by).replace("\0", "")[:MAX_BY]


def _changed(known: InterestPoint) -> str:
    name = f"{known.kind.name.lower()} {known.number}"
    return f"{name} was changed meanwhile, or removed: look at it as it is now, and change that"


def _possible(metres: float) -> float:
    """The length [m]; NaN: too large, or the 0 of a field that was left out."""
    return metres if 0.0 < metres <= FARTHEST else math.nan
