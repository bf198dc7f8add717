"""Cells as picture, drawing and text."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.compositor.picture import PictureFile, image, plain_text, svg
from rune_tui.errors import PictureFileError
from tests.console.compositor.frames import in_quadrants
from tests.support.cases import for_each
from tests.support.full_disk import files_no_longer_than


@pytest.fixture
def cells() -> Cells:
    """Three cells by two: red over blue, white, and an "R" in green on the mean of 0 and 100."""
    pixels = np.zeros((4, 3, 4), np.uint8)
    pixels[0, 0, :3] = (255, 0, 0)
    pixels[1, 0, :3] = (0, 0, 255)
    pixels[0:2, 1, :3] = 255
    pixels[3, 2, :3] = 100
    glyphs = np.zeros((2, 3), np.uint32)
    glyphs[1, 2] = ord("R")
    ink = np.zeros((2, 3, 4), np.uint8)
    ink[1, 2, :3] = (0, 255, 0)
    return Cells(pixels=pixels, glyphs=glyphs, ink=ink)


def test_the_picture_shows_two_blocks_a_cell(cells: Cells) -> None:
    picture = image(cells, scale=8)
    assert picture.size == (24, 32)
    assert picture.getpixel((4, 4)) == (255, 0, 0)
    assert picture.getpixel((4, 12)) == (0, 0, 255)
    assert picture.getpixel((12, 9)) == (255, 255, 255)


def test_the_picture_shows_characters_in_ink_on_the_mean(cells: Cells) -> None:
    cell = np.asarray(image(cells, scale=12))[24:, 24:]
    assert (cell[0, 0] == 50).all()
    assert (cell[-1, -1] == 50).all()
    assert (cell[..., 1] > 200).any()


def _cell_with(character: str) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    pixels, ink = np.zeros((2, 1, 4), np.uint8), np.full((1, 1, 4), 255, np.uint8)
    glyphs = np.array([[ord(character)]], np.uint32)
    return np.asarray(image(Cells(pixels=pixels, glyphs=glyphs, ink=ink), scale=16))


def test_no_symbol_of_the_console_is_the_box_of_a_missing_character() -> None:
    blocks = (chr(each) for each in range(0x2580, 0x25A0) if not 0x2591 <= each <= 0x2593)
    signs = {*blocks, *"─│┌┐└┘├┤┬┴┼╵╷━┃╋╱╲╳", *"▲▼◀▶←↑→↓↖↗↘↙☼☾·£§²–°±×…"}
    box = _cell_with("\ue123")
    assert [each for each in signs if np.array_equal(_cell_with(each), box)] == []


def test_a_block_of_a_quarter_fills_the_lowest_quarter_of_its_cell() -> None:
    shares = _cell_with("▂")[..., 0].mean(axis=1) / 255
    assert (shares[:23] == 0).all()
    assert (shares[24:] == 1).all()


def test_plain_text_shows_characters_and_brightness(cells: Cells) -> None:
    assert plain_text(cells) == ":@\n  R\n"


@pytest.fixture
def shades() -> Cells:
    """Five cells without colours: ground, shades of a quarter, a half and three quarters, ink."""
    pixels = np.zeros((2, 5, 4), np.uint8)
    pixels[..., :3] = np.array([0, 64, 128, 192, 255])[:, None]
    blank = np.zeros((1, 5), np.uint32)
    cells = Cells(pixels=pixels, glyphs=blank, ink=np.zeros((1, 5, 4), np.uint8))
    return at_depth(cells, ColourDepth.MONO)


def test_without_colours_the_picture_has_black_and_white_dots_as_dense_as_the_shades(
    shades: Cells,
) -> None:
    dots = np.asarray(image(shades, scale=8))[..., 0]
    assert set(dots.flat) == {0, 255}
    assert dots.reshape(16, 5, 8).mean(axis=(0, 2)).tolist() == [0, 63.75, 127.5, 191.25, 255]


def test_without_colours_the_text_has_the_shades_and_half_blocks(shades: Cells) -> None:
    shades.pixels[:, 0] = [[0, 0, 0, 0], [255, 255, 255, 1]]
    assert plain_text(shades) == "▄░▒▓█\n"


def test_without_colours_the_drawing_has_shades_as_veils(shades: Cells) -> None:
    veils = [item.attrib for item in ET.fromstring(svg(shades)) if "fill-opacity" in item.attrib]
    assert [(v["x"], v["fill"], v["fill-opacity"]) for v in veils] == [
        ("8", "#ffffff", "0.25"),
        ("16", "#ffffff", "0.5"),
        ("24", "#ffffff", "0.75"),
    ]


def test_the_drawing_merges_runs_and_holds_the_text(cells: Cells) -> None:
    root = ET.fromstring(svg(cells))
    space = "{http://www.w3.org/2000/svg}"
    rectangles = [item.attrib for item in root.iter(f"{space}rect")]
    assert [r["fill"] for r in rectangles[:3]] == ["#ff0000", "#ffffff", "#000000"]
    third = [r for r in rectangles if r["y"] == "16"]
    assert [(r["x"], r["width"], r["fill"]) for r in third] == [
        ("0", "16", "#000000"),
        ("16", "8", "#323232"),
    ]
    (text,) = root.iter(f"{space}text")
    assert text.text == "R"
    assert text.attrib["fill"] == "#00ff00"


@given(st.lists(st.integers(0, 0xFFFFFFFF), min_size=1, max_size=8))
def test_whatever_the_code_points_the_files_are_well_formed(points: list[int]) -> None:
    cells = Cells(
        pixels=np.zeros((2, len(points), 4), np.uint8),
        glyphs=np.array([points], np.uint32),
        ink=np.zeros((1, len(points), 4), np.uint8),
    )
    ET.fromstring(svg(cells))
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", plain_text(cells))
    plain_text(cells).encode()
    image(cells, scale=2)


def save(cells: Cells, path: Path) -> None:
    file = PictureFile(path)
    file.write(file.draw(cells, ()))


def test_the_suffix_says_how_a_file_is_written(cells: Cells, tmp_path: Path) -> None:
    save(cells, tmp_path / "shot.PNG")
    with Image.open(tmp_path / "shot.PNG") as picture:
        assert picture.size == (24, 32)
    save(cells, tmp_path / "shot.svg")
    assert ET.parse(tmp_path / "shot.svg").getroot().tag.endswith("svg")
    save(cells, tmp_path / "shot.txt")
    assert (tmp_path / "shot.txt").read_text() == plain_text(cells)


@pytest.mark.parametrize("name", ["shot.gif", "shot", "missing/shot.png", "missing/shot.txt"])
def test_a_file_that_cannot_be_written_is_named(cells: Cells, tmp_path: Path, name: str) -> None:
    with pytest.raises(PictureFileError, match=re.escape(name)):
        save(cells, tmp_path / name)


def test_pictures_show_quadrants() -> None:
    pixels = np.zeros((2, 4, 3), np.uint8)
    pixels[0, 1] = 200
    pixels[:, 2, 0] = 100
    cells, pictures = in_quadrants(pixels)
    picture = image(cells, pictures, scale=8)
    assert picture.size == (16, 16)
    seen = [[picture.getpixel((4 * x + 2, 8 * y + 4)) for x in range(4)] for y in range(2)]
    assert seen == [[tuple(pixel) for pixel in row] for row in pixels.tolist()]
    assert '<rect x="4" y="0" width="4" height="8" fill="#c8c8c8"/>' in svg(cells, pictures)


@for_each("depth", ColourDepth)
@for_each("glyphs", GlyphSet)
def test_a_file_wants_more_pixels_for_quadrants_in_truecolour_only(
    glyphs: GlyphSet, depth: ColourDepth
) -> None:
    more = (glyphs, depth) == (GlyphSet.QUADRANTS, ColourDepth.TRUECOLOUR)
    file = PictureFile(Path("shot.png"), depth=depth, glyphs=glyphs)
    assert file.pixels_per_cell == ((2, 2) if more else (1, 2))


def test_a_full_disk_leaves_the_picture_that_was_there(cells: Cells, tmp_path: Path) -> None:
    path = tmp_path / "shot.png"
    file = PictureFile(path)
    file.write(file.draw(cells, ()))
    before = path.read_bytes()
    with files_no_longer_than(10), pytest.raises(PictureFileError, match="cannot be written"):
        file.write(file.draw(cells, ()))
    assert path.read_bytes() == before
    assert [*tmp_path.iterdir()] == [path]
