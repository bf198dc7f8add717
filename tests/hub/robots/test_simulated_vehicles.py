"""Holds, arming, flippers and problems of the shipped bodies."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from hub.errors import RobotFileError
from hub.gcm.body import HoldKind
from hub.gcm.diagnostics import Severity
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.vehicle import Arming, HoldPhase, HoldState
from hub.modules.driver.problems import problems
from hub.robomon.module_table import load_robot_table
from hub.robots.left_alone import LeftAlone
from hub.robots.registry import kind_of
from hub.robots.robot_file import SHIPPED, read_description
from hub.robots.simulated_rough_base import RoughBody
from hub.sim.ground.chassis import WHEELED
from tests.hub.sim.ground.grounds import block, ground_arena, ramp
from tests.support.magellan import magellan_body

VERTICAL = {"blimp": HoldKind.HEIGHT, "rov": HoldKind.DEPTH}
CLIMB = Twist(linear=Vector3(z=0.2))


def opened(name: str, *settings: str) -> Any:
    robot, mistakes = read_description(SHIPPED / f"{name}.toml", settings)
    assert not mistakes
    return kind_of(robot).open_body(robot)


def pass_time(body: Any, seconds: float) -> None:
    for _ in range(round(seconds / 0.05)):
        body.advance(0.05)


def hold_of(body: Any, kind: HoldKind) -> HoldState:
    (found,) = [each for each in body.sensors(0.0).vehicle.holds if each.kind is kind]
    return found


def level(body: Any) -> float:
    """What its vertical hold keeps [m]."""
    sensors = body.sensors(0.0)
    return float(sensors.height if math.isnan(sensors.depth) else sensors.depth)


@pytest.mark.parametrize("name", VERTICAL)
def test_its_hold_waits_while_it_is_moved_and_then_holds_where_it_is(name: str) -> None:
    body, kind = opened(name), VERTICAL[name]
    pass_time(body, 2.0)
    assert hold_of(body, kind).phase is HoldPhase.HOLDING
    assert body.sensors(0.0).vehicle.activity == "holds"
    body.command(CLIMB)
    pass_time(body, 0.5)
    assert hold_of(body, kind).phase is HoldPhase.READY
    assert body.sensors(0.0).vehicle.activity == "drives"
    body.command(Twist())
    pass_time(body, 6.0)
    hold = hold_of(body, kind)
    assert hold.phase is HoldPhase.HOLDING
    assert hold.target == pytest.approx(level(body), abs=0.1)
    assert hold.error == pytest.approx(level(body) - hold.target, abs=0.05)


@pytest.mark.parametrize("name", VERTICAL)
def test_it_goes_to_a_target_and_a_command_ends_that(name: str) -> None:
    body, kind = opened(name), VERTICAL[name]
    pass_time(body, 2.0)
    target = level(body) + 0.5
    body.hold(kind, target)
    assert hold_of(body, kind).phase is HoldPhase.HOLDING
    pass_time(body, 10.0)
    assert level(body) == pytest.approx(target, abs=0.1)
    body.hold(kind, target - 0.5)
    pass_time(body, 1.0)
    body.left_alone(LeftAlone.HOLD_HEIGHT)
    pass_time(body, 8.0)
    assert level(body) > target - 0.45, "left alone it holds where it is"


@pytest.mark.parametrize("name", VERTICAL)
def test_a_hold_that_is_off_has_no_target_and_left_alone_it_is_on(name: str) -> None:
    body, kind = opened(name), VERTICAL[name]
    pass_time(body, 2.0)
    body.release(kind)
    pass_time(body, 1.0)
    hold = hold_of(body, kind)
    assert hold.phase is HoldPhase.OFF
    assert math.isnan(hold.target)
    body.left_alone(LeftAlone.HOLD_HEIGHT)
    pass_time(body, 3.0)
    assert hold_of(body, kind).phase is HoldPhase.HOLDING


def test_the_rov_turns_to_a_heading_and_holds_it() -> None:
    body = opened("rov")
    pass_time(body, 1.0)
    wanted = math.remainder(body.sensors(0.0).theta + 1.5, math.tau)
    body.hold(HoldKind.HEADING, wanted)
    pass_time(body, 5.0)
    assert abs(math.remainder(body.sensors(0.0).theta - wanted, math.tau)) < 0.1
    assert hold_of(body, HoldKind.HEADING).target == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize(("name", "way"), [("blimp", -1.0), ("rov", 1.0)])
def test_a_disarmed_body_moves_by_nothing_but_its_weight(name: str, way: float) -> None:
    """The blimp sinks, the underwater robot rises; both hold again when they are armed."""
    body = opened(name)
    pass_time(body, 1.0)
    before = body.ground_truth().z
    body.arm(armed=False)
    body.hold(VERTICAL[name], level(body) + 5.0)
    body.command(Twist(linear=Vector3(x=0.5, z=-way * 0.2)))
    pass_time(body, 2.0)
    assert body.sensors(0.0).vehicle.arming is Arming.DISARMED
    assert body.sensors(0.0).commanded.neutral
    assert way * (body.ground_truth().z - before) > 0.05
    body.arm(armed=True)
    assert body.sensors(0.0).vehicle.arming is Arming.ARMED
    pass_time(body, 8.0)
    hold = hold_of(body, VERTICAL[name])
    assert hold.phase is HoldPhase.HOLDING
    assert abs(hold.error) < 0.1


def test_the_rov_reports_its_tether_and_a_leak() -> None:
    body = opened("rov", "simulation.leaks_after_s=2")
    pass_time(body, 1.0)
    state = body.sensors(0.0).vehicle
    assert 0.0 < state.tether_paid < 2.0
    assert state.tether_length == 25.0
    assert [*problems(body.sensors(0.0))] == []
    pass_time(body, 2.0)
    (leak,) = problems(body.sensors(0.0))
    assert (leak.name, leak.level) == ("leak", Severity.ERROR)
    assert body.sensors(0.0).vehicle.activity == "surfaces"


def test_flippers_turn_at_their_rate_within_their_limits() -> None:
    body = opened("tracked")
    pass_time(body, 0.5)
    front, rear = body.sensors(0.0).joints
    assert (front.name, rear.name) == ("front flippers", "rear flippers")
    body.turn_joint("front flippers", 0.5)
    pass_time(body, 1.0)
    now, still = body.sensors(0.0).joints
    assert now.position - front.position == pytest.approx(0.5, abs=0.03)
    assert now.velocity == 0.5
    assert still.position == rear.position
    pass_time(body, 3.0)
    assert body.sensors(0.0).joints[0].position == pytest.approx(math.pi / 2, abs=0.03)
    body.turn_joint("front flippers", 0.0)
    body.turn_joint("rear flippers", -0.7)
    pass_time(body, 3.0)
    front, rear = body.sensors(0.0).joints
    assert front.position == pytest.approx(math.pi / 2, abs=0.03)
    assert math.degrees(rear.position) == pytest.approx(-60.0, abs=1.0)
    assert body.ground_truth().pitch > 0.1, "the rear flippers lift its rear"


@pytest.mark.parametrize(
    ("kind", "tables", "mistake"),
    [
        ("simulated-wheels", '[[hold]]\nkind = "position"', ":4: [[hold]] 1, key 'kind'"),
        ("simulated-rov", '[[hold]]\nkind = "height"', "[[hold]] 1, key 'kind'"),
        ("simulated-wheels", '[[light]]\nname = "beacon"', ":4: [[light]] 1, key 'name'"),
        ("simulated-wheels", '[body]\narming = "armed"', ":4: [body], key 'arming'"),
        (
            "simulated-wheels",
            '[[joint]]\nname = "arm"\nlowest_deg = 0\nhighest_deg = 9',
            ":4: [[joint]] 1, key 'name'",
        ),
    ],
)
def test_parts_that_a_simulated_body_lacks_are_mistakes(
    tmp_path: Path, kind: str, tables: str, mistake: str
) -> None:
    path = tmp_path / "robot.toml"
    end = '[modules.driver]\nrun = "hub.modules.driver"\n'
    path.write_text(f'name = "robot"\nkind = "{kind}"\n{tables}\n{end}')
    with pytest.raises(RobotFileError) as refused:
        load_robot_table(str(path))
    assert mistake in str(refused.value)


def names_while_driving(ground: str) -> set[str]:
    """The problems of a Magellan that drives ahead over this ground for nine seconds."""
    arena = ground_arena(ground)
    body = RoughBody(arena, magellan_body(), WHEELED)
    body.command(Twist(linear=Vector3(x=0.4)))
    found = set()
    for _ in range(180):
        body.advance(0.05)
        found |= {each.name for each in problems(body.sensors(0.0))}
    return found


def test_wheels_that_spin_before_a_steep_ramp_are_stuck() -> None:
    assert names_while_driving(ramp(25.0)) == {"stuck"}


def test_a_robot_that_drives_off_an_edge_tips_over() -> None:
    assert "tipped" in names_while_driving(block(-1.0, 0.5, 2.5))


def test_a_robot_on_level_ground_has_no_problems() -> None:
    assert names_while_driving(block(-1.0, 0.5, 9.0)) == set()
