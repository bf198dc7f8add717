"""A vehicle with an autopilot through a hub of real processes: it drives, and it stops."""

from __future__ import annotations

import os
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.navigation import (
    GOAL_COMMAND,
    STOP,
    Cause,
    GoalCommand,
    MotionState,
    Point,
    Stop,
    Task,
)
from hub.gcm.vehicle import VehicleOrder
from hub.pose import Pose
from hub.robots.mavlink.wire.frames import FramePacker
from tests.support.mavlink_numbers import ARM, GUIDED, HOLD, SET_MODE
from tests.system.autopilot_site import AutopilotSite, Operator
from tests.system.harness import in_soak

COMMANDED_S = 0.35 + 0.5
"""Longest time from the cause until the vehicle gets the stop command, on a busy machine [s]."""
AHEAD = Twist.planar(0.5, 0.0)
_NO_RECEIVER = ("SIM_RC_FAIL=1", "FS_TIMEOUT=0.1", "FS_GCS_ENABLE=1", "FS_GCS_TIMEOUT=2")
_PARAMETERS = {
    "rover": _NO_RECEIVER,
    "sub": ("SIM_RC_FAIL=1", "FS_PILOT_INPUT=1", "FS_PILOT_TIMEOUT=0.5"),
    "blimp": ("SIM_RC_FAIL=1", "RC_OVERRIDE_TIME=0.5"),
}


@pytest.fixture(scope="module")
def lasting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[AutopilotSite]:
    with closing(AutopilotSite(tmp_path_factory.mktemp("hub"), "rover", _NO_RECEIVER)) as site:
        site.go_on(1.0)
        assert not site.relay.orders(0.0), "nothing arms it or changes its mode at a start"
        yield site


@pytest.fixture
def rover(lasting: AutopilotSite) -> AutopilotSite:
    """A rover that drives ahead."""
    lasting.drive()
    lasting.move(AHEAD)
    return lasting


def commanded_after(site: AutopilotSite, cause: float) -> float:
    """Time from the cause to the last order to move [s]."""
    moving = site.relay.moving(cause)
    return moving[-1][0] - cause if moving else 0.0


def stands(site: AutopilotSite) -> None:
    site.wait(lambda: site.speed < 0.05, why="it never stood:")


@pytest.mark.parametrize(
    ("kind", "wanted", "rest_s", "left_alone", "mode"),
    [
        (
            "sub",
            Twist(linear=Vector3(x=0.25, y=0.15, z=-0.15)),
            4.0,
            "surface",
            "surface",
        ),
        (
            "blimp",
            Twist(linear=Vector3(x=0.1, y=0.08, z=0.1), angular=Vector3(z=0.15)),
            4.0,
            "hold height",
            "loiter",
        ),
    ],
)
def test_a_vehicle_that_floats_follows_each_velocity_and_stops_without_an_operator(
    tmp_path: Path, kind: str, wanted: Twist, rest_s: float, left_alone: str, mode: str
) -> None:
    with closing(AutopilotSite(tmp_path, kind, _PARAMETERS[kind], left_alone)) as site:
        site.operator.takes_control()
        site.drive()
        site.move(wanted)
        for name, velocity in (
            ("linear", wanted.linear.x),
            ("sway", wanted.linear.y),
            ("heave", wanted.linear.z),
            ("angular", wanted.angular.z),
        ):
            near = pytest.approx(velocity, rel=0.2, abs=0.02)
            site.wait(lambda name=name, near=near: getattr(site.robot, name) == near, why=name)
        site.operator.twist, silent = None, time.monotonic()
        stands(site)
        assert commanded_after(site, silent) < COMMANDED_S
        assert time.monotonic() - silent < COMMANDED_S + rest_s
        assert site.phase is AutopilotPhase.DRIVING, "its operator still has control"
        site.operator.client.close()
        site.operator = Operator(site.hub.endpoint, "another")
        site.wait(lambda: site.autopilot.mode == mode, why="it was not left alone:")
        assert site.phase is AutopilotPhase.ELSEWHERE


def test_a_rover_follows_a_velocity_and_a_turn(rover: AutopilotSite) -> None:
    rover.move(Twist.planar(0.4, 0.3))
    rover.wait(
        lambda: (
            rover.robot.linear == pytest.approx(0.4, abs=0.04)
            and rover.robot.angular == pytest.approx(0.3, abs=0.03)
        )
    )
    rover.move(Twist.planar(-0.4, 0.0))
    rover.wait(lambda: rover.robot.linear == pytest.approx(-0.4, abs=0.04))


def test_it_stops_when_the_operator_is_silent(rover: AutopilotSite) -> None:
    rover.operator.twist, silent = None, time.monotonic()
    stands(rover)
    assert commanded_after(rover, silent) < COMMANDED_S
    assert rover.phase is AutopilotPhase.DRIVING


@pytest.mark.parametrize("ways", [("to_vehicle", "to_hub"), *in_soak(("to_vehicle",), ("to_hub",))])
def test_no_motion_begins_when_a_cut_link_is_back(
    rover: AutopilotSite, ways: tuple[str, ...]
) -> None:
    cut = time.monotonic()
    for way in ways:
        setattr(rover.relay, way, False)
    rover.wait(lambda: rover.phase is AutopilotPhase.GONE)
    rover.wait(lambda: rover.robot.motion is MotionState.NO_DRIVER)
    stands(rover)
    assert commanded_after(rover, cut) < 1.5
    back = time.monotonic()
    rover.relay.join()
    rover.wait(lambda: rover.phase is AutopilotPhase.ELSEWHERE, why="it did not come back:")
    rover.go_on(1.0)
    assert not rover.relay.moving(back), "the stick was deflected all the time"
    assert not rover.relay.orders(back), "no mode was asked for"
    assert rover.speed < 0.05


def test_another_station_that_changes_the_mode_is_not_fought(rover: AutopilotSite) -> None:
    packer = FramePacker(254, 190)
    changed = time.monotonic()
    with socket.create_connection(("127.0.0.1", rover.vehicle.port)) as station:

        def ask(mode: int) -> None:
            values = {"param1": 1.0, "param2": float(mode)}
            target = {"target_system": 1, "target_component": 1}
            station.sendall(packer.pack("COMMAND_LONG", command=SET_MODE, **values, **target))

        ask(HOLD)
        rover.wait(lambda: rover.phase is AutopilotPhase.ELSEWHERE)
        elsewhere = time.monotonic()
        ask(GUIDED)
        rover.wait(lambda: rover.autopilot.mode == "guided")
        rover.go_on(1.0)
        assert rover.phase is AutopilotPhase.ELSEWHERE
    assert not rover.relay.of_hub(elsewhere)
    assert not rover.relay.orders(changed)
    assert "not asked for here" in rover.autopilot.why
    rover.operator.order(VehicleOrder.DRIVE)
    rover.wait(lambda: rover.phase is AutopilotPhase.DRIVING)
    rover.go_on(0.5)
    assert not rover.relay.moving(elsewhere), "the stick was deflected all the time"
    rover.move(AHEAD)


def follows(site: AutopilotSite) -> None:
    """Have it follow velocities."""
    site.drive()
    site.wait(lambda: not site.autopilot.why, why="it waits for a neutral velocity:")


def go_ahead(site: AutopilotSite, metres: float) -> None:
    """Give a goal ahead of the vehicle."""
    at = site.robot
    x, y = Pose(x=at.x, y=at.y, theta=at.theta).outward(metres, 0.0)
    site.operator.client.publish(GOAL_COMMAND, GoalCommand(points=(Point(x=x, y=y),)))


@pytest.mark.soak
def test_a_goal_arrives_and_ends_with_a_stop_another_mode_and_disarming(
    lasting: AutopilotSite,
) -> None:
    site = lasting
    follows(site)
    go_ahead(site, 1.5)
    site.wait(lambda: site.task.task is Task.REACHED, why="the goal was not reached:")
    go_ahead(site, 20.0)
    site.wait(lambda: site.speed > 0.3)
    stopped = time.monotonic()
    site.operator.client.publish(STOP, Stop(reason="space"))
    stands(site)
    assert commanded_after(site, stopped) < COMMANDED_S
    assert site.task.cause is Cause.STOP
    for order, name, whys in (
        (VehicleOrder.MODE, "hold", ("it is asked for the mode hold", "it is in hold")),
        (VehicleOrder.DISARM, "", ("it was asked to disarm", "it is disarmed")),
    ):
        go_ahead(site, 20.0)
        site.wait(lambda: site.speed > 0.3, why=f"it does not go: {site.task}")
        left = time.monotonic()
        site.operator.order(order, name)
        site.wait(lambda: site.task.task is Task.CANCELLED, why="the goal goes on:")
        assert site.task.cause is Cause.DRIVER
        assert site.task.why.startswith(whys), "the reason, before or after the vehicle obeyed"
        go_ahead(site, 20.0)
        site.wait(lambda: site.task.why.startswith("not begun: "))
        stands(site)
        follows(site)
        site.go_on(1.0)
        assert commanded_after(site, left) < COMMANDED_S, "only a new goal begins to move it"
    go_ahead(site, 1.5)
    site.wait(lambda: site.task.task is Task.REACHED, why=f"it does not go again: {site.task}")


def test_who_has_no_control_may_disarm_it_and_do_no_more(rover: AutopilotSite) -> None:
    rover.operator.takes_control()
    rival = Operator(rover.hub.endpoint, "rival")
    with closing(rival.client):
        begun = time.monotonic()
        rival.order(VehicleOrder.MODE, "hold")
        rover.go_on(0.5)
        assert not rover.relay.orders(begun)
        rival.order(VehicleOrder.DISARM)
        rover.wait(lambda: rover.phase is AutopilotPhase.DISARMED)
        assert rover.relay.orders(begun) == [(ARM, 0.0, 0.0)]
        begun = time.monotonic()
        rival.order(VehicleOrder.ARM)
        rover.go_on(0.5)
        assert not rover.relay.orders(begun)


def test_it_holds_when_it_has_lost_its_operator(rover: AutopilotSite) -> None:
    rover.operator.takes_control()
    rover.operator.client.close()
    rover.operator = Operator(rover.hub.endpoint, "another")
    rover.wait(lambda: rover.autopilot.mode == "hold", why="it did not hold:")
    assert rover.phase is AutopilotPhase.ELSEWHERE


@pytest.mark.soak
def test_killed_processes_leave_a_vehicle_that_stands_and_waits_for_a_neutral_stick(
    tmp_path: Path,
) -> None:
    with closing(AutopilotSite(tmp_path, "rover", _NO_RECEIVER)) as site:
        site.drive()
        site.move(AHEAD)
        for kill in (navigation_killed, driver_killed, autopilot_killed, hub_killed):
            kill(site)


def navigation_killed(site: AutopilotSite) -> None:
    killed = time.monotonic()
    os.kill(site.hub.pids["navigation"], signal.SIGKILL)
    stands(site)
    site.go_on(1.5)
    assert commanded_after(site, killed) < COMMANDED_S, "the stick is still deflected"
    site.move(AHEAD)


def driver_killed(site: AutopilotSite) -> None:
    killed = time.monotonic()
    os.kill(site.hub.pids["driver"], signal.SIGKILL)
    stands(site)
    site.wait(lambda: site.phase is AutopilotPhase.ELSEWHERE)
    site.go_on(0.5)
    assert commanded_after(site, killed) < COMMANDED_S
    assert not site.relay.orders(killed), "it was armed, and another's"
    site.operator.order(VehicleOrder.DRIVE)
    site.wait(lambda: site.phase is AutopilotPhase.DRIVING)
    site.go_on(0.5)
    assert not site.relay.moving(killed + COMMANDED_S), "the stick is still deflected"
    site.move(AHEAD)


def autopilot_killed(site: AutopilotSite) -> None:
    killed = time.monotonic()
    site.start_vehicle_again()
    site.wait(lambda: site.phase is not AutopilotPhase.DRIVING)
    site.wait(lambda: site.phase is AutopilotPhase.DISARMED and site.autopilot.armable)
    assert not site.relay.orders(killed)
    assert commanded_after(site, killed) < 1.5
    site.drive()
    site.move(AHEAD)


def hub_killed(site: AutopilotSite) -> None:
    killed = time.monotonic()
    site.hub.process.send_signal(signal.SIGKILL)
    end = killed + 10.0
    while not (site.speed < 0.05 and time.monotonic() > killed + 0.5):
        assert time.monotonic() < end
    assert commanded_after(site, killed) < COMMANDED_S
