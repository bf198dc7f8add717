"""Finds the cells of a view in which pictures of layers are visible."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from operator import attrgetter

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.compositor.blend import Layer, tinted_colours
from rune_tui.compositor.cells import Cells
from rune_tui.raster.placed_picture import PlacedPicture

_WORDS = np.dtype(np.uint32)
_NO_TINT = (255, 255, 255)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenPicture:
    """A picture in a view.

    Attributes:
        picture: The part of it in the view, in the view's pixels.
        seen: Cells that show only the picture, shape (rows, columns). At the picture's edge, the
            other half of a cell may show its neighbour.
    """

    picture: PlacedPicture
    seen: npt.NDArray[np.bool_]


def seen_pictures(
    cells: Cells, layers: Iterable[Layer], tint: tuple[int, int, int] = _NO_TINT
) -> tuple[SeenPicture, ...]:
    """Pictures that cells show, from back to front.

    A picture is visible in cells that still have the means of its pixels: nothing covers it there.

    Args:
        cells: The composed layers, without tint.
        layers: The layers, in any order; of equal `zpos` the later one is nearer.
        tint: Tint of the pictures, as in `tinted`.
    """
    found = []
    for layer in sorted(layers, key=attrgetter("zpos")):
        for placed in () if layer.transparency else layer.canvas.pictures:
            picture = placed.moved(layer.x, layer.y, cells.columns, 2 * cells.rows)
            if picture is not None:
                seen = _seen(cells, picture)
                if min(tint) < max(_NO_TINT):
                    pixels = tinted_colours(picture.pixels, tint)
                    picture = dataclasses.replace(picture, pixels=pixels)
                found.append(SeenPicture(picture=picture, seen=seen))
    return tuple(found)


def _seen(cells: Cells, picture: PlacedPicture) -> npt.NDArray[np.bool_]:
    """Cells that show only the picture, shape (rows, columns)."""
    height, width = picture.means.shape[:2]
    across = slice(picture.x, picture.x + width)
    down = slice(picture.y, picture.y + height)
    first, end = down.start // 2, (down.stop + 1) // 2
    # Half cells above and below the picture count as equal.
    same = np.ones((2 * (end - first), width), np.bool_)
    shown = cells.pixels[down, across].view(_WORDS) == picture.means.view(_WORDS)
    same[down.start - 2 * first : down.stop - 2 * first] = shown[..., 0]
    seen = np.zeros(cells.glyphs.shape, np.bool_)
    seen[first:end, across] = same[0::2] & same[1::2] & (cells.glyphs[first:end, across] == 0)
    return seen
