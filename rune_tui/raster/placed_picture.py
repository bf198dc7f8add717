"""A picture in its own pixels, and its place."""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

from hub.values import dataclass

_LANES = np.uint32(0x00FF00FF)
"""Mask of every second byte of a pixel; the sum of 257 pixels fits into its sixteen bits."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedPicture:
    """An opaque picture with more pixels than its ground, a canvas or a view.

    Attributes:
        pixels: Red, green, blue, zero; shape (down * height, across * width, 4).
        means: The picture in pixels of the ground, rounded down, shape (height, width, 4).
        x: Column of its left edge [pixels of the ground].
        y: Row of its upper edge [pixels of the ground].
        scale: Its pixels across and down one pixel of the ground.
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
            scale: Its pixels across and down one pixel of the ground, at most 256 in all.
        """
        words = np.zeros((*pixels.shape[:2], 4), np.uint8)
        words[..., :3] = pixels
        return cls(pixels=words, means=_means(words, *scale), x=x, y=y, scale=scale)

    def moved(self, x: int, y: int, width: int, height: int) -> Self | None:
        """The part of the picture on the next ground behind; None if it lies outside.

        Args:
            x: Column of this ground's left edge on the next.
            y: Row of this ground's upper edge on the next.
            width: Width of the next ground.
            height: Height of the next ground.
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
