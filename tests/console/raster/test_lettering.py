"""Large letters: where they stand, how they blend, and fonts that cannot be used."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import ImageFont

from rune_tui.errors import FontError
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.lettering import Font, check_font, letter, measured
from tests.support.cases import for_each

RED = (200, 0, 0, 255)
FONT = Font(points=20.0)


def drawn(
    at: tuple[float, float],
    text: str,
    *,
    align: tuple[float, float] = (0.0, 0.0),
    colour: tuple[int, int, int, int] = RED,
) -> Canvas:
    canvas = Canvas.blank(80, 60)
    letter(canvas, at, text, FONT, colour, align=align)
    return canvas


def inked(canvas: Canvas) -> npt.NDArray[np.intp]:
    """Least row and column, and the ones after the greatest, that have ink."""
    rows, columns = np.nonzero(canvas.pixels[..., 3])
    return np.array((rows.min(), columns.min(), rows.max() + 1, columns.max() + 1))


def test_text_stands_within_its_measured_size_and_nearly_fills_its_width() -> None:
    width, height = measured("Hg", FONT)
    top, left, bottom, right = inked(drawn((10.0, 5.0), "Hg"))
    assert 5 <= top < bottom <= 5 + height
    assert 10 <= left < right <= 10 + width
    assert right - left > width - 6
    assert bottom - top > 15


def test_height_is_that_of_the_font_so_that_baselines_agree() -> None:
    sizes = {measured(text, FONT)[1] for text in ("a", "Hg", "Ä", "")}
    assert len(sizes) == 1
    assert inked(drawn((0.0, 0.0), "H"))[2] == inked(drawn((0.0, 0.0), "HE"))[2]


@pytest.mark.parametrize("align", [(0.5, 0.5), (1.0, 1.0), (0.0, 1.0)])
def test_alignment_moves_the_text_by_its_size(align: tuple[float, float]) -> None:
    width, height = measured("Hg", FONT)
    x, y = round(40.0 - align[0] * width), round(30.0 - align[1] * height)
    same = drawn((float(x), float(y)), "Hg")
    assert (drawn((40.0, 30.0), "Hg", align=align).pixels == same.pixels).all()


def test_a_larger_size_is_larger_by_as_much() -> None:
    width, height = measured("Hello", FONT)
    double_width, double_height = measured("Hello", Font(points=40.0))
    assert double_width == pytest.approx(2 * width, abs=3)
    assert double_height == pytest.approx(2 * height, abs=2)


@pytest.mark.parametrize("at", [(-15.0, 10.0), (70.0, 50.0), (20.0, -12.0)])
def test_text_is_clipped_at_every_edge(at: tuple[float, float]) -> None:
    large = Canvas.blank(200, 160)
    letter(large, (at[0] + 60, at[1] + 50), "Hgx", FONT, RED)
    assert (drawn(at, "Hgx").pixels == large.pixels[50:110, 60:140]).all()
    assert drawn(at, "Hgx").pixels.any()


@for_each("at", [(-500.0, 0.0), (80.0, 0.0), (0.0, 60.0), (0.0, -500.0)])
def test_text_outside_draws_nothing(at: tuple[float, float]) -> None:
    assert not drawn(at, "Hgx").pixels.any()


def test_edges_are_soft_in_the_colour_itself_where_the_canvas_is_clear() -> None:
    canvas = drawn((5.0, 5.0), "Sog", colour=(10, 200, 30, 255))
    alpha = canvas.pixels[..., 3]
    soft = (alpha > 60) & (alpha < 200)
    assert soft.any()
    assert (alpha == 255).any()
    assert (np.abs(canvas.pixels[soft].astype(int)[:, :3] - (10, 200, 30)) <= 3).all()


def test_half_clear_ink_mixes_with_what_is_under_it() -> None:
    canvas = Canvas.blank(80, 60)
    canvas.fill((0, 0, 100, 255))
    letter(canvas, (5.0, 5.0), "H", Font(points=40.0), (200, 0, 0, 128))
    assert (canvas.pixels[..., 3] == 255).all()
    assert canvas.pixels[..., 0].max() == pytest.approx(100, abs=1)
    assert canvas.pixels[canvas.pixels[..., 0].argmax() // 80, :, 2].min() == pytest.approx(
        50, abs=1
    )


def test_line_breaks_and_control_characters_stay_on_one_line() -> None:
    assert measured("a\nb\tc", FONT) == measured("a b c", FONT)
    letter(Canvas.blank(80, 60), (0.0, 0.0), "a\x00\x1b[2J\u202e\ud800", FONT, RED)


def test_no_text_draws_nothing_and_an_endless_one_ends() -> None:
    assert not drawn((10.0, 10.0), "").pixels.any()
    assert measured("x" * 10**6, FONT) == measured("x" * 10**5, FONT)


def test_a_font_file_is_drawn_by_its_path(tmp_path: Path) -> None:
    built_in = ImageFont.load_default(20.0)
    assert isinstance(built_in, ImageFont.FreeTypeFont)
    path = tmp_path / "a font.ttf"
    path.write_bytes(built_in.font_bytes)
    font = Font(file=str(path), points=20.0)
    canvas = Canvas.blank(80, 60)
    letter(canvas, (10.0, 5.0), "Hg", font, RED)
    assert (canvas.pixels == drawn((10.0, 5.0), "Hg").pixels).all()


def test_font_files_that_cannot_be_used_are_named_with_the_reason(tmp_path: Path) -> None:
    broken = tmp_path / "broken.ttf"
    broken.write_bytes(b"no font at all")
    for path, reason in (
        (tmp_path / "missing.ttf", "No such file"),
        (tmp_path, "no regular file"),
        (broken, "TrueType"),
    ):
        with pytest.raises(FontError, match=reason) as caught:
            check_font(Font(file=str(path)))
        assert str(path) in str(caught.value)


def test_a_font_is_not_looked_for_in_the_systems_folders() -> None:
    with pytest.raises(FontError, match="DejaVuSans"):
        check_font(Font(file="DejaVuSans.ttf"))


@for_each("points", [0.0, -3.0, 3.9, 200.1, float("inf"), float("nan")])
def test_sizes_that_cannot_be_drawn_are_refused(points: float) -> None:
    with pytest.raises(FontError, match="points"):
        check_font(Font(points=points))
