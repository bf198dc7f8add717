"""The computer of a driven robot sleeps: what was commanded before does not drive afterwards."""

from __future__ import annotations

import time
from contextlib import ExitStack, closing
from pathlib import Path

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import GROUND_TRUTH, ROBOT_STATE, VELOCITY_COMMAND, MotionState
from hub.ipc.client import Client
from tests.support.waiting import until
from tests.support.wall_clock import WallClock
from tests.system.harness import HubProcess, Observer

SLEEP_S = 12
TURN = 0.3
WATCHED_S = 1.0


def test_a_held_key_does_not_drive_after_a_sleep_before_it_was_up(
    tmp_path: Path, stack: ExitStack
) -> None:
    clock = WallClock(tmp_path)
    modules = ("driver", "navigation")
    hub = HubProcess(tmp_path, modules=modules, environment=clock.environment)
    stack.enter_context(closing(hub))
    observer = stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH, ROBOT_STATE)))
    operator = stack.enter_context(closing(Client("operator", hub.endpoint)))
    wanted = 0.0

    def send() -> None:
        operator.publish(VELOCITY_COMMAND, TwistStamped.planar(0.0, wanted))

    def both() -> None:
        operator.listen(0.005)
        observer.client.listen(0.005)

    def commanded() -> float:
        return float(observer.history[-1][1].commanded_angular)

    def state() -> MotionState:
        return MotionState(observer.seen[ROBOT_STATE.name][-1][1].motion)

    operator.define(VELOCITY_COMMAND)
    operator.wait_connected(10.0)
    operator.every(0.05, send)
    until(lambda: state() is MotionState.STANDING, 10.0, meanwhile=both)
    wanted = TURN
    until(lambda: commanded() > 0.0, 10.0, meanwhile=both)

    clock.sleep(SLEEP_S)
    until(lambda: commanded() == 0.0, 5.0, "it drives on after the sleep", meanwhile=both)
    until(lambda: state() is MotionState.STOPPED, 5.0, meanwhile=both)
    observer.history.clear()
    end = time.monotonic() + WATCHED_S
    until(lambda: time.monotonic() > end, 5.0, meanwhile=both)
    assert {truth.commanded_angular for _, truth in observer.history} == {0.0}
    assert f"the robot's computer slept for {SLEEP_S}.0 s" in hub.log.read_text()
    assert f"this computer slept for {SLEEP_S}.0 s" in hub.log.read_text()

    wanted = 0.0
    until(lambda: state() is MotionState.STANDING, 10.0, meanwhile=both)
    wanted = TURN
    until(lambda: commanded() > 0.0, 10.0, meanwhile=both)
