"""Characters and colours to write for cells, and which of the colours are visible."""

from __future__ import annotations

import numpy as np

from hub.values import dataclass
from rune_tui.compositor.glyph_set import LOWER_HALF, UPPER_HALF
from rune_tui.compositor.looks import SPACE, Flags, Looks
from rune_tui.compositor.quadrants import BLOCKS
from rune_tui.compositor.sgr import NO_COLOUR, Form, Words, words

_UPPER, _LOWER, _FULL, _BLANK = words(["▀".encode(), "▄".encode(), "█".encode(), b" "])
_SHAPES = words([BLOCKS.get(shape, "").encode() for shape in range(max(BLOCKS) + 1)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Planes:
    """Characters and colours in the order of writing; all of one shape.

    Attributes:
        foreground: Colours, masked by the form.
        background: Colours, masked by the form.
        marks: The characters in UTF-8.
        ink_shows: Where the foreground is visible.
        ground_shows: Where the background is visible.
    """

    foreground: Words
    background: Words
    marks: Words
    ink_shows: Flags
    ground_shows: Flags


def planes_of(looks: Looks, form: Form, half: str = UPPER_HALF) -> Planes:
    """Planes of cells, of shape (rows, columns).

    Args:
        looks: The cells.
        form: Encoding of their depth.
        half: The half block to use; with numbered colours, both are used.
    """
    first, second = looks.upper & form.mask, looks.lower & form.mask
    ink_shows = first != second
    ground_shows = np.ones_like(ink_shows)
    foreground, background, mark = first, second, _UPPER
    if half == LOWER_HALF:
        foreground, background, mark = second, first, _LOWER
    marks = np.where(ink_shows, mark, _BLANK)
    if form.numbered:
        # With few colours, neighbours often have the same two colours exchanged.
        foreground, background = np.maximum(first, second), np.minimum(first, second)
        marks = np.where(ink_shows, np.where(first < second, _LOWER, _UPPER), _BLANK)
        full = ~ink_shows & (first >= form.bright)
        marks[full] = _FULL
        ink_shows[full] = True
        background[full] = 0
        ground_shows[full] = form.at_start != NO_COLOUR
    if looks.shapes.any():
        place = np.nonzero(looks.shapes)
        foreground[place], background[place] = first[place], second[place]
        marks[place] = _SHAPES[looks.shapes[place]]
    if looks.written:
        place = np.nonzero(looks.glyphs)
        glyphs = looks.glyphs[place]
        background[place] = looks.lower[place] & form.mask
        foreground[place] = looks.ink[place] & form.mask
        ink_shows[place] = glyphs != SPACE
        ground_shows[place] = True
        marks[place] = _utf8(glyphs)
    return Planes(
        foreground=foreground,
        background=background,
        marks=marks,
        ink_shows=ink_shows,
        ground_shows=ground_shows,
    )


def _utf8(points: Words) -> Words:
    """Each code point in UTF-8, padded with zero bytes."""
    coded = np.zeros((points.size, 4), np.uint8)
    limits = (0, 0x80, 0x800, 0x10000, 0x110000)
    for length, lead in enumerate((0x00, 0xC0, 0xE0, 0xF0), start=1):
        chosen = np.flatnonzero((points >= limits[length - 1]) & (points < limits[length]))
        for index in range(length):
            bits = points[chosen] >> (6 * (length - 1 - index))
            coded[chosen, index] = (lead | bits) if index == 0 else (0x80 | (bits & 0x3F))
    return coded.view(np.uint32)[:, 0]
