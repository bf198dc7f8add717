"""visualizeSpeed, visualizeHeading, visualizeCompass, visualizeBattery: what a robot state says."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, Motion
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK, LIGHT
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.gauges.heading import LETTERS, bearing_words
from tests.console.states import described
from tests.console.visualizers.conftest import made_by, words
from tests.support.car import CAR
from tests.support.cases import for_each

GAUGES = {
    "visualizeSpeed": {"linear": 0.25},
    "visualizeHeading": {"theta": 0.5},
    "visualizeCompass": {"theta": 0.5},
    "visualizeBattery": {"battery_fraction": 0.5},
}


@pytest.fixture
def shown(made, draw):
    """A gauge of a robot state with these parts."""

    def show(name: str, size: tuple[int, int], *, age: float = 0.1, options=None, **changes):
        robot = made.robot(navigation=made.received(made.navigation(**changes), age))
        return draw(name, robot, size, **(options or {}))

    return show


def accent(canvas, row: int) -> list[int]:
    """Columns of a row of pixels that have the accent's colour."""
    return np.flatnonzero((canvas.pixels[row] == DARK.accent).all(axis=1)).tolist()


@for_each("name", GAUGES)
def test_a_gauge_without_data_says_from_whom_it_waits_for_what(made, draw, name) -> None:
    text = " ".join(words(draw(name, made.robot(navigation=None), (40, 6)))).split()
    assert text[0] == "no"
    assert text[-2:] == ["from", "magellan"]


@pytest.mark.parametrize("name", GAUGES)
def test_a_gauge_dims_at_one_second_and_says_how_stale_it_is_at_three(shown, name) -> None:
    fresh, old, stale = (shown(name, (40, 12), age=age) for age in (0.9, 1.1, 4.2))
    assert words(fresh) == words(old)
    assert fresh.ink.sum() > old.ink.sum()
    assert "STALE 4.2 s" in "".join(words(stale))


@for_each("name", GAUGES)
def test_a_gauges_token_changes_with_what_it_shows_its_age_and_colours_only(made, name) -> None:
    shown, state = made_by(name), ConsoleState(now=made.now)

    def token(age: float = 0.1, **changes):
        robot = made.robot(navigation=made.received(made.navigation(**changes), age))
        return shown.source(robot, state)

    assert token() == token(0.5, x=3.0, stamp=9.0)
    assert token() != token(**GAUGES[name])
    assert token() != token(1.5)
    assert token(4.25) != token(4.35)
    light = dataclasses.replace(state, theme=LIGHT)
    assert shown.source(made.robot(), state) != shown.source(made.robot(), light)
    assert shown.source(made.robot(navigation=None), state) != token()


@for_each("name", GAUGES)
def test_the_token_of_what_is_not_a_number_stays_the_same(made, name) -> None:
    nothing = dict.fromkeys(("linear", "angular", "theta", "battery_fraction"), math.nan)
    shown, state = made_by(name), ConsoleState(now=made.now)
    robots = (made.robot(navigation=made.received(made.navigation(**nothing))) for _ in range(2))
    first, second = (shown.source(robot, state) for robot in robots)
    assert first == second


@pytest.mark.parametrize(
    ("width", "lines"),
    [
        (48, ["speed", "+0.25 m/s, command -0.30", "turn", "left 30°/s, command right 5"]),
        (30, ["speed", "+0.25 m/s", "turn", "left 30°/s"]),
        (8, ["+0.25", "left 30"]),
    ],
)
def test_speed_says_what_is_and_what_is_commanded_in_the_room_there_is(shown, width, lines) -> None:
    speed = {"linear": 0.25, "commanded_linear": -0.3}
    turn = {"angular": math.radians(30), "commanded_angular": math.radians(-5)}
    rows = words(shown("visualizeSpeed", (width, 4), **speed, **turn))
    told = [part.strip() for row in rows for part in re.split(r"  +|[│▼]", row)]
    assert [part for part in told if part] == lines


@pytest.mark.parametrize(
    ("size", "lines"),
    [
        ((48, 8), {"moves 0.40 m/s to the right", "moves 0.10 m/s up"}),
        ((40, 4), {"right 0.40, up 0.10 m/s"}),
        ((40, 2), {"0.00, right 0.40, up 0.10 m/s 0°/s"}),
    ],
)
def test_speed_says_motion_to_the_side_and_up_where_the_robot_has_it(
    made, draw, size, lines
) -> None:
    speeds = made.received(made.navigation(sway=-0.4, heave=0.1))
    wheeled = made.robot(navigation=speeds)
    motion = Motion(freedom=Freedom.HEAVE, limit=0.3, acceleration=1.0)
    body = made.received(dataclasses.replace(CAR, motions=(motion,)))
    floating = wheeled.with_(messages={**wheeled.messages, ROBOT_DESCRIPTION.name: body})
    text = " ".join(" ".join(words(draw("visualizeSpeed", floating, size))).split())
    assert all(line in text for line in lines), text
    on_wheels = wheeled.with_(
        messages={**wheeled.messages, ROBOT_DESCRIPTION.name: described("wheels")}
    )
    assert "0.40" not in " ".join(words(draw("visualizeSpeed", on_wheels, size)))


def test_speed_runs_right_when_ahead_and_turns_to_where_the_robot_turns(shown) -> None:
    canvas = shown("visualizeSpeed", (60, 8), linear=0.5, angular=math.radians(45))
    ahead, turning = accent(canvas, 1), accent(canvas, 3)
    middles = [
        min(map(words(canvas)[row].index, set("│▼") & set(words(canvas)[row]))) for row in (0, 1)
    ]
    assert middles[0] <= min(ahead) <= max(ahead)
    assert min(turning) < max(turning) <= middles[1]
    assert len(ahead) == pytest.approx(len(turning), abs=4)


def test_speed_marks_what_is_commanded_on_its_bar(shown) -> None:
    row, turning = words(shown("visualizeSpeed", (60, 8), commanded_linear=-0.5))[:2]
    assert row.index("▼") < row.index("│")
    assert "▼" in turning
    assert "│" not in turning


@pytest.mark.parametrize(("linear", "mark"), [(0.9, ""), (1.1, "▶"), (-1.1, "◀")])
def test_speed_beyond_the_bar_is_marked_at_its_end(shown, linear, mark) -> None:
    row = words(shown("visualizeSpeed", (41, 8), linear=linear))[0]
    assert [sign for sign in row if sign in "◀▶"] == list(mark)
    wide = {"linear": 2.0}
    assert "▶" not in words(shown("visualizeSpeed", (41, 8), linear=linear, options=wide))[0]


def test_speed_that_is_not_known_is_a_question_mark_without_a_bar(shown) -> None:
    canvas = shown("visualizeSpeed", (40, 8), linear=math.nan, angular=math.inf)
    assert words(canvas)[0].startswith("speed")
    assert "? m/s, command 0.00" in words(canvas)[0]
    assert not accent(canvas, 1)
    assert not accent(canvas, 3)


@pytest.mark.parametrize(
    ("theta_deg", "north", "expected"),
    [
        (0, 90, "090° E"),
        (90, 90, "000° N"),
        (89.6, 90, "000° N"),
        (-180, 90, "270° W"),
        (50, 90, "040° NE"),
        (50, 0, "310° NW"),
    ],
)
@pytest.mark.parametrize("name", ["visualizeHeading", "visualizeCompass"])
def test_the_heading_is_told_clockwise_from_north(shown, name, theta_deg, north, expected) -> None:
    options = {"north_deg": north}
    canvas = shown(name, (40, 12), theta=math.radians(theta_deg), options=options)
    assert expected in " ".join(words(canvas))


@pytest.mark.parametrize("name", ["visualizeHeading", "visualizeCompass"])
def test_a_heading_that_is_not_known_is_called_so(shown, name) -> None:
    assert "not known" in " ".join(words(shown(name, (40, 12), theta=math.nan)))


@given(st.integers(0, 359))
def test_a_bearing_has_the_letters_of_the_nearest_of_eight_winds(bearing: int) -> None:
    degrees, letters = bearing_words(bearing).split()
    away = (LETTERS.index(letters) * 45 - bearing + 180) % 360 - 180
    assert degrees == f"{bearing:03d}°"
    assert abs(away) <= 22.5


def test_the_tape_has_east_right_of_north(shown) -> None:
    tape = words(shown("visualizeHeading", (61, 6), theta=math.radians(45)))[2]
    assert tape.index("N ") < tape.index("NE") < tape.index("75", tape.index("NE") + 2)
    assert words(shown("visualizeHeading", (61, 6)))[1].index("▼") == 30


@given(st.integers(0, 359), st.integers(8, 90))
def test_no_label_of_the_tape_is_cut(bearing: int, width: int) -> None:
    canvas = Canvas.blank(width, 6)
    heading: Any = made_by("visualizeHeading")
    heading.show(canvas, float(bearing), DARK)
    labels = words(canvas)[2].split()
    assert set(labels) <= {*LETTERS, *map(str, range(0, 360, 5))}


def test_the_length_of_the_tape_is_the_layouts(shown) -> None:
    whole = words(shown("visualizeHeading", (81, 6), options={"option": 360.0}))[2].split()
    assert {"N", "E", "S", "W"} <= set(whole)
    assert "S" not in words(shown("visualizeHeading", (80, 6)))[2].split()


def place_of(canvas, letter: str) -> tuple[int, int]:
    rows = words(canvas)[:-1]
    row = next(index for index, text in enumerate(rows) if letter in text)
    return rows[row].index(letter), row


def test_the_compass_keeps_north_or_the_robot_at_the_top(shown) -> None:
    north_up = shown("visualizeCompass", (25, 28), theta=0.0)
    assert place_of(north_up, "N") == (12, 0)
    assert place_of(north_up, "E")[0] > 20
    robot_up = shown("visualizeCompass", (25, 28), theta=0.0, options={"up": "robot"})
    assert place_of(robot_up, "E") == (12, 0)
    assert place_of(robot_up, "N")[0] < 4


def test_the_compass_arrow_points_where_the_robot_heads(shown) -> None:
    canvas = shown("visualizeCompass", (25, 28), theta=0.0)
    columns = np.flatnonzero((canvas.pixels[13] == DARK.accent).all(axis=1))
    assert columns.size
    assert columns.min() >= 12


@pytest.mark.parametrize(
    ("fraction", "size", "text"),
    [
        (0.87, (40, 4), "battery 87% 24.1 V"),
        (0.15, (40, 4), "battery LOW 15% 24.1 V"),
        (0.05, (50, 4), "battery CRITICAL 5% 24.1 V"),
        (0.05, (30, 4), "battery CRITICAL 5%"),
        (0.05, (4, 4), "!5%"),
        (math.nan, (40, 4), "battery 24.1 V, charge not known"),
    ],
)
def test_the_battery_is_told_in_words_as_grave_as_it_is(shown, fraction, size, text) -> None:
    row = words(shown("visualizeBattery", size, battery_fraction=fraction))[0]
    assert " ".join(row.split()) == text


def test_a_battery_of_which_nothing_is_measured_is_told_so(shown) -> None:
    canvas = shown("visualizeBattery", (60, 4), battery_fraction=math.nan, battery_voltage=math.nan)
    row = words(canvas)[0]
    assert " ".join(row.split()) == "battery nothing measured, charge not known"


def test_what_is_low_is_the_layouts_to_say(shown) -> None:
    options = {"low_percent": 60.0, "critical_percent": 30.0}
    for fraction, word in ((0.61, "61%"), (0.5, "LOW"), (0.29, "CRITICAL")):
        canvas = shown("visualizeBattery", (40, 4), battery_fraction=fraction, options=options)
        assert word in words(canvas)[0]


def test_the_bar_of_the_battery_is_as_long_as_its_charge(shown) -> None:
    canvas = shown("visualizeBattery", (42, 4), battery_fraction=0.5)
    track = np.flatnonzero((canvas.pixels[1] == DARK.track).all(axis=1))
    filled = accent(canvas, 1)
    assert filled == list(range(9, 9 + len(filled)))
    assert len(filled) == pytest.approx(len(track), abs=1)
    assert not accent(canvas, 0)
    assert not accent(canvas, 2)
