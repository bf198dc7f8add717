"""What sonars and infrared sensors say of walls, voids and posts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.pose import Pose
from hub.sim import range_sensors
from hub.sim.arena import Footprints, load_arena
from hub.sim.plane_rays import first_hits
from hub.sim.range_sensors import (
    SONAR_INCIDENCE,
    Floats,
    RangeSensors,
)
from tests.hub.sim.arenas import VOID, arena_of, free_poses
from tests.support.cases import for_each
from tests.support.magellan import SimulatedMagellan, magellan_body, magellan_sensors

SONAR, INFRARED = magellan_body().ranges
CENTRE = Pose(x=0.0, y=0.0, theta=0.0)


def sensors_before_a_wall(distance: float, colour: str = "white") -> RangeSensors:
    """A wall in the east whose face is at the given distance from the origin [m]."""
    x = distance + 0.05
    text = f'[[wall]]\nfrom=[{x},-20]\nto=[{x},20]\ncolour="{colour}"\n'
    return magellan_sensors(arena_of(VOID + text).footprints, 4)


@pytest.mark.parametrize("distance", [0.25, 0.5, 1.0, 2.5, 4.5])
def test_a_sonar_that_faces_a_wall_tells_its_distance_from_the_centre(distance: float) -> None:
    sensors = sensors_before_a_wall(distance)
    ranges = np.array([sensors.measure("sonar", CENTRE)[0] for _ in range(200)])
    assert ranges.mean() == pytest.approx(distance, rel=0.003)
    assert ranges.std() == pytest.approx(0.01 * distance, rel=0.25)


def test_a_robot_that_stands_casts_no_rays_again(monkeypatch: pytest.MonkeyPatch) -> None:
    casts: list[int] = []

    def counted(obstacles: Footprints, origins: Floats, directions: Floats) -> object:
        casts.append(len(directions))
        return first_hits(obstacles, origins, directions)

    monkeypatch.setattr(range_sensors, "first_hits", counted)
    sensors = sensors_before_a_wall(1.0)
    first = sensors.measure("sonar", CENTRE), sensors.measure("infrared", CENTRE)
    cast = len(casts)
    again = sensors.measure("sonar", CENTRE), sensors.measure("infrared", CENTRE)
    assert len(casts) == cast
    assert first[0][0] != again[0][0], "each measurement has its own noise"
    nearer = sensors.measure("sonar", Pose(x=0.5, y=0.0, theta=0.0))[0]
    assert nearer == pytest.approx(0.5, rel=0.05)
    assert sensors.measure("sonar", CENTRE)[0] == pytest.approx(1.0, rel=0.05)


def test_sonars_in_a_void_hear_nothing_and_infrared_sees_nothing() -> None:
    sensors = magellan_sensors(arena_of(VOID).footprints, 4)
    assert np.isinf(sensors.measure("sonar", CENTRE)).all()
    assert np.isinf(sensors.measure("infrared", CENTRE)).all()


def test_a_wall_beyond_the_farthest_echo_is_not_heard() -> None:
    assert np.isinf(sensors_before_a_wall(SONAR.farthest + 0.1).measure("sonar", CENTRE)).all()


@for_each("degrees", range(0, 90, 5))
def test_a_wall_at_grazing_incidence_sends_no_echo(degrees: int) -> None:
    """The rim of the cone may still meet a wall squarely that its middle does not."""
    heard = np.isfinite(
        sensors_before_a_wall(1.0).measure(
            "sonar", Pose(x=0.0, y=0.0, theta=math.radians(degrees))
        )[0]
    )
    assert heard == (math.radians(degrees) <= SONAR_INCIDENCE + SONAR.opening / 2)


def echo_from_the_north_east(text: str) -> float:
    """What the sonar hears that looks at 45 degrees; no face of a box is met squarely enough."""
    sensors = magellan_sensors(arena_of(VOID + text).footprints, 4)
    return float(sensors.measure("sonar", Pose(x=0.0, y=0.0, theta=math.radians(45)))[0])


def box_to_the_north_east(distance: float) -> str:
    """A box whose nearest edge is at a distance from that sonar [m]."""
    middle = (distance + SONAR.ring) / math.sqrt(2) + 0.5
    return f"[[box]]\nat=[{middle},{middle}]\nsize=[1,1,1]\n"


def test_an_edge_is_heard_from_any_side_when_it_is_near() -> None:
    for distance in (0.2, 0.5, 0.9):
        heard = echo_from_the_north_east(box_to_the_north_east(distance))
        assert heard == pytest.approx(distance + SONAR.ring, rel=0.04)
    assert math.isinf(echo_from_the_north_east(box_to_the_north_east(1.2)))


def test_an_edge_behind_a_wall_is_not_heard() -> None:
    wall = "[[box]]\nat=[0.3,0]\nsize=[0.02,9,1]\n"
    assert math.isinf(echo_from_the_north_east(box_to_the_north_east(0.5) + wall))


def test_a_post_is_heard_within_the_cone_only() -> None:
    for degrees, heard in ((0, True), (12, True), (17, False)):
        x, y = 2 * math.cos(math.radians(degrees)), 2 * math.sin(math.radians(degrees))
        arena = arena_of(VOID + f"[[cylinder]]\nat=[{x},{y}]\nradius=0.05\nheight=1\n")
        sonar = magellan_sensors(arena.footprints, 4).measure("sonar", CENTRE)
        assert np.isfinite(sonar[0]) == heard
        if heard:
            assert sonar[0] == pytest.approx(1.95, rel=0.05)


def test_of_a_wall_and_a_post_the_nearer_one_is_met() -> None:
    for post, wall in ((1.0, 2.0), (3.0, 2.0)):
        text = f"[[cylinder]]\nat=[{post},0]\nradius=0.1\nheight=1\n"
        text += f"[[wall]]\nfrom=[{wall},-3]\nto=[{wall},3]\nthickness=0.2\n"
        ahead = np.array([[1.0, 0.0]])
        distance, _, number = first_hits(arena_of(VOID + text).footprints, 0 * ahead, ahead)
        assert distance[0] == pytest.approx(min(post, wall) - 0.1)
        assert number[0] == (1 if post < wall else 0)


def test_what_is_above_or_far_below_the_body_is_not_seen() -> None:
    table = "[[box]]\nat=[1,0]\nsize=[0.5,0.5,0.05]\nbase=0.7\n"
    arena = arena_of(VOID + table)
    sonar = magellan_sensors(arena.footprints, 4).measure("sonar", CENTRE)
    assert np.isinf(sonar).all()


def test_infrared_tells_the_distance_from_the_centre_within_its_range() -> None:
    for distance in (INFRARED.ring + 0.2, INFRARED.ring + 0.6):
        sensors = sensors_before_a_wall(distance)
        ranges = np.array([sensors.measure("infrared", CENTRE)[0] for _ in range(200)])
        assert ranges.mean() == pytest.approx(distance, rel=0.01)
        assert 0.0 < ranges.std() < 0.04 * distance
    too_near = sensors_before_a_wall(INFRARED.ring + 0.03).measure("infrared", CENTRE)[0]
    assert too_near == pytest.approx(INFRARED.nearest)
    assert np.isinf(sensors_before_a_wall(INFRARED.ring + 0.85).measure("infrared", CENTRE)[0])


def test_infrared_misses_a_dark_wall_that_it_would_see_if_it_were_bright() -> None:
    distance = INFRARED.ring + 0.7
    assert np.isfinite(sensors_before_a_wall(distance, "white").measure("infrared", CENTRE)[0])
    assert np.isinf(sensors_before_a_wall(distance, "black").measure("infrared", CENTRE)[0])
    near = sensors_before_a_wall(INFRARED.ring + 0.3, "black").measure("infrared", CENTRE)[0]
    assert near <= INFRARED.farthest


@given(angle=st.floats(-math.pi, math.pi), seed=st.integers(0, 1000))
def test_first_hits_lie_on_the_outline_of_what_they_name(angle: float, seed: int) -> None:
    arena = load_arena("yellow")
    obstacles = arena.footprints
    (pose,) = free_poses(arena, 1, seed, 0.5, 9.5)
    directions = np.array([[math.cos(angle), math.sin(angle)]])
    distance, squareness, number = first_hits(obstacles, np.array([[pose.x, pose.y]]), directions)
    x, y = (np.array((pose.x, pose.y)) + distance[0] * directions[0]).tolist()
    at_hit = obstacles.distances(x, y)
    assert abs(at_hit[number[0]]) < 1e-6
    assert 0.0 <= squareness[0] <= 1.0
    # Nothing stands between: every shorter way ends outside of everything.
    for share in np.linspace(0.0, 0.999, 50):
        way = share * distance[0]
        place = (pose.x + way * math.cos(angle), pose.y + way * math.sin(angle))
        assert obstacles.distances(*place).min() > -1e-9


def test_scans_come_at_ten_hertz_of_simulated_time() -> None:
    robot = SimulatedMagellan(load_arena("yellow"), seed=2)
    scans = []
    for _ in range(100):
        robot.advance(0.01)
        scans.append(robot.sensors(0.0).scans[0].ranges.tobytes())
    assert len(set(scans)) == 11


def test_no_reader_can_change_reported_ranges() -> None:
    robot = SimulatedMagellan(load_arena("yellow"), seed=2)
    for scan in robot.sensors(0.0).scans:
        assert scan.ranges.dtype == np.float32
        with pytest.raises(ValueError, match="read-only"):
            scan.ranges[:] = -1.0
