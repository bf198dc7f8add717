"""Blends layers of pixels and text, back to front, into one screen of cells.

Integer arithmetic; shares of 255 are rounded to the nearest integer, so 0 and 255 are exact.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from operator import attrgetter

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgencies, Urgency

_HALF = 128
_OPAQUE = 255
_WORDS = np.dtype(np.uint32)
# Selects red, green and blue of a pixel read as one word, on either byte order.
RGB_MASK = np.array([255, 255, 255, 0], np.uint8).view(_WORDS)[0]


@dataclass(frozen=True, slots=True, kw_only=True)
class Layer:
    """A canvas and its place in the view.

    Attributes:
        canvas: The drawing; pixels of alpha 0 are clear.
        x: Column of its left edge in the view [pixels]; may be outside.
        y: Row of its upper edge in the view [pixels]; may be outside.
        zpos: Larger is nearer to the eye.
        transparency: 0 (opaque) to 255 (invisible).
        urgency: Order in which a slow terminal gets it.
    """

    canvas: Canvas
    x: int
    y: int
    zpos: int = 0
    transparency: int = 0
    urgency: Urgency = Urgency.OTHER


@dataclass(frozen=True, slots=True)
class _Window:
    """The part of the view that a layer covers, [left, right) x [top, bottom) in pixels."""

    left: int
    top: int
    right: int
    bottom: int


def compose(
    columns: int, rows: int, background: tuple[int, int, int], layers: Iterable[Layer]
) -> Cells:
    """Blend layers over a background.

    A character is drawn in its ink over the mean of its cell's two pixels. A nearer layer that
    covers both pixels by at least half hides the character; weaker cover tints it.

    Args:
        columns: Width of the view [cells].
        rows: Height of the view [cells].
        background: Red, green, blue behind all layers.
        layers: In any order; of equal `zpos` the later one is nearer.
    """
    pixels = np.zeros((2 * rows, columns, 4), np.uint8)
    pixels[..., :3] = background
    cells = Cells(
        pixels=pixels,
        glyphs=np.zeros((rows, columns), np.uint32),
        ink=np.zeros((rows, columns, 4), np.uint8),
    )
    for layer in sorted(layers, key=attrgetter("zpos")):
        if layer.transparency < 255:
            _lay(cells, layer)
    return cells


def urgencies_of(columns: int, rows: int, layers: Iterable[Layer]) -> Urgencies:
    """Urgency of each cell.

    A camera's picture counts where it is visible, also through nearer layers. Opaque pixels and
    characters in front of it count instead of it.
    """
    urgencies = np.full((rows, columns), Urgency.OTHER, np.uint8)
    for layer in sorted(layers, key=attrgetter("zpos")):
        if layer.transparency == _OPAQUE:
            continue
        canvas = layer.canvas
        first = layer.y // 2
        upper, lower = max(0, layer.y), max(0, layer.y + canvas.height)
        left, right = max(0, layer.x), max(0, layer.x + canvas.width)
        covered = urgencies[upper // 2 : -(-lower // 2), left:right]
        if layer.urgency is Urgency.VIDEO or _hides_all(layer):
            covered[...] = layer.urgency
        elif canvas.glyphs.any():
            down, across = max(0, -first), max(0, -layer.x)
            glyphs = canvas.glyphs[down:, across:][: covered.shape[0], : covered.shape[1]]
            covered[: glyphs.shape[0], : glyphs.shape[1]][glyphs != 0] = layer.urgency
    return urgencies


def _hides_all(layer: Layer) -> bool:
    return layer.transparency == 0 and int(layer.canvas.pixels[..., 3].min()) == _OPAQUE


def mix(
    under: npt.NDArray[np.uint8], over: npt.NDArray[np.uint8], alpha: npt.NDArray[np.uint8]
) -> npt.NDArray[np.uint8]:
    """`over` on `under`: round((over * alpha + under * (255 - alpha)) / 255).

    Args:
        under: Any shape.
        over: Same shape.
        alpha: A shape that spreads over theirs.
    """
    weight = alpha.astype(np.uint16)
    total = over * weight
    total += under * (255 - weight)
    return _share_of_255(total)


def mean(first: npt.NDArray[np.uint8], second: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """floor((first + second) / 2) within eight bits."""
    return (first & second) + ((first ^ second) >> 1)


def _share_of_255(total: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """round(total / 255) for totals up to 255 * 255, after J. Blinn, "Three wrongs" (1995)."""
    total = total + _HALF
    total += total >> 8
    total >>= 8
    return total.astype(np.uint8)


def _window(cells: Cells, layer: Layer) -> _Window | None:
    """The part of the view that a layer covers; None if the layer lies outside."""
    window = _Window(
        max(0, layer.x),
        max(0, layer.y),
        min(cells.columns, layer.x + layer.canvas.width),
        min(2 * cells.rows, layer.y + layer.canvas.height),
    )
    empty = window.left >= window.right or window.top >= window.bottom
    return None if empty else window


def _lay(cells: Cells, layer: Layer) -> None:
    canvas, window = layer.canvas, _window(cells, layer)
    if window is None:
        return
    source = canvas.pixels[
        window.top - layer.y : window.bottom - layer.y,
        window.left - layer.x : window.right - layer.x,
    ]
    alpha = _faded(source[..., 3], layer.transparency)
    _cover_text(cells, window, source, alpha)
    target = cells.pixels[window.top : window.bottom, window.left : window.right]
    if alpha.min() == 255:
        target.view(_WORDS)[...] = source.view(_WORDS) & RGB_MASK
    elif alpha.any():
        target[..., :3] = mix(target[..., :3], source[..., :3], alpha[..., None])
    _lay_text(cells, layer)


def _faded(alpha: npt.NDArray[np.uint8], transparency: int) -> npt.NDArray[np.uint8]:
    if transparency == 0:
        return alpha
    return _share_of_255(alpha.astype(np.uint16) * np.uint16(255 - transparency))


def _cover_text(
    cells: Cells,
    window: _Window,
    source: npt.NDArray[np.uint8],
    alpha: npt.NDArray[np.uint8],
) -> None:
    """Hide or tint the characters that a layer's pixels cover."""
    first, end = window.top // 2, (window.bottom + 1) // 2
    glyphs = cells.glyphs[first:end, window.left : window.right]
    if not glyphs.any():
        return
    # Whole cells: if the layer ends inside a cell, the other half is not covered.
    width = window.right - window.left
    cover = np.zeros((2 * (end - first), width, 4), np.uint8)
    inside = slice(window.top - 2 * first, window.bottom - 2 * first)
    cover[inside, :, :3] = source[..., :3]
    cover[inside, :, 3] = alpha
    halves = cover.reshape(end - first, 2, width, 4)
    least = halves[..., 3].min(axis=1)
    tint = mean(halves[:, 0, :, :3], halves[:, 1, :, :3])
    ink = cells.ink[first:end, window.left : window.right, :3]
    ink[...] = mix(ink, tint, least[..., None])
    glyphs[least >= _HALF] = 0


def _lay_text(cells: Cells, layer: Layer) -> None:
    """Write a layer's characters over the layers behind it."""
    first_row = layer.y // 2
    top, bottom = max(0, first_row), min(cells.rows, first_row + layer.canvas.rows)
    left, right = max(0, layer.x), min(cells.columns, layer.x + layer.canvas.width)
    if top >= bottom or left >= right:
        return
    inside = slice(top - first_row, bottom - first_row), slice(left - layer.x, right - layer.x)
    new, ink = layer.canvas.glyphs[inside], layer.canvas.ink[inside]
    if not new.any():
        return
    old = cells.glyphs[top:bottom, left:right]
    alpha = _faded(ink[..., 3], layer.transparency)
    wins = (new > 0) & (alpha > 0) & ((alpha >= _HALF) | (old == 0))
    upper = cells.pixels[2 * top : 2 * bottom : 2, left:right]
    lower = cells.pixels[2 * top + 1 : 2 * bottom : 2, left:right]
    ground = mean(upper[wins], lower[wins])
    old[wins] = new[wins]
    inked = cells.ink[top:bottom, left:right]
    inked[wins, :3] = mix(ground[:, :3], ink[wins, :3], alpha[wins, None])


def tinted(cells: Cells, tint: tuple[int, int, int]) -> Cells:
    """Cells with all colours scaled by a tint: the share of red, green, blue that stays, of 255."""
    if min(tint) == _OPAQUE:
        return cells
    pixels, ink = tinted_colours(cells.pixels, tint), tinted_colours(cells.ink, tint)
    return dataclasses.replace(cells, pixels=pixels, ink=ink)


def tinted_colours(
    colours: npt.NDArray[np.uint8], tint: tuple[int, int, int]
) -> npt.NDArray[np.uint8]:
    """Colours scaled by a tint, as in `tinted`; any shape (..., 4)."""
    scale = np.array((*tint, _OPAQUE), np.uint16)
    return ((colours * scale + _HALF) // _OPAQUE).astype(np.uint8)
