"""A canvas with the coordinates of an arena: areas, discs, arrows, digits and a scale bar."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Point = tuple[float, float]
Tone = tuple[float, ...]
"""Red, green, blue, 0 to 255."""
Window = tuple[slice, slice]

WHITE: Tone = (255.0, 255.0, 255.0)
BLACK: Tone = (20.0, 20.0, 20.0)

_FINER = 2
"""Pixels that are drawn along each side of a pixel of the picture."""
_GLYPHS = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71717", "4": "55711", "5": "74717",
    "6": "74757", "7": "71111", "8": "75757", "9": "75717", "m": "00775", ".": "00002",
    " ": "00000",
}  # fmt: skip
"""Five rows of three dots, each row as the digit of its bits."""
_BAR_LENGTHS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_BAR_SHARE = 0.4
"""Longest scale bar, as a share of the width."""


class Canvas:
    """Drawing in metres, north up.

    Attributes:
        pixel: Side of a pixel of the picture [m].
    """

    def __init__(self, low: Point, high: Point, longest_px: int, background: Tone) -> None:
        """Prepare it.

        Args:
            low: South-west corner [m].
            high: North-east corner [m].
            longest_px: Pixels along the longer side of the picture.
            background: Its colour.
        """
        width, height = high[0] - low[0], high[1] - low[1]
        self.pixel = max(width, height) / longest_px
        self._fine = self.pixel / _FINER
        columns, rows = (max(1, round(side / self.pixel)) * _FINER for side in (width, height))
        self._values = np.empty((rows, columns, 3), dtype=np.float32)
        self._values[:] = background
        self._low = low
        # Middles of rows and columns; row 0 is the southernmost until the end.
        self._x = low[0] + (np.arange(columns) + 0.5) * self._fine
        self._y = low[1] + (np.arange(rows) + 0.5) * self._fine

    def picture(self) -> npt.NDArray[np.uint8]:
        """What is drawn, shape (height, width, 3)."""
        rows, columns = (side // _FINER for side in self._values.shape[:2])
        blocks = self._values.reshape(rows, _FINER, columns, _FINER, 3)
        drawn: npt.NDArray[np.uint8] = np.rint(blocks.mean(axis=(1, 3))).astype(np.uint8)
        return drawn[::-1].copy()

    def fill(self, low: Point, high: Point, tone: Tone, share: float = 1.0) -> None:
        """Fill a rectangle; of what was there, 1 - `share` stays."""
        part = self._values[self._window(low, high)]
        part += np.float32(share) * (np.array(tone, dtype=np.float32) - part)

    def shade(self, low: Point, high: Point, light: float) -> None:
        """Multiply the light in a rectangle."""
        self._values[self._window(low, high)] *= np.float32(light)

    def disc(self, middle: Point, radius: float, tone: Tone, share: float = 1.0) -> None:
        """Fill a disc; of what was there, 1 - `share` stays."""
        part, inside = self._disc(middle, radius)
        part[inside] += np.float32(share) * (np.array(tone, dtype=np.float32) - part[inside])

    def shadow(self, low: Point, high: Point, length: float, light: float) -> None:
        """Multiply the light where a rectangle throws its shadow, to the south-west."""
        rows, columns = self._window((low[0] - length, low[1] - length), high)
        x, y = self._x[columns], self._y[rows][:, None]
        # A point is in the shadow if the rectangle, moved by no more than the length, covers it.
        least = np.maximum(np.maximum(low[0] - x, low[1] - y), 0.0)
        most = np.minimum(np.minimum(high[0] - x, high[1] - y), length)
        self._values[rows, columns][least <= most] *= np.float32(light)

    def round_shadow(self, middle: Point, radius: float, length: float, light: float) -> None:
        """The same for a disc."""
        reach = radius + length
        window = self._window(
            (middle[0] - reach, middle[1] - reach), (middle[0] + radius, middle[1] + radius)
        )
        ahead, left = self._turned(window, middle, math.radians(225.0))
        along = ahead - np.clip(ahead, 0.0, math.sqrt(2.0) * length)
        self._values[window][np.hypot(along, left) <= radius] *= np.float32(light)

    def diamond(self, middle: Point, size: float, tone: Tone) -> None:
        """Fill a square that stands on a corner; `size` is half its diagonal [m]."""
        window = self._window(
            (middle[0] - size, middle[1] - size), (middle[0] + size, middle[1] + size)
        )
        ahead, left = self._turned(window, middle, 0.0)
        self._values[window][np.abs(ahead) + np.abs(left) <= size] = tone

    def arrow(self, middle: Point, heading: float, size: float, tone: Tone) -> None:
        """Fill an arrowhead that points to a heading [rad]; `size` is half its length [m]."""
        window = self._window(
            (middle[0] - size, middle[1] - size), (middle[0] + size, middle[1] + size)
        )
        ahead, left = self._turned(window, middle, heading)
        # Half as wide as it is long at its rear.
        inside = (ahead >= -0.7 * size) & (np.abs(left) * 2.6 <= size - ahead)
        self._values[window][inside] = tone

    def cells(
        self,
        tones: npt.NDArray[np.float32],
        shown: npt.NDArray[np.bool_],
        cell: float,
        origin: Point,
    ) -> None:
        """Draw a grid.

        Args:
            tones: Colour of each cell, shape (rows, columns, 3).
            shown: Cells that are drawn, shape (rows, columns).
            cell: Side of a cell [m].
            origin: South-west corner of the grid [m].
        """
        rows, row_known = _numbers(self._y, origin[1], cell, len(shown))
        columns, column_known = _numbers(self._x, origin[0], cell, shown.shape[1])
        drawn = shown[rows[:, None], columns] & row_known[:, None] & column_known
        seen = np.minimum(tones[rows[:, None], columns], 255.0)
        self._values[drawn] = seen[drawn]

    def text(self, text: str, middle: Point, height: float, tone: Tone) -> None:
        """Write digits, dots and `m`, so high [m], around a point."""
        dot = height / 5
        x = middle[0] - (4 * len(text) - 1) * dot / 2
        for glyph in text:
            for row, bits in enumerate(_GLYPHS[glyph]):
                y = middle[1] + height / 2 - (row + 1) * dot
                for column in range(3):
                    if int(bits) >> (2 - column) & 1:
                        left = x + column * dot
                        self.fill((left, y), (left + dot, y + dot), tone)
            x += 4 * dot

    def scale_bar(self) -> None:
        """A bar in the south-west corner, black and white by turns, with its length."""
        width = self._values.shape[1] * self._fine
        length = max((each for each in _BAR_LENGTHS if each <= _BAR_SHARE * width), default=0.5)
        x, y = self._low[0] + 12 * self.pixel, self._low[1] + 10 * self.pixel
        pieces = max(1, round(length))
        thick = 5 * self.pixel
        rim = self.pixel
        self.fill((x - rim, y - rim), (x + length + rim, y + thick + rim), BLACK)
        for number in range(0, pieces, 2):
            piece = length / pieces
            self.fill((x + number * piece, y), (x + (number + 1) * piece, y + thick), WHITE)
        high = 15 * self.pixel
        place = (x + length + 2.2 * high, y + thick / 2)
        for right, up in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            beside = (place[0] + right * rim, place[1] + up * rim)
            self.text(f"{length:g} m", beside, high, WHITE)
        self.text(f"{length:g} m", place, high, BLACK)

    def _window(self, low: Point, high: Point) -> Window:
        """Rows and columns whose middles are within a rectangle."""
        rows = slice(*np.searchsorted(self._y, (low[1], high[1])).tolist())
        return rows, slice(*np.searchsorted(self._x, (low[0], high[0])).tolist())

    def _disc(
        self, middle: Point, radius: float
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        window = self._window(
            (middle[0] - radius, middle[1] - radius), (middle[0] + radius, middle[1] + radius)
        )
        ahead, left = self._turned(window, middle, 0.0)
        return self._values[window], np.hypot(ahead, left) <= radius

    def _turned(
        self, window: Window, middle: Point, heading: float
    ) -> tuple[npt.NDArray[np.floating], npt.NDArray[np.floating]]:
        """Places ahead of a point and left of it, in the direction of a heading [m]."""
        x, y = self._x[window[1]] - middle[0], (self._y[window[0]] - middle[1])[:, None]
        cos, sin = math.cos(heading), math.sin(heading)
        return x * cos + y * sin, y * cos - x * sin


def _numbers(
    places: npt.NDArray[np.floating], first: float, cell: float, count: int
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.bool_]]:
    """Cells of places along one axis, and which of the places are on the grid."""
    numbers = np.floor((places - first) / cell).astype(np.intp)
    return numbers.clip(0, count - 1), (numbers >= 0) & (numbers < count)
