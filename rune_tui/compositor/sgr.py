"""Colour codes of each depth (SGR, ECMA-48) as words of four bytes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.compositor.blend import RGB_MASK
from rune_tui.compositor.depth import ColourDepth

Words = npt.NDArray[np.uint32]

RESET: Final = b"\x1b[0m"
NO_COLOUR: Final = np.uint32(0xFFFFFFFF)
"""A value that no masked colour has."""


def words(tokens: Sequence[bytes]) -> Words:
    """Tokens of up to four bytes as words that read the same in memory."""
    return np.frombuffer(b"".join(token.ljust(4, b"\0") for token in tokens), np.uint32)


def _number(number: int) -> np.uint32:
    """A numbered colour as a word."""
    return np.uint32(np.array([0, 0, 0, number], np.uint8).view(np.uint32)[0])


_DIGITS = words([b";%d" % value for value in range(256)])


@dataclass(frozen=True, kw_only=True)  # without slots, for cached properties
class Form:
    """Encoding of cells at one depth.

    Attributes:
        cell: Words of a cell, with colours and glyph empty.
        foreground: Words that set the foreground, with the semicolon after; empty if the background
            decides the foreground.
        background: Words that set the background, with the semicolon before.
        ink: First word of the foreground's value; a constant word follows each.
        ground: First word of the background's value, as for `ink`.
        ink_words: Word of each value of a colour's byte.
        ground_words: The same for the background.
        numbered: Whether a colour is its last byte, the number; else its first three.
        bright: First colour that is shown as a cell full of foreground.
        at_start: Background at the start of a row. If it is a colour, rows that end in it need no
            reset, and cells full of foreground need it.
    """

    cell: Words
    foreground: slice
    background: slice
    ink: int
    ground: int
    ink_words: Words
    ground_words: Words
    numbered: bool = True
    bright: np.uint32 = NO_COLOUR
    at_start: np.uint32 = NO_COLOUR

    @property
    def mask(self) -> np.uint32:
        """Mask of the used bytes of a colour read as one word."""
        return np.uint32(~RGB_MASK if self.numbered else RGB_MASK)

    @cached_property
    def outlines(self) -> Words:
        """Words of a cell that sets no colour, the foreground, the background, or both."""
        places = np.arange(len(self.cell))
        in_ink = (places >= self.foreground.start) & (places < self.foreground.stop)
        in_ground = (places >= self.background.start) & (places < self.background.stop)
        apart = in_ink ^ in_ground
        codes = [
            np.zeros_like(in_ink),
            (apart & in_ink) | ~(in_ink | in_ground),
            (apart & in_ground) | ~(in_ink | in_ground),
            np.ones_like(in_ink),
        ]
        return np.where(codes, self.cell, np.uint32(0))


_ESCAPE = b"\x1b["
# Either colour may bring the semicolon between them.
_TRUECOLOUR = Form(
    cell=words([_ESCAPE, b"38;2", b"", b"", b"", b";", b"48;2", b"", b"", b"", b"m", b""]),
    foreground=slice(1, 6),
    background=slice(5, 10),
    ink=2,
    ground=7,
    ink_words=_DIGITS,
    ground_words=_DIGITS,
    numbered=False,
)
_256 = Form(
    cell=words([_ESCAPE, b"38;5", b"", b";", b"48;5", b"", b"m", b""]),
    foreground=slice(1, 4),
    background=slice(3, 6),
    ink=2,
    ground=5,
    ink_words=_DIGITS,
    ground_words=_DIGITS,
)
_16 = Form(
    cell=words([_ESCAPE, b"", b";", b"", b"m", b""]),
    foreground=slice(1, 3),
    background=slice(2, 4),
    ink=1,
    ground=3,
    ink_words=words([b"%d" % code for code in (*range(30, 38), *range(90, 98))]),
    ground_words=words([b"%d" % code for code in (*range(40, 48), *range(100, 108))]),
    bright=_number(8),  # as background, some terminals have the first eight only
)
_MONO = Form(
    cell=words([_ESCAPE, b"", b"m", b""]),
    foreground=slice(0, 0),
    background=slice(1, 2),
    ink=0,
    ground=1,
    ink_words=words([b""]),
    ground_words=words([b"27", b"7"]),
    bright=_number(1),
    at_start=np.uint32(0),
)
FORMS: Final[Mapping[ColourDepth, Form]] = {
    ColourDepth.TRUECOLOUR: _TRUECOLOUR,
    ColourDepth.INDEXED_256: _256,
    ColourDepth.INDEXED_16: _16,
    ColourDepth.MONO: _MONO,
}
