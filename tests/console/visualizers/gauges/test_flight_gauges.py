"""visualizeAttitude and visualizeDepth: gauges of robots that tilt, fly or dive."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.gcm.flight import ALTITUDE, Altitude
from hub.gcm.imu import IMU, Imu
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import made_by, words


@pytest.fixture
def attitude(made, draw):
    """The horizon at these angles [deg]: right side down, nose up."""

    def show(right: float, up: float, size: tuple[int, int] = (41, 22), *, age: float = 0.1):
        value = Imu.of(roll=math.radians(right), pitch=math.radians(-up))
        robot = made.robot(messages={IMU.name: made.received(value, age)})
        return draw("visualizeAttitude", robot, size)

    return show


@pytest.fixture
def depth(made, draw):
    """The tape of these levels."""

    def show(size: tuple[int, int], *, age: float = 0.1, options=None, **levels):
        value = made.received(Altitude(stamp=0.0, **levels), age)
        robot = made.robot(messages={ALTITUDE.name: value})
        return draw("visualizeDepth", robot, size, **(options or {}))

    return show


def ground(canvas) -> np.ndarray:
    """How many pixels of ground are in each column."""
    return (canvas.pixels == DARK.faint).all(axis=2).sum(axis=0)


def test_a_robot_that_tells_no_attitude_or_depth_is_named(made, draw) -> None:
    for name, subject in (("Attitude", "attitude"), ("Depth", "depth or height")):
        canvas = draw(f"visualize{name}", made.robot(), (50, 2))
        assert words(canvas)[0].strip() == f"no {subject} from magellan"


def test_gauges_of_flight_show_their_age(attitude, depth) -> None:
    for show in (
        lambda age: attitude(5, 5, age=age),
        lambda age: depth((41, 22), depth=3.0, age=age),
    ):
        fresh, old, stale = map(show, (0.9, 1.1, 4.2))
        assert fresh.ink.sum() > old.ink.sum()
        assert "STALE 4.2 s" in words(stale)[0]


def test_the_horizon_lies_amid_when_level_and_falls_when_the_nose_rises(attitude) -> None:
    level, up, down = (ground(attitude(0, pitch)).sum() for pitch in (0, 10, -10))
    assert up < level < down
    assert ground(attitude(0, 0)).max() == pytest.approx(10, abs=1)


def test_the_horizon_rises_on_the_right_when_the_right_side_is_down(attitude) -> None:
    columns = ground(attitude(20, 0))
    assert columns[-1] > columns[0]
    columns = ground(attitude(-20, 0))
    assert columns[-1] < columns[0]


@pytest.mark.parametrize(
    ("right", "up", "width", "text"),
    [
        (20, 5, 41, "roll 20° right, pitch 5° up"),
        (-20, -5, 20, "20° left, 5° down"),
        (0, 0.2, 41, "roll 0°, pitch 0°"),
        (20, 5, 13, "20° R 5° up"),
        (math.nan, 5, 41, "roll ?, pitch ?"),
    ],
)
def test_the_attitude_is_told_in_words(attitude, right, up, width, text) -> None:
    assert words(attitude(right, up, (width, 8)))[-1].strip() == text


@pytest.mark.parametrize(
    ("levels", "text"),
    [
        ({"depth": 3.34, "climb": -0.2}, "depth 3.3 m, sinking 0.2 m/s"),
        ({"height": 3.34, "climb": 0.2}, "height 3.3 m, rising 0.2 m/s"),
        ({"height": 3.34, "above_ground": 1.0, "climb": 0.01}, "above ground 1.0 m, steady"),
        ({"depth": 3.3}, "depth 3.3 m"),
        ({}, "depth not measured"),
    ],
)
def test_the_first_level_that_is_known_is_told_in_words(depth, levels, text) -> None:
    assert words(depth((40, 20), **levels))[-1].strip() == text


def test_the_layout_chooses_the_level(depth) -> None:
    options = {"shows": "height"}
    assert words(depth((40, 4), depth=3.0, height=-3.0, options=options))[-1].strip() == (
        "height -3.0 m"
    )
    assert "not measured" in words(depth((40, 4), depth=3.0, options=options))[-1]


def labels(canvas) -> list[float]:
    return [float(row.split()[0]) for row in words(canvas)[:-1] if row.endswith((" ┤", " ◀"))]


def test_the_tape_of_depth_grows_downward_from_the_surface_and_of_height_upward(depth) -> None:
    deep = labels(depth((20, 42), depth=3.3))
    assert deep == sorted(deep)
    assert min(deep) == 0.0
    high = labels(depth((20, 42), height=3.3))
    assert high == sorted(high, reverse=True)
    assert min(high) < 0.0


def test_the_length_of_the_tape_is_the_layouts_to_say(depth) -> None:
    short, long = (
        labels(depth((20, 42), height=50.0, options={"option": span})) for span in (5, 100)
    )
    assert max(short) - min(short) <= 5.0 < max(long) - min(long) <= 100.0


def test_tokens_change_with_what_is_shown_only(made) -> None:
    state = ConsoleState(now=made.now)

    def token(name, definition, value):
        robot = made.robot(messages={definition.name: made.received(value)})
        return made_by(name).source(robot, state)

    def tilted(roll):
        return token("visualizeAttitude", IMU, Imu.of(roll=roll, pitch=0.0))

    def dived(depth):
        return token("visualizeDepth", ALTITUDE, Altitude(stamp=0.0, depth=depth))

    assert tilted(0.1) == tilted(0.101) != tilted(0.2)
    assert dived(3.31) == dived(3.32) != dived(3.4)
