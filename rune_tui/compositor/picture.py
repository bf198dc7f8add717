"""Writes views as files: PNG, SVG or plain text."""

from __future__ import annotations

import functools
import io
import math
from collections.abc import Collection
from html import escape  # noqa: TID251 - of single characters that can be printed
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from hub import files
from rune_tui.compositor.blend import mean
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.drawn_glyphs import drawn_glyph
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.compositor.looks import looks_of, unpacked
from rune_tui.compositor.output import Frame, Output
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.errors import PictureFileError
from rune_tui.raster.urgency import Urgencies

SUFFIXES = (".txt", ".svg", ".png")

_RAMP = np.array([ord(c) for c in " .:-=+*#%@"], np.uint32)
_HALVES = np.array([ord(c) for c in " ▄▀█"], np.uint32)
_SHADES = {0x2591: 1, 0x2592: 2, 0x2593: 3}
"""Shade characters, and the quarters of the cell that their dots fill."""
_DOTS = np.array([[0, 2], [3, 1]])
"""Least number of quarters that sets each dot."""
_LUMA = np.array([299, 587, 114], np.uint32)  # ITU-R BT.601, thousandths


class PictureFile(Output):
    """A file that shows a view as a terminal does; its suffix gives the format."""

    def __init__(
        self,
        path: Path,
        *,
        depth: ColourDepth = ColourDepth.TRUECOLOUR,
        glyphs: GlyphSet = GlyphSet.HALF,
    ) -> None:
        """Prepare.

        Args:
            path: The file.
            depth: The terminal's colours; in truecolour, cells stay as they are.
            glyphs: The terminal's characters for pixels.

        Raises:
            PictureFileError: The suffix is not in `SUFFIXES`.
        """
        self._path, self._depth, self._glyphs = path, depth, glyphs.at(depth)
        if path.suffix.lower() not in SUFFIXES:
            text = f"{path}: a picture file ends in {', '.join(SUFFIXES)}; name it so"
            raise PictureFileError(text)

    @property
    def pixels_per_cell(self) -> tuple[int, int]:
        """Pixels of a picture across and down a cell."""
        return self._glyphs.pixels_per_cell

    def draw(
        self,
        cells: Cells,
        pictures: Collection[SeenPicture],
        urgencies: Urgencies | None = None,
    ) -> Frame:
        """The content of the file.

        Args:
            cells: The view.
            pictures: Pictures in it with more pixels than the cells, from back to front.
            urgencies: Not used.
        """
        del urgencies
        cells, suffix = at_depth(cells, self._depth), self._path.suffix.lower()
        if suffix == ".png":
            file = io.BytesIO()
            image(cells, pictures).save(file, "PNG")
            return Frame(first=file.getvalue())
        text = svg(cells, pictures) if suffix == ".svg" else plain_text(cells)
        return Frame(first=text.encode())

    def write(self, frame: Frame) -> None:
        """Write a frame to the file.

        Raises:
            PictureFileError: The file cannot be written.
        """
        try:
            files.write_output(self._path, frame.first, sync=False)
        except OSError as error:
            why = error.strerror or error
            text = f"{self._path} cannot be written: {why}; choose another place"
            raise PictureFileError(text) from error


def image(cells: Cells, pictures: Collection[SeenPicture] = (), *, scale: int = 8) -> Image.Image:
    """A picture of the cells, as on a terminal.

    Args:
        cells: The frame.
        pictures: Pictures in them with two pixels per column.
        scale: Width and height of a cell's half [pixels of the result].
    """
    shown = unpacked(looks_of(cells, pictures).quarters)
    picture = Image.fromarray(np.ascontiguousarray(shown[..., :3]))
    size = (cells.columns * scale, 2 * cells.rows * scale)
    picture = picture.resize(size, Image.Resampling.NEAREST)
    _shade(picture, cells, scale)
    for row, column in _characters(cells):
        red, green, blue = cells.ink[row, column, :3].tolist()
        mask = _glyph(_visible(int(cells.glyphs[row, column])), scale)
        picture.paste((red, green, blue), (column * scale, 2 * row * scale), mask)
    return picture


@functools.lru_cache(maxsize=1024)
def _glyph(glyph: str, scale: int) -> Image.Image:
    """Mask of a character's ink in the middle of its cell; a wide character becomes narrower."""
    if drawn := drawn_glyph(glyph, scale):
        return drawn
    font = ImageFont.load_default(1.6 * scale)
    width = max(scale, math.ceil(font.getlength(glyph)))
    mask = Image.new("L", (width, 2 * scale))
    ImageDraw.Draw(mask).text((width / 2, 1.55 * scale), glyph, 255, font, anchor="ms")
    return mask.resize((scale, 2 * scale), Image.Resampling.LANCZOS) if width > scale else mask


def plain_text(cells: Cells) -> str:
    """The cells as text: a cell without a character becomes a character of the same density.

    Without colours, half blocks show the pixels exactly.
    """
    upper, lower = cells.pixels[0::2], cells.pixels[1::2]
    if cells.depth is ColourDepth.MONO:
        shades = _HALVES[2 * upper[..., 3] + lower[..., 3]]
    else:
        brightness = mean(upper, lower)[..., :3] @ _LUMA // 1000
        shades = _RAMP[brightness * len(_RAMP) // 256]
    lines = np.where(cells.glyphs > 0, cells.glyphs, shades).tolist()
    return "".join("".join(map(_visible, line)).rstrip() + "\n" for line in lines)


def svg(cells: Cells, pictures: Collection[SeenPicture] = (), *, scale: int = 8) -> str:
    """The cells as an SVG drawing: a rectangle for each run of one colour, then text.

    Args:
        cells: The frame.
        pictures: As for `image`.
        scale: Width and height of a cell's half [user units].
    """
    width, height = cells.columns * scale, 2 * cells.rows * scale
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}" shape-rendering="crispEdges">',
    ]
    wide = scale / 2
    for row, line in enumerate(unpacked(looks_of(cells, pictures).quarters)):
        parts += [
            f'<rect x="{first * wide:g}" y="{row * scale}" width="{(end - first) * wide:g}" '
            f'height="{scale}" fill="{_hexadecimal(line[first])}"/>'
            for first, end in _runs(line[:, :3])
        ]
    for row, column in np.argwhere(np.isin(cells.glyphs, list(_SHADES))).tolist():
        share = _SHADES[int(cells.glyphs[row, column])] / 4
        parts.append(
            f'<rect x="{column * scale}" y="{2 * row * scale}" width="{scale}" '
            f'height="{2 * scale}" fill="{_hexadecimal(cells.ink[row, column])}" '
            f'fill-opacity="{share}"/>'
        )
    parts.append(
        f'<g font-family="monospace" font-size="{1.6 * scale:g}" text-anchor="middle" '
        'xml:space="preserve">'
    )
    for row, column in _characters(cells):
        glyph = escape(_visible(int(cells.glyphs[row, column])), quote=False)
        parts.append(
            f'<text x="{(column + 0.5) * scale:g}" y="{(2 * row + 1.55) * scale:g}" '
            f'fill="{_hexadecimal(cells.ink[row, column])}">{glyph}</text>'
        )
    return "\n".join([*parts, "</g>", "</svg>", ""])


def _characters(cells: Cells) -> list[tuple[int, int]]:
    """Row and column of each character that the font draws."""
    drawn = (cells.glyphs > ord(" ")) & ~np.isin(cells.glyphs, list(_SHADES))
    return [(row, column) for row, column in np.argwhere(drawn).tolist()]


def _shade(picture: Image.Image, cells: Cells, scale: int) -> None:
    """Draw the shade characters as dots, as terminals do."""
    for shade, quarters in _SHADES.items():
        where = cells.glyphs == shade
        if where.any():
            dots = np.tile(quarters > _DOTS, (cells.rows * scale, -(-cells.columns * scale // 2)))
            mask = np.kron(where, np.ones((2 * scale, scale), bool))
            mask &= dots[:, : mask.shape[1]]
            ink = Image.fromarray(np.ascontiguousarray(cells.ink[..., :3]))
            ink = ink.resize(picture.size, Image.Resampling.NEAREST)
            picture.paste(ink, mask=Image.fromarray(mask))


def _runs(line: npt.NDArray[np.uint8]) -> list[tuple[int, int]]:
    """First and one past last column of each run of one colour; line of shape (columns, 3)."""
    edges = np.flatnonzero((line[1:] != line[:-1]).any(axis=1)) + 1
    ends = [*edges.tolist(), len(line)]
    return list(zip([0, *edges.tolist()], ends, strict=True)) if len(line) else []


def _hexadecimal(colour: npt.NDArray[np.uint8]) -> str:
    return f"#{int(colour[0]):02x}{int(colour[1]):02x}{int(colour[2]):02x}"


def _visible(code_point: int) -> str:
    """The character, or "?" for one that a file cannot hold (control, surrogate, non-character)."""
    glyph = chr(code_point) if code_point <= 0x10FFFF else "?"
    fits = glyph.isprintable() and code_point not in {0xFFFE, 0xFFFF}
    return glyph if fits else "?"
