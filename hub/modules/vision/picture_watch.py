"""Whether the pictures of a camera are new, although their stamps are; pure.

A server may repeat its last picture with new stamps, and so may a driver. A picture of a still
place is the same too. So only motion of the robot or of the camera shows the difference:

| the robot and the camera | the pictures | are |
| --- | --- | --- |
| stand | equal, byte by byte | the same for some time |
| have moved by `MOVED` since the first | equal, byte by byte | as old as the first |
| have moved by `FAR` | differ as little as two in a row do | as old as the motion |
| any | differ more | new |

The third row is for coders that add noise to a repeated picture. It does not judge pictures
without structure, as of darkness or of a wall.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

MOVED: Final = 0.1
"""Motion after which equal pictures are old [m], or about as many rad."""
FAR: Final = 1.0
"""Motion after which pictures differ by more than noise [m], or about as many rad."""
_REPEATED_S: Final = 0.5
"""Least time of equal pictures before they are old [s]: slow cameras repeat theirs."""
_MOST_PIXELS: Final = 4096
_MOST_NOISE: Final = 4.0
"""Largest mean difference of two pictures that is noise, in shades of 256."""
_LOUDER: Final = 1.5
_STRUCTURE: Final = 8.0
"""Least standard deviation of a picture with structure, in shades of 256."""
_KEPT: Final = 9

Pixels = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Newness:
    """How new a picture is.

    Attributes:
        measured: When it was taken; of a repeated one, when the first was [s, monotonic].
        same_s: For how long the pictures have been equal [s]; 0: it is new.
        repeated: Whether it is an old one with a new stamp.
    """

    measured: float
    same_s: float = 0.0
    repeated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Seen:
    """A picture, when it came [s, monotonic], and the motion until then [m]."""

    pixels: Pixels
    measured: float
    travel: float

    def difference(self, other: _Seen) -> float:
        """Mean difference, in shades of 256, at some of the pixels; 0: all pixels are equal."""
        if np.array_equal(self.pixels, other.pixels):
            return 0.0
        few = self.few - other.few
        return max(1e-3, float(np.abs(few).mean()))

    @property
    def few(self) -> npt.NDArray[np.int16]:
        """Some pixels from all over the picture, shape (n, 3)."""
        pixels = self.pixels.reshape(-1, 3)
        return pixels[:: max(1, len(pixels) // _MOST_PIXELS)].astype(np.int16)


class PictureWatch:
    """Judges the pictures of one camera in one size, in the order of time."""

    def __init__(self) -> None:
        self._last: _Seen | None = None
        self._equal: _Seen | None = None
        self._before: _Seen | None = None
        self._noise: deque[float] = deque(maxlen=_KEPT)

    def judge(self, pixels: Pixels, measured: float, travel: float) -> Newness:
        """Judge a picture.

        Args:
            pixels: Red, green, blue, shape (height, width, 3), always of one size.
            measured: When it was taken, by its stamp [s, monotonic].
            travel: Way of the robot and turns of robot and camera until now [m], or [rad].
        """
        now = _Seen(pixels=pixels, measured=measured, travel=travel)
        last, self._last = self._last, now
        equal, before = self._equal, self._before
        if last is None or equal is None or before is None:
            self._equal = self._before = now
            return Newness(measured=measured)
        difference = now.difference(last)
        if difference:
            self._equal = equal = now
            self._noise.append(difference)
        same_s = max(0.0, measured - equal.measured)
        if same_s >= _REPEATED_S and travel - equal.travel >= MOVED:
            return Newness(measured=equal.measured, same_s=same_s, repeated=True)
        if not self._alike(now, before):
            self._noise.clear()
            self._before = now
        elif travel == before.travel:
            self._before = now
        elif difference and travel - before.travel >= FAR:
            return Newness(measured=before.measured, repeated=True)
        return Newness(measured=measured, same_s=same_s)

    def _alike(self, now: _Seen, before: _Seen) -> bool:
        """Whether two pictures with structure differ by no more than noise."""
        noise = float(np.median(self._noise)) if self._noise else 0.0
        alike = now.difference(before) <= min(_MOST_NOISE, _LOUDER * noise)
        return alike and float(now.few.std()) >= _STRUCTURE
