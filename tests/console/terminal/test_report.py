"""What `rune terminal` prints."""

from __future__ import annotations

import json
from pathlib import Path

from rune_tui.terminal.questions import Answers
from rune_tui.terminal.report import as_json, report
from rune_tui.terminal.specimen import specimens
from rune_tui.terminal.traits import traits_of

ANSWERS = Answers(complete=True, synchronized=True, truecolour=True, cell=(9, 20), keyboard=1)
TRAITS = traits_of(ANSWERS, {"TERM": "xterm"}, (120, 40))


def test_people_read_what_is_so_and_why() -> None:
    text = report(TRAITS, ANSWERS, 0.012, (120, 40))
    assert "answers       after 12 ms" in text
    assert "colours       truecolor                  the terminal says so" in text
    assert "acknowledges  no                         it did not answer where its cursor is" in text
    assert "glyphs        half" in text
    assert "not within 2.0 s" in report(TRAITS, Answers(), 2.0, (120, 40))


def test_people_see_the_sets_of_glyphs_where_they_can_choose() -> None:
    assert specimens() in report(TRAITS, ANSWERS, 0.012, (120, 40))
    plain = traits_of(Answers(), {"NO_COLOR": "1"}, (120, 40))
    assert "\x1b" not in report(plain, Answers(), 2.0, (120, 40))


def test_the_guide_shows_each_line_that_is_printed() -> None:
    guide = (Path(__file__).parents[3] / "docs" / "operator-guide.md").read_text()
    sample = guide.partition("$ rune terminal\n")[2].partition("```")[0]
    table = report(TRAITS, ANSWERS, 0.012, (120, 40)).partition("\n\n")[0]
    names = [[line[:13].rstrip() for line in text.splitlines()] for text in (sample, table)]
    assert names[0] == names[1]


def test_machines_read_the_same() -> None:
    found = json.loads(as_json(TRAITS, ANSWERS, 0.012, (120, 40)))
    assert (found["colors"], found["glyphs"]) == ("truecolor", "half")
    assert (found["aspect"], found["columns"], found["synchronized"]) == (2.222, 120, True)
