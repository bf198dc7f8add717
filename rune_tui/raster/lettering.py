"""Draws large text of TrueType fonts on the pixels of a canvas.

A point is a pixel, and a pixel is half a cell: text of 12 points is 6 rows of cells high.
"""

from __future__ import annotations

import functools
import io
import math
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from hub.files import read_regular
from hub.values import dataclass
from rune_tui.errors import FontError
from rune_tui.raster.canvas import Canvas, Colour

SMALLEST_PT: Final = 4.0
LARGEST_PT: Final = 200.0
LONGEST: Final = 128
"""Most characters of a text that are drawn; no view is wide enough for more."""

_LARGEST_FILE: Final = 64 * 1024 * 1024
"""Longest file of a font [bytes]; large ones have the letters of all languages."""
_FONTS_KEPT: Final = 16
_TEXTS_KEPT: Final = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Font:
    """A TrueType font in one size.

    Attributes:
        file: Path of its file; empty for the built-in font.
        points: Its size, SMALLEST_PT to LARGEST_PT.
    """

    file: str = ""
    points: float = 16.0


def check_font(font: Font) -> None:
    """Check that a font can be drawn.

    Raises:
        FontError: The file cannot be read or is no font, or the size is out of range.
    """
    _loaded(font)


def measured(string: str, font: Font) -> tuple[int, int]:
    """Width and height of a text [pixels]; a font gives all texts the same height.

    Raises:
        FontError: As `check_font`.
    """
    height, width = _coverage(_shown(string), font).shape
    return width, height


def letter(
    canvas: Canvas,
    at: tuple[float, float],
    string: str,
    font: Font,
    colour: Colour,
    *,
    align: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Draw one line of text on a canvas, clipped at its edges.

    Args:
        canvas: The canvas.
        at: x and y [pixels]; may be outside.
        string: The text; line breaks and tabs become spaces.
        font: Its font.
        colour: Its colour and alpha.
        align: The point of the text at `at`: (0, 0) its upper left corner, (0.5, 0.5) its
            middle, (1, 1) its lower right corner.

    Raises:
        FontError: As `check_font`.
    """
    coverage = _coverage(_shown(string), font)
    height, width = coverage.shape
    x, y = round(at[0] - align[0] * width), round(at[1] - align[1] * height)
    left, top = max(0, x), max(0, y)
    right, bottom = min(canvas.width, x + width), min(canvas.height, y + height)
    if left >= right or top >= bottom:
        return
    ink = np.empty((bottom - top, right - left, 4), np.uint8)
    ink[..., :3] = colour[:3]
    share = coverage[top - y : bottom - y, left - x : right - x].astype(np.uint16) * colour[3]
    ink[..., 3] = (share + 127) // 255
    under = canvas.pixels[top:bottom, left:right]
    over = Image.alpha_composite(Image.fromarray(np.ascontiguousarray(under)), Image.fromarray(ink))
    under[...] = np.asarray(over)


def _shown(string: str) -> str:
    return "".join(" " if c.isspace() else c for c in string[:LONGEST])


@functools.lru_cache(maxsize=_FONTS_KEPT)
def _loaded(font: Font) -> ImageFont.FreeTypeFont:
    name = font.file or "the built-in font"
    if not SMALLEST_PT <= font.points <= LARGEST_PT:
        message = (
            f"{name}: {font.points:g} points cannot be drawn; "
            f"give {SMALLEST_PT:g} to {LARGEST_PT:g}"
        )
        raise FontError(message)
    if not font.file:
        built_in = ImageFont.load_default(font.points)
        if isinstance(built_in, ImageFont.FreeTypeFont):
            return built_in
        message = "Pillow was built without FreeType and cannot draw text; install its wheel"
        raise FontError(message)
    try:
        # Opened here: Pillow would search the system's folders for a file that is missing.
        content = io.BytesIO(read_regular(Path(font.file), _LARGEST_FILE))
        return ImageFont.truetype(content, font.points)
    except (OSError, ValueError) as error:
        known = error.strerror if isinstance(error, OSError) else str(error)
        reason = known or "it is no font that can be drawn; give a TrueType file"
        message = f"font {font.file}: {reason}"
        raise FontError(message) from error


@functools.lru_cache(maxsize=_TEXTS_KEPT)
def _coverage(string: str, font: Font) -> npt.NDArray[np.uint8]:
    """Coverage of each pixel by a text, 0 to 255, shape (height, width)."""
    loaded = _loaded(font)
    first, _, end, _ = loaded.getbbox(string, anchor="ls")
    ascent, descent = loaded.getmetrics()
    # Letters may reach beyond the start and the end of the line.
    first, end = math.floor(min(0.0, first)), math.ceil(max(end, loaded.getlength(string)))
    image = Image.new("L", (end - first, ascent + descent))
    ImageDraw.Draw(image).text((-first, ascent), string, 255, loaded, anchor="ls")
    coverage = np.asarray(image)
    coverage.flags.writeable = False
    return coverage
