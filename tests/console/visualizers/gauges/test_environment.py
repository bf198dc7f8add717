"""visualizeEnvironment."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.environment import ENVIRONMENT, Environment
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import words

NAME = "visualizeEnvironment"


def sensing(made, **air: float):
    value = made.received(Environment(stamp=0.0, **air))
    return made.robot(messages={ENVIRONMENT.name: value})


def inks(canvas, row: int) -> set[tuple[int, ...]]:
    return {tuple(ink) for ink in canvas.ink[row][canvas.glyphs[row] > 32].tolist()}


def test_what_a_victim_may_cause_has_a_word_and_a_colour(made, draw) -> None:
    quiet = draw(NAME, sensing(made, sound=36.2, co2=423.0), (40, 4))
    assert ["36 dB" in words(quiet)[0], "420 ppm" in words(quiet)[1]] == [True, True]
    loud = draw(NAME, sensing(made, sound=58.0, co2=1234.0), (40, 4))
    assert "SOUND 58 dB" in words(loud)[0]
    assert "BREATH 1230 ppm" in words(loud)[1]
    for row in (0, 1):
        assert DARK.warning in inks(loud, row)
        assert DARK.warning not in inks(quiet, row)


def test_the_layout_says_what_is_notable(made, draw) -> None:
    canvas = draw(NAME, sensing(made, sound=58.0), (40, 4), loud_db=60.0)
    assert "SOUND" not in words(canvas)[0]


def test_what_is_not_measured_is_said(made, draw) -> None:
    canvas = draw(NAME, sensing(made, co2=500.0), (40, 4))
    assert "not measured" in words(canvas)[0]
    for value in (math.inf, 1e300, -5.0):
        draw(NAME, sensing(made, sound=value, co2=value), (12, 2))
    assert np.any(draw(NAME, made.robot(), (50, 2)).glyphs)
