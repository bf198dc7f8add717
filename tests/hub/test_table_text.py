"""Tables hold no formulas, and come back; JSON is JSON, also with numbers that it has not."""

from __future__ import annotations

import csv
import io
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.table_text import cell_text, csv_line, json_text, text_of_cell

TEXTS = st.text(st.characters(exclude_categories=("Cs", "Cc", "Cf", "Zl", "Zp")), max_size=20)


@pytest.mark.parametrize(
    "text",
    [
        *('=HYPERLINK("http://x")', "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(1)", "'=1", " =1"),
        *("\t=1", "\n=1", "\uff1d1", "-x", "=", "-", "'-", "+49 1"),
    ],
)
def test_a_formula_gets_an_apostrophe(text: str) -> None:
    assert cell_text(text) == f"'{text}"
    assert text_of_cell(cell_text(text)) == text


@pytest.mark.parametrize("text", ["-1.5", "+2", "-1e-05", "-inf", "it's", "'tis", "a=b", "", "a-b"])
def test_numbers_and_words_stay(text: str) -> None:
    assert cell_text(text) == text
    assert cell_text(-1.5) == "-1.5"
    assert cell_text(None) == ""


def test_control_characters_are_spelt_out() -> None:
    assert cell_text("a\x1b]0;b\x07\u202ec") == r"a\x1b]0;b\x07\u202ec"
    assert cell_text("\r=1") == r"\r=1"


@given(st.lists(TEXTS, min_size=2, max_size=5))
def test_a_line_comes_back(cells: list[str]) -> None:
    (found,) = csv.reader(io.StringIO(csv_line(cells)))
    assert [text_of_cell(each) for each in found] == cells


def test_no_cell_begins_at_a_separator_of_another_language() -> None:
    """Spreadsheets part lines at `;` in some languages, but not within quotes."""
    assert csv_line(["a;=1", "b\t=1", "c"]) == '"a;=1","b\t=1",c\r\n'


def test_json_has_no_numbers_that_are_none() -> None:
    value = {"a": [1.5, math.nan, (math.inf, {"b": -math.inf})]}
    with pytest.raises(ValueError, match="not JSON"):
        json.loads(json.dumps(value), parse_constant=_refuse)
    found = json.loads(json_text(value), parse_constant=_refuse)
    assert found == {"a": [1.5, "nan", ["inf", {"b": "-inf"}]]}
    assert json_text([1.5, "nan"]) == '[1.5, "nan"]'


def _refuse(name: str) -> float:
    text = f"{name} is not JSON"
    raise ValueError(text)
