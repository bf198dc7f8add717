"""Every shipped body, by the interface that the driver uses."""

from __future__ import annotations

import math

import pytest

from hub.gcm.navigation import Twist, Vector3
from hub.robots.interfaces import Body, BodyLeftAlone
from hub.robots.left_alone import LeftAlone
from hub.robots.registry import kind_of
from hub.robots.robot_file import SHIPPED, read_description

ROBOTS = sorted(path.stem for path in SHIPPED.glob("*.toml"))
REST_S = {"magellan": 0.7, "tracked": 0.7, "rov": 1.5, "blimp": 4.0}
"""Longest time from the command to stop to rest [s], after the rules of safety."""
STILL = {"blimp": 0.1, "rov": 0.1}
"""Speed below which a body that drafts or currents carry counts as at rest; else 0.01 [m/s]."""


@pytest.fixture(params=ROBOTS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def body(name: str) -> Body:
    robot, problems = read_description(SHIPPED / f"{name}.toml")
    assert not problems
    return kind_of(robot).open_body(robot)


def velocity(body: Body) -> tuple[float, float, float, float]:
    truth = body.ground_truth()
    assert truth is not None
    return truth.linear, truth.sway, truth.heave, truth.angular


def test_it_measures_what_the_driver_reports(name: str, body: Body) -> None:
    body.advance(0.5)
    sensors = body.sensors(5.0)
    assert math.isfinite(sensors.x + sensors.y + sensors.theta)
    assert 0.9 < sensors.battery_fraction <= 1.0
    if name == "rov":
        assert 0.0 < sensors.depth < 3.0
    if name == "blimp":
        assert sensors.above_ground == pytest.approx(sensors.height, abs=0.3)


def test_neutral_stops_all_its_motions_in_time(name: str, body: Body) -> None:
    body.advance(0.5)
    body.command(Twist(linear=Vector3(x=0.4), angular=Vector3(z=0.2)))
    body.advance(3.0)
    assert velocity(body)[0] > 0.1
    body.command(Twist())
    body.advance(REST_S[name])
    speeds = velocity(body)
    assert math.hypot(*speeds[:3]) < STILL.get(name, 0.01)


def test_nonsense_counts_as_neutral(body: Body) -> None:
    nan = math.nan
    body.command(Twist(linear=Vector3(x=nan, y=nan, z=nan), angular=Vector3(x=nan, z=nan)))
    body.advance(1.0)
    assert body.sensors(1.0).commanded.neutral


def test_the_same_calls_give_the_same_values(name: str) -> None:
    def run() -> object:
        robot, _ = read_description(SHIPPED / f"{name}.toml")
        body = kind_of(robot).open_body(robot)
        for step in range(50):
            body.command(Twist(linear=Vector3(x=0.3, z=0.1), angular=Vector3(z=0.01 * step)))
            body.advance(0.05)
        return body.ground_truth()

    assert run() == run()


def test_blimp_and_rov_act_when_they_are_left_alone() -> None:
    robot, _ = read_description(SHIPPED / "rov.toml")
    rov = kind_of(robot).open_body(robot)
    assert isinstance(rov, BodyLeftAlone)
    rov.advance(1.0)
    before = rov.sensors(1.0).depth
    rov.left_alone(LeftAlone.SURFACE)
    for _ in range(4):
        rov.advance(5.0)
    assert rov.sensors(1.0).depth < min(before, 0.3)
    robot, _ = read_description(SHIPPED / "blimp.toml")
    blimp = kind_of(robot).open_body(robot)
    assert isinstance(blimp, BodyLeftAlone)
    blimp.advance(1.0)
    height = blimp.sensors(1.0).height
    blimp.left_alone(LeftAlone.HOLD_HEIGHT)
    for _ in range(4):
        blimp.advance(5.0)
    assert blimp.sensors(1.0).height == pytest.approx(height, abs=0.2)
