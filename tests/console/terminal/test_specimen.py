"""What people see of each set of characters."""

from __future__ import annotations

import re

from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.terminal.specimen import ADVICE, specimens
from tests.console.compositor.terminal_model import Terminal


def picture(text: str) -> tuple[str, Terminal]:
    """The names on the left, and what stands behind them."""
    lines = [line for line in text.removesuffix(ADVICE).split("\n") if line]
    terminal = Terminal(28, len(lines))
    for row, line in enumerate(lines):
        terminal.feed(f"\x1b[{row + 1};1H{line[14:]}")
    return "\n".join(line[:14].rstrip() for line in lines), terminal


def test_each_set_has_its_name_and_draws_both_colours_over_the_edges_of_cells() -> None:
    names, terminal = picture(specimens())
    assert re.findall(r"\w+", names) == [glyphs.value for glyphs in GlyphSet]
    for number, glyphs in enumerate(GlyphSet):
        first, second = terminal.marks[4 * number, 0], terminal.marks[4 * number + 1, 0]
        assert {first.character, second.character} == {glyphs.half}
        assert first.halves[1] == second.halves[0] != first.halves[0]
