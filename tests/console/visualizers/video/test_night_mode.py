"""visualizeNightMode."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK, LIGHT
from tests.console.visualizers.conftest import made_by, words
from tests.support.cases import for_each

NAME = "visualizeNightMode"
SIZE = (40, 12)
STATE = ConsoleState(now=100.0)
NIGHT = dataclasses.replace(STATE, night=frozenset({"magellan"}))


def seeing(made, age: float = 0.1, **changes):
    return made.robot(camera=made.received(made.camera(**changes), age))


def text(canvas) -> str:
    return " ".join(" ".join(words(canvas)).split())


@for_each(
    ("state", "changes", "told"),
    [
        (STATE, {}, "day"),
        (STATE, {"headlight": 0.0}, "day"),
        (NIGHT, {}, "NIGHT"),
        (NIGHT, {"gain": 2.53}, "NIGHT x2.5"),
        (NIGHT, {"gain": 2.53, "headlight": 0.8}, "NIGHT x2.5 light 80%"),
        (STATE, {"headlight": 0.8}, "NIGHT light 80% set elsewhere"),
        (STATE, {"gain": math.nan}, "day"),
        (dataclasses.replace(STATE, night=frozenset({"blimp"})), {}, "day"),
    ],
)
def test_words_say_what_is_wanted_here_and_what_the_camera_does(
    made, draw, state, changes, told
) -> None:
    assert text(draw(NAME, seeing(made, **changes), (60, 12), state=state)) == told


def test_the_moon_is_a_crescent_and_by_day_there_is_another_icon(made, draw, golden) -> None:
    night = draw(NAME, seeing(made), SIZE, state=NIGHT)
    day = draw(NAME, seeing(made), SIZE)
    lit = (night.pixels[:, :12, :3] == DARK.warning[:3]).all(axis=2)
    # Open to the right: its left half is lit, its middle is not.
    assert lit[6, 1:3].all()
    assert not lit[5:7, 6:].any()
    assert lit.sum() > 10
    assert ((day.pixels[:, :12] != night.pixels[:, :12]).any(axis=2)).sum() > 10
    golden("night_mode", night)


def test_in_a_single_row_the_icon_is_a_character(made, draw) -> None:
    assert text(draw(NAME, seeing(made), (20, 2), state=NIGHT)) == "☾ NIGHT"
    assert text(draw(NAME, seeing(made), (20, 2))) == "☼ day"


def test_what_does_not_fit_is_left_out_word_by_word(made, draw) -> None:
    robot = seeing(made, gain=2.5, headlight=0.8)
    for width, told in ((12, "NIGHT x2.5"), (11, "NIGHT"), (22, "NIGHT x2.5 light 80%")):
        assert text(draw(NAME, robot, (width, 2), state=NIGHT)) == f"☾ {told}"


def test_by_day_it_may_be_hidden(made, draw) -> None:
    canvas = draw(NAME, seeing(made), SIZE, day="hidden")
    assert not canvas.pixels.any()
    assert text(canvas) == ""
    assert text(draw(NAME, seeing(made), SIZE, day="hidden", state=NIGHT)) == "NIGHT"


def test_a_camera_that_was_never_heard_is_said(made, draw) -> None:
    robot = made.robot(camera=None)
    assert text(draw(NAME, robot, SIZE, state=NIGHT)) == "NIGHT camera not heard"
    assert text(draw(NAME, robot, SIZE)) == "day camera not heard"


def test_an_old_state_is_dimmed_and_then_hatched_and_marked(made, draw) -> None:
    fresh, old, stale = (
        draw(NAME, seeing(made, age), SIZE, state=NIGHT) for age in (0.1, 2.0, 5.0)
    )
    assert old.pixels[..., :3].max() < fresh.pixels[..., :3].max()
    assert (stale.pixels[2:, :, :3] < old.pixels[2:, :, :3]).any()
    assert "STALE 5.0 s" in words(stale)[0]


def test_the_token_changes_only_with_what_is_drawn(made) -> None:
    shown, hidden = made_by(NAME), made_by(NAME, day="hidden")
    first = shown.source(seeing(made), STATE)
    assert first == shown.source(seeing(made, pan=1.0, gain=1.01), STATE)
    for state, changes in (
        (NIGHT, {}),
        (STATE, {"gain": 2.0}),
        (STATE, {"age": 2.0}),
        (dataclasses.replace(STATE, theme=LIGHT), {}),
    ):
        assert shown.source(seeing(made, **changes), state) != first
    assert shown.source(made.robot(camera=None), STATE) != first
    assert hidden.source(seeing(made), STATE) == hidden.source(seeing(made, age=5.0), STATE)
    assert hidden.source(seeing(made), STATE) != hidden.source(seeing(made), NIGHT)


@for_each("size", [(1, 1), (2, 2), (3, 9), (200, 4), (4, 200)])
@for_each("state", [STATE, NIGHT])
def test_any_canvas_will_do(made, draw, size, state) -> None:
    canvas = draw(NAME, seeing(made, age=9.0, gain=3.0), size, state=state)
    assert np.asarray(canvas.pixels).any()
