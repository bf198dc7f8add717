"""Every shipped body, by the interface that the driver uses."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from hub.gcm.geometry import Twist, Vector3
from hub.robots.interfaces import Body, BodyLeftAlone
from hub.robots.left_alone import LeftAlone
from hub.robots.registry import kind_of
from hub.robots.robot_file import read_description
from tests.support.bodies import BODIES, REST_S, SHIPPED, STANDING, STILL, robot_of

LEFT_ALONE = {"blimp": LeftAlone.HOLD_HEIGHT, "rov": LeftAlone.SURFACE}


def opened(name: str) -> Body:
    robot = robot_of(name)
    return kind_of(robot).open_body(robot)


@pytest.fixture(params=BODIES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def body(name: str) -> Body:
    return opened(name)


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


def test_neutral_stops_all_its_motions_from_full_speed_in_time(name: str, body: Body) -> None:
    limits = [0.0] * 6
    for motion in robot_of(name).body.motions:
        limits[motion.freedom] = motion.limit
    surge, sway, heave, _, _, yaw = limits
    for linear, angular in (
        (Vector3(x=surge), Vector3()),
        (Vector3(x=-surge), Vector3(z=yaw)),
        (Vector3(y=sway), Vector3()),
        (Vector3(z=-heave), Vector3()),
    ):
        body.command(Twist(linear=linear, angular=angular))
        body.advance(3.0)
        body.command(Twist())
        body.advance(REST_S[name])
        left = velocity(body)
        # A blimp has no thrust to the side: what a turn leaves there ends by drag alone.
        speed = math.hypot(left[0], left[1] if name != "blimp" else 0.0, left[2])
        assert speed < STILL.get(name, STANDING)
        assert abs(left[3]) < (0.1 if name in STILL else STANDING)
        body.advance(2.0)


def test_a_base_on_wheels_brakes_as_described(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(
        'name = "lorry"\nkind = "simulated-wheels"\n[simulation]\narena = "empty"\n[limits]\n'
        "linear = 1.0\nangular = 0\nlinear_acceleration = 0.5\n"
    )
    robot, problems = read_description(path)
    assert not problems
    lorry = kind_of(robot).open_body(robot)
    lorry.command(Twist.planar(1.0, 1.0))
    lorry.advance(4.0)
    assert velocity(lorry) == pytest.approx((1.0, 0.0, 0.0, 0.0)), "0.25 m/s^2, and no turn"
    lorry.command(Twist())
    lorry.advance(1.0)
    assert velocity(lorry)[0] == pytest.approx(0.5)


def test_nonsense_counts_as_neutral(body: Body) -> None:
    nan = math.nan
    body.command(Twist(linear=Vector3(x=nan, y=nan, z=nan), angular=Vector3(x=nan, z=nan)))
    body.advance(1.0)
    assert body.sensors(1.0).commanded.neutral


def test_the_same_calls_give_the_same_values(name: str) -> None:
    def run() -> object:
        body = opened(name)
        for step in range(50):
            body.command(Twist(linear=Vector3(x=0.3, z=0.1), angular=Vector3(z=0.01 * step)))
            body.advance(0.05)
        return body.ground_truth()

    assert run() == run()


@pytest.mark.parametrize("robot", SHIPPED)
def test_a_body_can_do_what_its_file_says_of_it_left_alone(robot: str) -> None:
    assert robot_of(robot).left_alone is LEFT_ALONE.get(robot, LeftAlone.STAND)
    assert isinstance(opened(robot), BodyLeftAlone) == (robot in LEFT_ALONE)


def test_a_new_operator_ends_the_way_up_of_the_rov() -> None:
    rov = opened("rov")
    assert isinstance(rov, BodyLeftAlone)
    rov.command(Twist(linear=Vector3(z=-0.3)))
    rov.advance(4.0)
    rov.command(Twist())
    rov.left_alone(LeftAlone.SURFACE)
    rov.advance(1.0)
    assert velocity(rov)[2] > 0.3
    rov.left_alone(None)
    rov.advance(2.0)
    assert abs(velocity(rov)[2]) < 0.05


def test_the_blimp_holds_its_height_and_the_rov_surfaces() -> None:
    rov = opened("rov")
    assert isinstance(rov, BodyLeftAlone)
    rov.advance(1.0)
    before = rov.sensors(1.0).depth
    rov.left_alone(LeftAlone.STAND)
    for _ in range(2):
        rov.advance(5.0)
    assert rov.sensors(1.0).depth == pytest.approx(before, abs=0.02)
    rov.left_alone(LeftAlone.SURFACE)
    for _ in range(4):
        rov.advance(5.0)
    assert rov.sensors(1.0).depth < min(before, 0.3)
    blimp = opened("blimp")
    assert isinstance(blimp, BodyLeftAlone)
    blimp.advance(1.0)
    height = blimp.sensors(1.0).height
    blimp.left_alone(LeftAlone.HOLD_HEIGHT)
    for _ in range(4):
        blimp.advance(5.0)
    assert blimp.sensors(1.0).height == pytest.approx(height, abs=0.2)


@pytest.mark.parametrize(("surge", "angle"), [(0.4, 0.0), (-0.4, math.pi)])
def test_a_collision_has_a_direction_and_a_speed(name: str, surge: float, angle: float) -> None:
    body = opened(name)
    before = body.ground_truth()
    assert before is not None
    assert math.isnan(before.contact_angle)
    assert (before.contacts, before.impact_speed) == (0, 0.0)
    heading = before.theta
    for _ in range(1200):
        turned = math.remainder((body.ground_truth() or before).theta - heading, math.tau)
        body.command(Twist(linear=Vector3(x=surge), angular=Vector3(z=-turned)))
        body.advance(0.05)
        truth = body.ground_truth()
        assert truth is not None
        if truth.contacts:
            break
    else:
        pytest.skip("nothing is in its way")
    assert 0.0 < truth.impact_speed <= abs(surge) + 0.1
    assert abs(math.remainder(truth.contact_angle - angle, math.tau)) < math.pi / 2
