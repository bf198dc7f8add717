"""Words in rows, and the tables made of them."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from rune_tui.model.theme import DARK
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.rows import (
    TextRow,
    cut,
    fitting_form,
    flowing,
    tabled,
    wrapped,
    write_rows,
)
from tests.console.visualizers.conftest import words
from tests.support.cases import for_each

COLUMNS = st.integers(1, 80)


def test_what_is_cut_ends_in_an_ellipsis() -> None:
    assert cut("battery", 7) == "battery"
    assert cut("battery", 4) == "bat…"


def test_the_first_form_that_fits_is_taken_and_the_last_is_cut() -> None:
    forms = ("battery low", "low 5%", "5%")
    assert [fitting_form(columns, *forms) for columns in (11, 10, 5, 1)] == [*forms, "…"]


@given(st.lists(st.text("abc", min_size=1, max_size=9), max_size=9), COLUMNS)
def test_flowing_words_keep_their_order_and_the_width(texts: list[str], columns: int) -> None:
    lines = [[row.text for row in line] for line in flowing(map(TextRow, texts), columns)]
    assert [text for line in lines for text in line] == texts
    assert all(len("  ".join(line)) <= columns or len(line) == 1 for line in lines)


@given(st.lists(st.tuples(*[st.text("abc ", max_size=9)] * 3), max_size=5), COLUMNS)
def test_a_table_never_is_wider_than_its_room(cells: list[tuple[str, ...]], columns: int) -> None:
    lines = tabled(cells, (3, 1, 2), columns)
    assert len(lines) == len(cells)
    assert all(len(line) <= columns for line in lines)


def test_columns_stand_below_each_other_and_the_least_one_goes_first() -> None:
    cells = (("a", "long", "why not"), ("bcd", "x", "because"))
    assert tabled(cells, (3, 1, 2), 18) == ("a    long  why not", "bcd  x     because")
    assert tabled(cells, (3, 1, 2), 17) == ("a    why not", "bcd  because")
    assert tabled(cells, (3, 1, 2), 4) == ("a", "bcd")


def test_free_text_in_the_last_column_is_cut_before_a_column_goes() -> None:
    (line,) = tabled((("a", "b", "some words that go on and on"),), (3, 2, 1), 20)
    assert line == "a  b  some words…"


@example("ab ab", 3)
@given(st.text("ab ", max_size=60), COLUMNS)
def test_a_wrapped_row_keeps_its_letters_and_the_width(text: str, columns: int) -> None:
    rows = list(wrapped(TextRow(text), columns))
    assert all(len(row.text) <= columns for row in rows)
    assert "".join("".join(row.text for row in rows).split()) == "".join(text.split())
    assert [row.continues for row in rows] == [index > 0 for index in range(len(rows))]


@for_each(
    ("height", "shown"),
    [
        (8, ["a", "b", "  b", "c"]),
        (6, ["a", "b", "  b       +1"]),
        (4, ["a", "b         +1"]),
        (2, ["a         +2"]),
    ],
)
def test_what_does_not_fit_is_counted_without_what_only_continues(height, shown) -> None:
    canvas = Canvas.blank(12, height)
    rows = [TextRow("a"), TextRow("b"), TextRow("  b", continues=True), TextRow("c")]
    write_rows(canvas, rows, DARK)
    assert words(canvas) == shown


@given(st.text("ab ", max_size=30), st.integers(1, 30))
def test_no_word_is_cut_but_one_that_stands_alone(text: str, columns: int) -> None:
    shown = cut(text, columns)
    assert len(shown) <= columns
    if shown != text and " " in shown.strip():
        assert set(shown.removesuffix("…").split()) <= set(text.split())
