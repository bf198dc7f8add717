"""How `rune joytest` fits what it says into a terminal."""

from __future__ import annotations

from rune_tui.commands.joytest import fold
from tests.support.cases import for_each

LINE = (
    "  y                lefty              192  ahead  ··········┃██········ +0.25  dead zone 0.20"
)


@for_each("columns", [30, 40, 80, 200])
def test_nothing_of_a_line_is_cut_on_a_narrow_terminal(columns: int) -> None:
    rows = fold(LINE, columns)
    assert all(len(row) <= columns for row in rows)
    assert " ".join(rows).split() == LINE.split()
    assert len(rows) == 1 or rows[1].startswith("        ")


def test_an_empty_line_stays_one() -> None:
    assert fold("", 80) == [""]
