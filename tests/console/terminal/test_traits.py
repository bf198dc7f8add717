"""What a terminal is taken to be able to do, and why."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import USUAL_ASPECT, colours_by_environment, traits_of
from tests.support.cases import for_each


@for_each(
    ("environment", "described", "wanted"),
    [
        ({"TERM": "xterm-256color", "COLORTERM": "truecolor"}, 256, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-256color", "COLORTERM": "24bit"}, 256, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-direct"}, 1 << 24, ColourDepth.TRUECOLOUR),
        ({"TERM": "xterm-256color"}, 256, ColourDepth.INDEXED_256),
        ({"TERM": "newer-than-this-machine"}, None, ColourDepth.INDEXED_256),
        ({"TERM": "xterm-16color"}, 16, ColourDepth.INDEXED_16),
        ({"TERM": "linux"}, 8, ColourDepth.INDEXED_16),
        ({"TERM": "vt220"}, 0, ColourDepth.MONO),
    ],
)
def test_the_environment_says_what_colours_there_are(
    environment: Mapping[str, str], described: int | None, wanted: ColourDepth
) -> None:
    depth, why = colours_by_environment(environment, lambda _: described)
    assert depth is wanted
    assert any(value in why for value in environment.values())


@pytest.mark.parametrize(
    ("platform", "wanted"),
    [("linux", ColourDepth.MONO), ("win32", ColourDepth.TRUECOLOUR)],
)
def test_without_a_name_only_windows_has_colours(
    platform: str, wanted: ColourDepth, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.platform", platform)
    assert colours_by_environment({})[0] is wanted


XTERM = {"TERM": "xterm-256color"}


@for_each(
    ("answers", "environment", "given", "wanted"),
    [
        (Answers(truecolour=True), XTERM, None, ColourDepth.TRUECOLOUR),
        (Answers(truecolour=False), XTERM | {"COLORTERM": "24bit"}, None, ColourDepth.TRUECOLOUR),
        (Answers(truecolour=True), XTERM | {"NO_COLOR": "1"}, None, ColourDepth.MONO),
        (
            Answers(truecolour=True),
            {"NO_COLOR": "1"},
            ColourDepth.INDEXED_16,
            ColourDepth.INDEXED_16,
        ),
        (Answers(truecolour=True), {"NO_COLOR": ""}, None, ColourDepth.TRUECOLOUR),
    ],
)
def test_who_says_it_first_is_believed_of_colours(
    answers: Answers,
    environment: Mapping[str, str],
    given: ColourDepth | None,
    wanted: ColourDepth,
) -> None:
    assert traits_of(answers, environment, (80, 24), depth=given).depth is wanted


def test_the_shape_of_cells_is_given_told_or_usual() -> None:
    told = Answers(cell=(9, 20))
    assert traits_of(told, {}, (80, 24), aspect=1.8).aspect == 1.8
    assert traits_of(told, {}, (80, 24)).aspect == 20 / 9
    assert traits_of(Answers(), {}, (80, 24)).aspect == USUAL_ASPECT
    assert traits_of(Answers(cell=(1, 400)), {}, (80, 24)).aspect == USUAL_ASPECT


def test_glyphs_are_chosen_where_the_colours_leave_a_choice() -> None:
    many, few = Answers(truecolour=True), Answers()
    assert traits_of(many, XTERM, (80, 24)).glyphs is GlyphSet.HALF
    chosen = traits_of(many, XTERM, (80, 24), glyphs=GlyphSet.LOWER)
    assert (chosen.glyphs, chosen.reasons["glyphs"]) == (
        GlyphSet.LOWER,
        "the command line says so",
    )
    useless = traits_of(few, XTERM, (80, 24), glyphs=GlyphSet.LOWER)
    assert useless.depth is not ColourDepth.TRUECOLOUR
    assert useless.glyphs is GlyphSet.HALF
    assert "both" in useless.reasons["glyphs"]


def test_there_is_a_reason_for_everything() -> None:
    traits = traits_of(Answers(), XTERM, (80, 24))
    assert set(traits.reasons) == {
        "depth",
        "glyphs",
        "aspect",
        "synchronized",
        "acknowledges",
        "releases",
        "discards",
    }
    assert all(traits.reasons.values())
