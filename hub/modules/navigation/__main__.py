"""The navigation process: follows fresh velocity commands, and says what is known of the robot."""

from __future__ import annotations

import logging
import sys
import time

from hub.gcm import navigation
from hub.gcm.capability import Abilities, Capability
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.robots.description import RobotDescription
from hub.runtime import publish_on_request, run_module

_logger = logging.getLogger(__name__)

_CHECK_PERIOD = 0.01
_COMMAND_PERIOD = 1.0 / navigation.DRIVE_COMMAND.rate_hz
_STATE_PERIOD = 1.0 / navigation.ROBOT_STATE.rate_hz


class Navigation:
    """Connects operator, governor and driver."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._clock = time.monotonic
        self._governor = SpeedGovernor(robot.linear_limit, robot.angular_limit, self._clock())
        self._sent: tuple[float, float] | None = None
        self._newest: tuple[navigation.DriveState, float] | None = None
        client.subscribe(navigation.STOP, self._stop)
        client.subscribe(navigation.VELOCITY_COMMAND, self._command)
        client.subscribe(navigation.DRIVE_STATE, self._report)
        client.define(navigation.DRIVE_COMMAND, navigation.ROBOT_STATE)
        publish_on_request(client, navigation.ROBOT_STATE, self._publish_state)
        client.every(_CHECK_PERIOD, self._drive_if_changed)
        client.every(_COMMAND_PERIOD, self._drive)
        client.every(_STATE_PERIOD, self._publish_state)

    def finish(self) -> None:
        """Leave the robot standing."""
        self._governor.stop()
        self._drive()

    def _command(self, twist: navigation.Twist, reception: Reception) -> None:
        now = self._clock()
        self._governor.command(
            reception.publisher, twist.linear.x, twist.angular.z, now - reception.age, now
        )
        self._drive_if_changed()

    def _stop(self, message: navigation.Stop, reception: Reception) -> None:
        del reception
        self._governor.stop()
        self._drive()
        _logger.warning("stopped: %s", message.reason or "no reason given")

    def _report(self, state: navigation.DriveState, reception: Reception) -> None:
        self._newest = (state, reception.measured)
        self._governor.driver_reported(self._clock())

    def _drive(self) -> None:
        self._sent = self._governor.velocity(self._clock())
        self._client.publish(navigation.DRIVE_COMMAND, navigation.Twist.planar(*self._sent))

    def _drive_if_changed(self) -> None:
        if self._governor.velocity(self._clock()) != self._sent:
            self._drive()

    def _publish_state(self) -> None:
        if self._newest is None:
            return
        drive, measured = self._newest
        counts = self._client.complaints.counts
        refused = self._governor.refused + counts["too old"] + counts["out of order"]
        state = robot_state(drive, self._governor.state(self._clock()), refused)
        self._client.publish(navigation.ROBOT_STATE, state, measured=measured)


def robot_state(
    drive: navigation.DriveState, motion: navigation.MotionState, refused: int
) -> navigation.RobotState:
    """What is known of the robot, from what its hardware reports."""
    return navigation.RobotState(
        stamp=drive.stamp,
        x=drive.x,
        y=drive.y,
        theta=drive.theta,
        linear=drive.linear,
        angular=drive.angular,
        commanded_linear=drive.commanded_linear,
        commanded_angular=drive.commanded_angular,
        sonar=drive.sonar,
        infrared=drive.infrared,
        bumpers=drive.bumpers,
        battery_voltage=drive.battery_voltage,
        battery_fraction=drive.battery_fraction,
        motion=motion,
        refused=refused,
    )


def abilities(robot: RobotDescription) -> Abilities:
    """What navigation can do on a robot."""
    del robot
    return Abilities(
        provides=(Capability.NAV_MOVE, Capability.NAV_STATE), needs=(Capability.DRV_BASE,)
    )


def main() -> int:
    """Run the process."""
    purpose = "Follows velocity commands, stops when they stop, and reports the robot's state."
    return run_module(
        "navigation", purpose, abilities, lambda client, robot: Navigation(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
