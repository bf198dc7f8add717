"""The surface that visualizers draw on: pixels with alpha, characters and pictures."""

from __future__ import annotations

import functools
import unicodedata
from dataclasses import field

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.model import theme
from rune_tui.raster.placed_picture import PlacedPicture
from rune_tui.raster.resize import resized

Colour = theme.Colour
"""Red, green, blue, alpha, each 0 to 255; alpha 0 is clear."""

REPLACEMENT = "?"
"""Replaces a character that does not take exactly one cell of a terminal."""

_BRIGHT = 255
_DROPPED = frozenset({"Mn", "Me"})
# Missing in Python's tables: Hangul vowels and final consonants join the syllable before them;
# symbols that Unicode 16 made wide, and regional indicators, which terminals pair into flags.
_OTHER_WIDTHS = (
    (0x1160, 0x11FF),
    (0xD7B0, 0xD7FF),
    (0xFFA0, 0xFFA0),
    (0x2630, 0x2637),
    (0x268A, 0x268F),
    (0x4DC0, 0x4DFF),
    (0x1D300, 0x1D356),
    (0x1D360, 0x1D376),
    (0x1F1E6, 0x1F1FF),
)


@functools.lru_cache(maxsize=4096)
def printable(character: str) -> str:
    """A character that takes exactly one cell of a terminal; empty for combining marks.

    Control, unassigned, private and double-width characters become `REPLACEMENT`, blanks a space.
    """
    category = unicodedata.category(character)
    if category in _DROPPED:
        return ""
    if category == "Zs":
        return " "
    wide = unicodedata.east_asian_width(character) in {"W", "F"}
    wide |= any(first <= ord(character) <= last for first, last in _OTHER_WIDTHS)
    if wide or category[0] == "C" or category in {"Zl", "Zp", "Mc"}:
        return REPLACEMENT
    return character


@functools.lru_cache(maxsize=4096)
def printable_text(string: str) -> str:
    """A string with `printable` applied to each character."""
    return "".join(map(printable, unicodedata.normalize("NFC", string)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Canvas:
    """Pixels and characters; a character covers a cell of 1 x 2 pixels.

    Attributes:
        pixels: Red, green, blue, alpha, shape (height, width, 4).
        glyphs: Code points, shape (ceil(height / 2), width); 0 for no character.
        ink: Red, green, blue, alpha of the characters, shape (ceil(height / 2), width, 4).
        scale: Pixels of pictures across and down one pixel of the canvas.
        pictures: Pictures with more pixels than the canvas, in the order of placing.
    """

    pixels: npt.NDArray[np.uint8]
    glyphs: npt.NDArray[np.uint32]
    ink: npt.NDArray[np.uint8]
    scale: tuple[int, int] = (1, 1)
    pictures: list[PlacedPicture] = field(default_factory=list)

    @classmethod
    def blank(cls, width: int, height: int, *, scale: tuple[int, int] = (1, 1)) -> Canvas:
        """A clear canvas of this width and height [pixels]; `scale` as the attribute."""
        rows = (height + 1) // 2
        return cls(
            pixels=np.zeros((height, width, 4), np.uint8),
            glyphs=np.zeros((rows, width), np.uint32),
            ink=np.zeros((rows, width, 4), np.uint8),
            scale=scale,
        )

    @property
    def width(self) -> int:
        """Width [pixels], which is also the width in cells."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Height [pixels]."""
        return int(self.pixels.shape[0])

    @property
    def rows(self) -> int:
        """Height in cells; the last cell may be half outside."""
        return int(self.glyphs.shape[0])

    def fill(self, colour: Colour) -> None:
        """Give every pixel this colour."""
        self.pixels[...] = colour

    def paste(self, pixels: npt.NDArray[np.uint8], x: int, y: int) -> None:
        """Lay an opaque picture on the canvas, clipped at its edges.

        Args:
            pixels: Red, green, blue, shape (height, width, 3).
            x: Column of its left edge [pixels]; may be outside.
            y: Row of its upper edge [pixels]; may be outside.
        """
        left, top = max(0, x), max(0, y)
        right = min(self.width, x + pixels.shape[1])
        bottom = min(self.height, y + pixels.shape[0])
        if left >= right or top >= bottom:
            return
        target = self.pixels[top:bottom, left:right]
        target[..., :3] = pixels[top - y : bottom - y, left - x : right - x]
        target[..., 3] = 255

    def place_picture(
        self,
        pixels: npt.NDArray[np.uint8],
        x: int,
        y: int,
        size: tuple[int, int],
        *,
        brightness: int = _BRIGHT,
    ) -> None:
        """Lay an opaque picture on the canvas, clipped at its edges.

        The canvas shows the means of the picture's pixels. Where nothing covers them, an output may
        show the pixels themselves.

        Args:
            pixels: Red, green, blue, shape (h, w, 3), of any size.
            x: Column of its left edge [pixels of the canvas]; may be outside.
            y: Row of its upper edge [pixels of the canvas]; may be outside.
            size: Width and height on the canvas [pixels of the canvas].
            brightness: Share of brightness that stays, of 255.
        """
        left, top = max(0, x), max(0, y)
        width = min(self.width, x + size[0]) - left
        height = min(self.height, y + size[1]) - top
        if width <= 0 or height <= 0:
            return
        part = None
        if (width, height) != size:
            rows, columns = pixels.shape[:2]
            part = (
                (left - x) * columns / size[0],
                (top - y) * rows / size[1],
                (left - x + width) * columns / size[0],
                (top - y + height) * rows / size[1],
            )
        shown = resized(pixels, self.scale[0] * width, self.scale[1] * height, part)
        if brightness != _BRIGHT:
            shown = (shown * np.uint16(brightness) // np.uint16(_BRIGHT)).astype(np.uint8)
        if self.scale != (1, 1):
            placed = PlacedPicture.of(shown, left, top, self.scale)
            self.pictures.append(placed)
            shown = placed.means[..., :3]
        self.paste(shown, left, top)

    def text(self, column: int, row: int, string: str, colour: Colour) -> None:
        """Write characters, clipped at the edges; the pixels under them stay.

        Args:
            column: Cell column of the first character; may be outside.
            row: Cell row; may be outside.
            string: The text; shown as `printable_text`.
            colour: Colour of the characters.
        """
        if not 0 <= row < self.rows:
            return
        shown = printable_text(string)
        first = max(0, column)
        end = min(self.width, column + len(shown))
        if first >= end:
            return
        self.glyphs[row, first:end] = [ord(c) for c in shown[first - column : end - column]]
        self.ink[row, first:end] = colour
