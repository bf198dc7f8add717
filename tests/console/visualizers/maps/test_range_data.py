"""visualizeRangeData."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hub.gcm.body import ROBOT_DESCRIPTION, Point32, RobotBody
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK, LIGHT
from rune_tui.visualizers.maps.range_data import DEFAULT_RIM_M, RangeData
from tests.console.states import range_readings, visualizer_spec
from tests.console.visualizers.conftest import words
from tests.support.car import CAR, car_readings
from tests.support.cases import for_each

NAME = "visualizeRangeData"
SIZE = (40, 40)


def sonar(**readings: float) -> np.ndarray:
    """All at 2 m but for those named by their number, as in s4=0.3."""
    ranges = np.full(16, 2.0, np.float32)
    for name, reading in readings.items():
        ranges[int(name[1:])] = reading
    return ranges


def at(canvas, distance: float, sensor: int) -> tuple[int, ...]:
    """The pixel at this distance from the centre [pixels], in the sensor's direction."""
    angle = sensor * math.pi / 8
    x = int(canvas.width / 2 - distance * math.sin(angle))
    y = int(canvas.height / 2 - distance * math.cos(angle))
    return tuple(canvas.pixels[y, x].tolist())


def in_pie(pixel: tuple[int, ...]) -> bool:
    """Whether it has the colour of a pie, not that of the plate or of a ring."""
    return pixel[2] - pixel[0] > 40


def marks(canvas, mark: str) -> list[tuple[int, int]]:
    """Column and row of each cell with the mark."""
    return [(c, r) for r, c in np.argwhere(canvas.glyphs == ord(mark)).tolist()]


def around(made, age: float = 0.1, *, sonar=2.0, infrared=np.inf, **state):
    """A robot with these ranges and this state."""
    return made.robot(
        navigation=made.received(made.navigation(**state), age),
        ranges=made.received(range_readings(sonar, infrared), age),
    )


def test_pies_reach_as_far_as_the_sonar_and_the_rest_is_clear(made, draw, golden) -> None:
    ranges = sonar(s0=1.0, s4=0.5, s8=np.inf)
    canvas = draw(NAME, around(made, sonar=ranges), SIZE)
    pixel_per_m = 19.5 / 3.0
    assert in_pie(at(canvas, 0.6 * pixel_per_m, 0))
    assert not in_pie(at(canvas, 1.4 * pixel_per_m, 0))
    assert in_pie(at(canvas, 1.8 * pixel_per_m, 12))
    assert not in_pie(at(canvas, 2.3 * pixel_per_m, 12))
    assert not canvas.pixels[0, 0].any()
    golden("range_data", canvas)


@for_each("sensor", [0, 4, 7, 12])
def test_what_is_near_has_a_colour_and_a_mark_on_its_side(made, draw, sensor) -> None:
    ranges = sonar(**{f"s{sensor}": 0.65})
    canvas = draw(NAME, around(made, sonar=ranges), SIZE)
    far = draw(NAME, around(made, sonar=sonar()), SIZE)
    assert marks(far, "!") == []
    ((column, row),) = marks(canvas, "!")
    angle = sensor * math.pi / 8
    left, ahead = canvas.width / 2 - (column + 0.5), canvas.height / 2 - (2 * row + 1)
    off = math.atan2(left, ahead) - angle
    assert abs(math.remainder(off, 2 * math.pi)) < 0.5
    red, _, blue, _ = at(canvas, 11.0, sensor)
    assert red > blue
    red, _, blue, _ = at(far, 11.0, sensor)
    assert red < blue


def test_near_is_measured_from_the_rim_of_the_body(made, draw) -> None:
    for reading, near in ((0.70, True), (0.71, False)):
        robot = around(made, sonar=sonar(s3=reading))
        assert bool(marks(draw(NAME, robot, SIZE), "!")) == near


@for_each("corner", [0.0, 1e-9, 1e6])
@for_each("radius", [0.0, 5e-324, 1e-300])
def test_a_body_without_a_size_is_drawn_all_the_same(made, draw, radius, corner) -> None:
    point = Point32(x=corner, y=0.0)
    body = RobotBody(name="r", kind="k", radius=radius, footprint=(point,) * 3)
    said = {ROBOT_DESCRIPTION.name: made.received(body, 0.1)}
    assert draw(NAME, made.robot(messages=said), SIZE).pixels.any()


def test_no_echo_is_faint_up_to_the_rim(made, draw) -> None:
    canvas = draw(NAME, around(made, sonar=sonar(s4=np.inf)), SIZE)
    assert 0 < at(canvas, 18.0, 4)[3] < at(canvas, 10.0, 12)[3]


def test_a_reading_that_is_no_number_draws_no_pie(made, draw) -> None:
    canvas = draw(NAME, around(made, sonar=sonar(s4=np.nan)), SIZE)
    assert not in_pie(at(canvas, 8.0, 4))


def test_the_option_is_the_range_at_the_rim(made, draw) -> None:
    robot = around(made, sonar=sonar())
    assert in_pie(at(draw(NAME, robot, SIZE, option=2.0), 18.0, 12))
    assert not in_pie(at(draw(NAME, robot, SIZE, option=4.0), 18.0, 12))


@for_each("option", [0.0, -1.0, math.nan, math.inf])
def test_a_senseless_option_means_the_default(option) -> None:
    assert RangeData.from_spec(visualizer_spec(NAME, option=option)).rim_m == DEFAULT_RIM_M


def test_infrared_is_an_arc_of_its_own_where_it_sees_something(made, draw) -> None:
    without = draw(NAME, around(made), SIZE)
    canvas = draw(NAME, around(made, infrared=infrared(s12=0.9)), SIZE)
    changed = np.argwhere((without.pixels != canvas.pixels).any(axis=2))
    assert len(changed) > 0
    assert (changed[:, 1] > 20).all()


def test_pressed_bumpers_are_marked_on_their_side(made, draw) -> None:
    canvas = draw(NAME, around(made, bumpers=1 << 4), SIZE)
    ((column, row),) = marks(canvas, "B")
    assert column < 20
    assert row in {9, 10}
    assert marks(draw(NAME, around(made), SIZE), "B") == []


def test_the_nose_points_up(made, draw) -> None:
    canvas = draw(NAME, around(made), SIZE)
    ahead, behind = at(canvas, 2.5, 0), at(canvas, 2.5, 8)
    assert min(ahead[:3]) > min(behind[:3])


def infrared(**readings: float) -> np.ndarray:
    """Nothing is seen but by those named by their number, as in s4=0.3."""
    ranges = np.full(16, np.inf, np.float32)
    for name, reading in readings.items():
        ranges[int(name[1:])] = reading
    return ranges


@for_each(("sensors", "reach"), [("sonar", 2.0), ("infrared", 1.0), ("fused", 1.0), ("both", 2.0)])
def test_a_layout_chooses_the_sensors_whose_ranges_are_shown(made, draw, sensors, reach) -> None:
    robot = around(made, infrared=infrared(s12=1.0, s4=np.nan), sonar=sonar(s4=1.5))
    canvas = draw(NAME, robot, SIZE, sensors=sensors)
    pixel_per_m = 19.5 / 3.0
    assert in_pie(at(canvas, (reach - 0.2) * pixel_per_m, 12))
    assert not in_pie(at(canvas, (reach + 0.3) * pixel_per_m, 12))
    # A pie is drawn where a sensor of the kind measures at all.
    assert in_pie(at(canvas, 1.2 * pixel_per_m, 4)) == (sensors != "infrared")
    pies = draw(NAME, robot, SIZE, sensors="sonar" if sensors == "both" else sensors)
    assert (canvas.pixels != pies.pixels)[:, 24:].any() == (sensors == "both")


def test_that_infrared_sees_nothing_is_no_room_to_drive(made, draw) -> None:
    robot = around(made, sonar=sonar(s4=np.nan), infrared=infrared())
    for sensors in ("infrared", "fused"):
        assert not in_pie(at(draw(NAME, robot, SIZE, sensors=sensors), 8.0, 4))


@pytest.mark.parametrize("sensors", ["infrared", "fused", "both"])
def test_what_infrared_sees_near_is_marked_too(made, draw, sensors) -> None:
    robot = around(made, infrared=infrared(s4=0.5))
    assert len(marks(draw(NAME, robot, SIZE, sensors=sensors), "!")) == 1
    assert marks(draw(NAME, robot, SIZE, sensors="sonar"), "!") == []


def test_thresholds_are_measured_from_the_rim_of_the_body(made, draw) -> None:
    robot = around(made, sonar=sonar(s4=0.203 + 0.3))
    for near, close, mark in ((0.29, 0.1, ""), (0.31, 0.29, "!"), (0.5, 0.31, "X")):
        canvas = draw(NAME, robot, SIZE, near=near, close=close)
        assert [m for m in "!X" if marks(canvas, m)] == list(mark)
    red, green, _, _ = at(draw(NAME, robot, SIZE, near=0.5, close=0.4), 12.0, 4)
    assert red > 2.5 * green


def test_colours_are_the_themes(made, draw) -> None:
    robot = around(made, sonar=sonar(s4=0.4))
    dark, light = (
        draw(NAME, robot, SIZE, state=ConsoleState(now=made.now, theme=theme))
        for theme in (DARK, LIGHT)
    )
    assert (dark.pixels != light.pixels).any(axis=2).sum() > 100
    assert np.abs(np.subtract(at(light, 8.0, 12)[:3], LIGHT.accent[:3])).max() < 4


def test_old_ranges_are_dimmed_and_then_hatched_and_marked(made, draw, golden) -> None:
    fresh, old, stale = (draw(NAME, around(made, age), SIZE) for age in (0.1, 2, 5))
    assert old.pixels[..., :3].max() < fresh.pixels[..., :3].max()
    assert (stale.pixels[2:, :, :3] < old.pixels[2:, :, :3]).any()
    assert (stale.pixels[2:, :, 3] == fresh.pixels[2:, :, 3]).all()
    assert "STALE 5.0 s" in "".join(map(chr, stale.glyphs[0].tolist()))
    golden("range_data_stale", stale)


def test_without_ranges_or_a_body_words_say_so(made, draw) -> None:
    canvas = draw(NAME, made.robot(navigation=None), SIZE)
    assert "no ranges from magellan yet" in " ".join(" ".join(words(canvas)).split())
    unknown = made.robot()
    known = {n: m for n, m in unknown.messages.items() if n != ROBOT_DESCRIPTION.name}
    canvas = draw(NAME, unknown.with_(messages=known), SIZE)
    assert "no description of magellan yet" in " ".join(" ".join(words(canvas)).split())


def test_the_age_is_that_of_the_ranges_not_of_the_state(made, draw) -> None:
    old = made.received(range_readings(), 5.0)
    assert "STALE 5.0 s" in words(draw(NAME, made.robot(ranges=old), SIZE))[0]
    state = made.received(made.navigation(bumpers=1), 5.0)
    canvas = draw(NAME, made.robot(navigation=state, ranges=made.received(range_readings())), SIZE)
    assert "STALE" not in words(canvas)[0]
    assert marks(canvas, "B") == []  # of a state so old nobody knows


def car(made, *, bumpers: int = 0, **readings):
    """The car in the open, but for these readings."""
    return made.robot(
        navigation=made.received(made.navigation(bumpers=bumpers)),
        ranges=made.received(car_readings(**readings)),
        messages={ROBOT_DESCRIPTION.name: made.received(CAR)},
    )


PIXEL_PER_M = 31.5 / 3.0
CAR_SIZE = (64, 64)


def spot(canvas, ahead: float, left: float) -> tuple[int, ...]:
    """The pixel at a place in the car's frame [m]."""
    x, y = canvas.width / 2 - left * PIXEL_PER_M, canvas.height / 2 - ahead * PIXEL_PER_M
    return tuple(canvas.pixels[int(y), int(x)].tolist())


def test_a_scan_is_a_filled_outline_around_its_own_place(made, draw) -> None:
    canvas = draw(NAME, car(made, laser=1.5), CAR_SIZE, sensors="infrared")
    for turned in range(0, 360, 15):
        ahead, left = math.cos(math.radians(turned)), math.sin(math.radians(turned))
        assert in_pie(spot(canvas, 0.4 + 1.3 * ahead, 1.3 * left))
        assert not in_pie(spot(canvas, 0.4 + 1.8 * ahead, 1.8 * left))


def test_a_scan_that_is_not_known_everywhere_has_a_gap(made, draw) -> None:
    laser = np.full(360, 1.5, np.float32)
    laser[255:286] = np.nan  # to the left
    canvas = draw(NAME, car(made, laser=laser), CAR_SIZE, sensors="infrared")
    assert not in_pie(spot(canvas, 0.4, 1.0))
    assert in_pie(spot(canvas, 0.4, -1.0))


def test_a_near_wall_in_a_scan_has_one_mark(made, draw) -> None:
    laser = np.full(360, 2.5, np.float32)
    laser[265:275] = 0.6  # to the left: 0.3 m beside the car
    canvas = draw(NAME, car(made, laser=laser), CAR_SIZE)
    ((column, row),) = marks(canvas, "!")
    assert column + 0.5 == pytest.approx(32 - 0.6 * PIXEL_PER_M, abs=3)
    assert 2 * row + 1 == pytest.approx(32 - 0.4 * PIXEL_PER_M, abs=3)
    red, _, blue, _ = spot(canvas, 0.4, 1.5)
    assert red > blue
    laser[265:275] = 0.4
    assert len(marks(draw(NAME, car(made, laser=laser), CAR_SIZE), "X")) == 1


def test_a_single_sensor_is_drawn_where_it_is_and_looks(made, draw) -> None:
    canvas = draw(NAME, car(made, front=1.0), CAR_SIZE, sensors="sonar")
    assert in_pie(spot(canvas, 1.4, 0.0))
    assert not in_pie(spot(canvas, 1.8, 0.0))
    assert not in_pie(spot(canvas, 0.7, 0.3))  # beside the cone, which begins at the front
    infrared = draw(NAME, car(made, laser=np.nan, side=0.8), CAR_SIZE, sensors="infrared")
    assert in_pie(spot(infrared, -0.2, -0.9))
    assert not in_pie(spot(infrared, 0.2, -0.7))


def test_fused_ends_a_wide_beam_at_what_a_narrow_beam_in_it_finds(made, draw) -> None:
    robot = around(made, infrared=infrared(s0=0.8))
    assert in_pie(at(draw(NAME, robot, SIZE, sensors="both"), 9.0, 0))
    assert not in_pie(at(draw(NAME, robot, SIZE, sensors="fused"), 9.0, 0))
    beside = draw(NAME, car(made, front=2.0, side=0.8), CAR_SIZE, sensors="fused")
    alone = draw(NAME, car(made, front=2.0), CAR_SIZE, sensors="fused")
    assert (beside.pixels != alone.pixels).any()  # not in the cone: an arc of its own


def test_a_pressed_bumper_is_on_its_part_of_the_outline(made, draw) -> None:
    for number, row in ((0, (32 - 0.6 * PIXEL_PER_M) / 2), (1, (32 + 0.4 * PIXEL_PER_M) / 2)):
        ((column, where),) = marks(draw(NAME, car(made, bumpers=1 << number), CAR_SIZE), "B")
        assert abs(column - 32) <= 1
        assert abs(where - row) <= 1


def test_a_body_without_sensors_that_look_around_is_drawn_with_words(made, draw) -> None:
    bare = dataclasses.replace(CAR, ranges=CAR.ranges[3:])
    robot = car(made, down=0.1)
    robot = robot.with_(messages={**robot.messages, ROBOT_DESCRIPTION.name: made.received(bare)})
    canvas = draw(NAME, robot, CAR_SIZE)
    assert "no ranges around" in words(canvas)[-1]
    assert marks(canvas, "X") == []
    assert canvas.pixels[32, 32].any()
    assert "no sonar around" in words(draw(NAME, robot, CAR_SIZE, sensors="sonar"))[-1]


def test_the_token_changes_only_with_what_is_drawn(made) -> None:
    shown, state = RangeData(), ConsoleState(now=made.now)
    first = around(made, sonar=sonar())
    assert shown.source(first, state) == shown.source(around(made, x=5.0), state)
    alone = RangeData(sensors="sonar")
    seen = around(made, infrared=infrared(s3=1.0))
    assert alone.source(first, state) == alone.source(seen, state)
    assert shown.source(first, state) != shown.source(seen, state)
    for other in ({"sonar": sonar(s3=1.9)}, {"bumpers": 2}, {"age": 1.5}):
        assert shown.source(first, state) != shown.source(around(made, **other), state)


@for_each("size", [(1, 1), (2, 2), (3, 9), (200, 4)])
def test_any_canvas_will_do(made, draw, size) -> None:
    zero = np.zeros(16, np.float32)
    draw(NAME, around(made, infrared=zero, bumpers=0xFFFF, age=9.0), size)
