"""The driver process: passes drive commands to the hardware and publishes its state."""

from __future__ import annotations

import dataclasses
import secrets
import sys
import time
from collections.abc import Callable

from hub.control_gate import follow_control
from hub.gcm import navigation
from hub.gcm.capability import Abilities, Capability
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.driver.navigator import Navigator
from hub.modules.driver.operator_loss import OperatorLoss
from hub.modules.driver.watchdog import CommandWatchdog
from hub.robots.description import RobotDescription
from hub.robots.registry import kind_of
from hub.runtime import run_module

_PERIOD = 0.01
"""Time between two steps of the hardware [s]."""
_STEPS_PER_REPORT = round(1.0 / navigation.DRIVE_STATE.rate_hz / _PERIOD)
_LONGEST_STEP = 0.25
"""Longest time that the hardware advances in one step; the rest of a pause is left out [s]."""


def build(client: Client, robot: RobotDescription) -> Callable[[], None]:
    """Connect the hardware to the bus."""
    base = kind_of(robot).open_base(robot)
    loss = OperatorLoss(base, robot)
    watchdog = CommandWatchdog()
    navigator = Navigator()
    clock = time.monotonic
    last = clock()
    steps = 0
    # Each process has its own number: after a crash the dead reckoning starts at another place.
    odometry = secrets.randbelow(2**32 - 1) + 1

    def report() -> None:
        now = clock()
        state = numbered(base.drive_state(time.time()), odometry)
        client.publish(navigation.DRIVE_STATE, state, measured=now)
        truth = base.ground_truth()
        if truth is not None:
            client.publish(navigation.GROUND_TRUTH, truth, measured=now)

    def command(twist: navigation.Twist, reception: MessageInfo) -> None:
        now = clock()
        obeys = navigator.obeys(reception.publisher, now)
        if obeys and watchdog.allows(now - reception.age, now, neutral=twist.neutral):
            base.set_velocity(twist.linear.x, twist.angular.z)
            if not twist.neutral:
                loss.watch.moved(now)

    def step() -> None:
        nonlocal last, steps
        now = clock()
        if watchdog.expired(now):
            base.set_velocity(0.0, 0.0)
        loss.update(now)
        base.advance(min(now - last, _LONGEST_STEP))
        last = now
        steps += 1
        if steps % _STEPS_PER_REPORT == 0:
            report()

    def finish() -> None:
        base.set_velocity(0.0, 0.0)
        report()

    client.directory.follow(navigator.name, navigator.connected)
    client.subscribe(navigation.DRIVE_COMMAND, command)
    follow_control(client, lambda state: loss.watch.controlled_by(state.owner, clock()))
    client.define(navigation.DRIVE_STATE, navigation.GROUND_TRUTH)
    client.every(_PERIOD, step)
    return finish


def numbered(state: navigation.DriveState, odometry: int) -> navigation.DriveState:
    """The state with a number for its dead reckoning, where the hardware gives it none."""
    return state if state.odometry else dataclasses.replace(state, odometry=odometry)


def abilities(robot: RobotDescription) -> Abilities:
    """The abilities of the driver on a robot."""
    simulated = (Capability.SIM_TRUTH,) if robot.simulated else ()
    return Abilities(provides=(Capability.DRV_BASE, *simulated))


def main() -> int:
    """Run the process."""
    purpose = "Drives the robot's hardware: wheels, range sensors, bumpers, battery."
    return run_module("driver", purpose, abilities, build)


if __name__ == "__main__":
    sys.exit(main())
