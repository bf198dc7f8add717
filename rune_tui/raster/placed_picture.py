"""A picture in pixels of its own, and where it lies."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

_LANES = np.uint32(0x00FF00FF)
"""Every other byte of a pixel; sixteen bits for each hold the sum of 257 pixels."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedPicture:
    """An opaque picture that has more pixels than what it lies on.

    Attributes:
        pixels: Red, green, blue, zero; shape (down * height, across * width, 4).
        means: The picture in the pixels of what it lies on, rounded down, shape (height, width, 4).
        x: Column of its left edge [pixels of what it lies on].
        y: Row of its upper edge [pixels of what it lies on].
        scale: Its pixels across and down one of what it lies on.
    """

    pixels: npt.NDArray[np.uint8]
    means: npt.NDArray[np.uint8]
    x: int
    y: int
    scale: tuple[int, int]

    @classmethod
    def of(cls, pixels: npt.NDArray[np.uint8], x: int, y: int, scale: tuple[int, int]) -> Self:
        """A picture at a place.

        Args:
            pixels: Red, green, blue, shape (down * height, across * width, 3).
            x: Column of its left edge.
            y: Row of its upper edge.
            scale: Its pixels across and down one of what it lies on, 256 of them at most.
        """
        words = np.zeros((*pixels.shape[:2], 4), np.uint8)
        words[..., :3] = pixels
        return cls(pixels=words, means=_means(words, *scale), x=x, y=y, scale=scale)

    def moved(self, x: int, y: int, width: int, height: int) -> Self | None:
        """The picture on what is behind, and only what of it lies there; None: nothing of it.

        Args:
            x: Column of the left edge of what it lies on now.
            y: Row of the upper edge of what it lies on now.
            width: Width of what is behind.
            height: Height of what is behind.
        """
        x, y = x + self.x, y + self.y
        rows, columns = self.means.shape[:2]
        left, top = max(0, -x), max(0, -y)
        right, bottom = min(columns, width - x), min(rows, height - y)
        if left >= right or top >= bottom:
            return None
        across, down = self.scale
        return dataclasses.replace(
            self,
            pixels=self.pixels[down * top : down * bottom, across * left : across * right],
            means=self.means[top:bottom, left:right],
            x=x + left,
            y=y + top,
        )


def _means(pixels: npt.NDArray[np.uint8], across: int, down: int) -> npt.NDArray[np.uint8]:
    """The mean of each block of pixels, rounded down; shape (height, width, 4)."""
    words = pixels.view(np.uint32)[..., 0]
    blocks = [words[y::down, x::across] for y in range(down) for x in range(across)]
    even, odd = blocks[0] & _LANES, blocks[0] >> 8 & _LANES
    for block in blocks[1:]:
        even += block & _LANES
        odd += block >> 8 & _LANES
    for lanes in (even, odd):
        sums = lanes.view(np.uint16)
        sums //= np.uint16(len(blocks))
    return (even | odd << 8)[..., None].view(np.uint8)
