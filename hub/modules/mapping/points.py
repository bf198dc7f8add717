"""The interest points: victims and landmarks, marked, replaced and removed; pure."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hub.gcm.mapping import InterestPoint, InterestPoints

MAX_POINTS = 128
MAX_NOTE = 500
"""Characters; what is longer is cut."""
MAX_BY = 64
"""Characters; what is longer is cut."""
MAX_THUMBNAIL_BYTES = 4096
"""A larger picture is left out: all points go over the air every few seconds."""
FARTHEST = 1e5
"""No point is farther than this from the origin along x or y [m]."""
MAX_NUMBER = 2**32 - 1

NO_THUMBNAIL = np.empty(0, np.uint8)


class PointBook:
    """The points there are; numbers of points that were removed are not given again."""

    def __init__(self) -> None:
        self._points: dict[int, InterestPoint] = {}
        self._next = 1

    @property
    def message(self) -> InterestPoints:
        """All of them, in the order of their numbers."""
        points = tuple(self._points[number] for number in sorted(self._points))
        return InterestPoints(count=len(points), points=points)

    def mark(self, point: InterestPoint, by: str, now: float) -> str:
        """Add a point, or replace the one with its number.

        Args:
            point: The point; a note that is too long is cut, a picture that is too large left out,
                and an uncertainty or a distance that cannot be is NaN.
            by: Who marked it, where the point does not say.
            now: When it was marked [s since the epoch], where the point does not say.

        Returns:
            Why it is refused; empty if it is not.
        """
        if not (abs(point.x) <= FARTHEST and abs(point.y) <= FARTHEST):
            return f"({point.x}, {point.y}) is nowhere"
        number = point.number or self._next
        if number > MAX_NUMBER:
            return "there are no numbers left"
        if number not in self._points and len(self._points) >= MAX_POINTS:
            return f"there are {MAX_POINTS} already"
        small = point.length == len(point.thumbnail) <= MAX_THUMBNAIL_BYTES
        thumbnail = point.thumbnail.copy() if small else NO_THUMBNAIL
        self._points[number] = dataclasses.replace(
            point,
            number=number,
            uncertainty=_possible(point.uncertainty),
            distance=_possible(point.distance),
            stamp=point.stamp if math.isfinite(point.stamp) and point.stamp > 0.0 else now,
            by=(point.by or by)[:MAX_BY],
            note=point.note[:MAX_NOTE],
            length=len(thumbnail),
            thumbnail=thumbnail,
        )
        self._next = max(self._next, number + 1)
        return ""

    def remove(self, number: int) -> str:
        """Remove a point; why it cannot be, empty if it can."""
        return "" if self._points.pop(number, None) else f"there is no point {number}"

    def replace_all(self, points: tuple[InterestPoint, ...]) -> None:
        """Give up all points for others, which are within all bounds."""
        self._points = {point.number: point for point in points}
        self._next = max([self._next, *(number + 1 for number in self._points)])


def _possible(metres: float) -> float:
    """The length [m]; NaN if none here is so long, or it is the 0 of a field that was left out."""
    return metres if 0.0 < metres <= FARTHEST else math.nan
