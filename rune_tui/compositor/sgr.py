"""How colours are told to a terminal of each depth (SGR, ECMA-48), as words of four bytes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from rune_tui.compositor.blend import RGB_MASK
from rune_tui.compositor.depth import ColourDepth

Words = npt.NDArray[np.uint32]

RESET: Final = b"\x1b[0m"
NO_COLOUR: Final = np.uint32(0xFFFFFFFF)
"""No colour of which only some bytes count: the others are zero."""


def words(tokens: Sequence[bytes]) -> Words:
    """Tokens of up to four bytes as words that read the same in memory."""
    return np.frombuffer(b"".join(token.ljust(4, b"\0") for token in tokens), np.uint32)


def _number(number: int) -> np.uint32:
    """A colour of which only the number counts."""
    return np.uint32(np.array([0, 0, 0, number], np.uint8).view(np.uint32)[0])


_DIGITS = words([b";%d" % value for value in range(256)])


@dataclass(frozen=True, kw_only=True)  # without slots, for what it keeps
class Form:
    """How cells of one depth are written.

    Attributes:
        cell: The words of a cell; those of its colours and its glyph are still empty.
        foreground: Where what sets the foreground stands, with the semicolon after it; nowhere,
            if it is the other one of two.
        background: Where what sets the background stands, with the semicolon before it.
        ink: Where the foreground itself begins, behind which there is a word that stays the same.
        ground: Where the background itself begins, likewise.
        ink_words: What stands there by the value of each byte of a colour that counts.
        ground_words: The same of the background.
        numbered: Whether only the last byte of a colour counts, its number; else the others do.
        bright: Cells of one colour from this one on are full of it as foreground.
        at_start: The background in force where a row begins; where it is a colour, rows that end
            in it need no reset, and cells full of foreground need it.
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
        """Keeps the bytes that count of a colour read as one word."""
        return np.uint32(~RGB_MASK if self.numbered else RGB_MASK)

    @cached_property
    def outlines(self) -> Words:
        """The words of a cell that tells nothing, its foreground, its background, and both."""
        places = np.arange(len(self.cell))
        in_ink = (places >= self.foreground.start) & (places < self.foreground.stop)
        in_ground = (places >= self.background.start) & (places < self.background.stop)
        apart = in_ink ^ in_ground
        told = [
            np.zeros_like(in_ink),
            (apart & in_ink) | ~(in_ink | in_ground),
            (apart & in_ground) | ~(in_ink | in_ground),
            np.ones_like(in_ink),
        ]
        return np.where(told, self.cell, np.uint32(0))


_ESCAPE = b"\x1b["
# The semicolon between the colours goes with either of them.
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
