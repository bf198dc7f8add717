"""The navigation process: follows velocity commands and goals, and publishes the robot's state."""

from __future__ import annotations

import logging
import math
import random
import sys
import time

from hub.control_gate import ControlGate
from hub.gcm import battery, diagnostics, edges, imu, navigation, ranges
from hub.gcm.capability import Abilities, Capability
from hub.gcm.control import ControlState
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import Assistance, Cause, DriveState, MotionState, Task
from hub.gcm.own_navigation import DRIVE_GOAL, OWN_NAVIGATION
from hub.gcm.transforms import TRANSFORMS
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.navigation.dynamic_window import body_of
from hub.modules.navigation.frame import FrameMemory
from hub.modules.navigation.map_requests import MapRequests
from hub.modules.navigation.own_pilot import OwnPilot
from hub.modules.navigation.path_follower import PathFollower
from hub.modules.navigation.problems import Lately, known_edges, problems
from hub.modules.navigation.reports import robot_state, status, transforms
from hub.modules.navigation.speed_governor import HELD, SpeedGovernor
from hub.paths import for_pose
from hub.pose import wrapped
from hub.robots.description import RobotDescription
from hub.runtime import publish_on_request, run_module, stop_after_sleep
from hub.vehicle_watch import VehicleWatch

_NOT_BEGUN = {MotionState.NO_DRIVER: Cause.DRIVER, MotionState.MOVING: Cause.STICK}
"""The cause that a refused task reports, by the state of motion."""
_JUMP, _TURN = 0.3, 0.5
"""The robot has lost its place if a restarted driver reports a pose farther off than this
[m, rad]."""

_NOT_TAKEN = ("too old", "out of order", "out of range")
"""Why the client drops a message, as it counts them."""

_logger = logging.getLogger(__name__)

_COMMAND_PERIOD = 1.0 / navigation.DRIVE_COMMAND.rate_hz
_STATE_PERIOD = 1.0 / navigation.ROBOT_STATE.rate_hz
_STATUS_PERIOD = 1.0 / navigation.NAVIGATION_STATUS.rate_hz
_SILENCE_PERIOD = 0.2
"""Time between two looks for problems that no message shows [s]."""
_PROBLEMS_PERIOD = 1.0 / diagnostics.DIAGNOSTICS.rate_hz
_EDGES_PERIOD = 1.0 / edges.EDGES.rate_hz


class Navigation:
    """Connects the operator, the path follower, the speed governor and the driver."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._clock = time.monotonic
        # The count begins at a random number, so that a console notices a restart of navigation.
        self._governor = SpeedGovernor(
            robot.body.motions, self._clock(), stops=random.getrandbits(32)
        )
        self.pilot = PathFollower(body_of(robot), robot.body)
        self._own = OwnPilot(self.pilot, expected=bool(robot.ros.navigation))
        self._problems: tuple[str, ...] = ()
        self._had_edges = False
        self._lately = Lately()
        self._frames = FrameMemory(for_pose(robot.name))
        self._commanded = Twist()
        self._battery = battery.BatteryState()
        self._newest: tuple[navigation.DriveState, float] | None = None
        self._published: tuple[object, ...] = ()
        self._driver: int | None = None
        self._assistance = Assistance.ON
        self._gate = ControlGate(client, self._on_owner_change)
        self._vehicle = VehicleWatch(client, self._not_followed)
        client.subscribe(navigation.STOP, lambda message, _: self._stop(message.reason))
        stop_after_sleep(client, self._slept)
        client.subscribe(navigation.VELOCITY_COMMAND, self._command, late=self._command_late)
        client.subscribe(navigation.DRIVE_STATE, self.reported)
        client.subscribe(OWN_NAVIGATION, self._own.reported)
        client.subscribe(battery.BATTERY, self._powered)
        client.subscribe(ranges.RANGES, self._scanned)
        client.subscribe(imu.IMU, self._tilted)
        client.subscribe(navigation.GOAL_COMMAND, self.go)
        client.subscribe(navigation.TURN_COMMAND, self._turn)
        client.subscribe(navigation.ASSISTANCE_COMMAND, self._assist)
        client.subscribe(navigation.LANDMARK_CORRECTION, self._correct)
        client.define(
            navigation.DRIVE_COMMAND,
            DRIVE_GOAL,
            navigation.ROBOT_STATE,
            navigation.NAVIGATION_STATUS,
            diagnostics.DIAGNOSTICS,
            edges.EDGES,
            TRANSFORMS,
        )
        publish_on_request(client, navigation.ROBOT_STATE, self._publish_state)
        publish_on_request(client, navigation.NAVIGATION_STATUS, self._publish_status)
        self._maps = MapRequests(client, self.pilot, self._clock)
        self._deadline = client.alarm(self._update)
        client.every(_COMMAND_PERIOD, self._cycle)
        client.every(_STATE_PERIOD, self._publish_state)
        client.every(_STATUS_PERIOD, self._publish_status)
        client.every(_PROBLEMS_PERIOD, self._publish_problems)
        client.every(_SILENCE_PERIOD, self._look_for_problems)
        client.every(1.0 / TRANSFORMS.rate_hz, self._publish_transforms)
        client.every(_EDGES_PERIOD, self._publish_edges)

    def finish(self) -> None:
        """Stop the robot."""
        self._governor.stop()
        self._drive()

    def _command(self, command: TwistStamped, reception: MessageInfo) -> None:
        sender = reception.publisher
        if not self._gate.obeys(sender):
            if not command.neutral:  # idle consoles send neutral all the time
                self._gate.admits(navigation.VELOCITY_COMMAND, reception)
            return
        now = self._clock()
        self._governor.command(sender, command.twist, now - reception.age, now)
        self._update()

    def _command_late(self, command: TwistStamped, reception: MessageInfo) -> None:
        """Report that a motion was refused, as its command was too old."""
        if not command.neutral and self._gate.obeys(reception.publisher):
            self._lately.came_late(reception.age, self._clock())
            self._look_for_problems()

    def _stop(self, reason: str) -> None:
        """Stop the robot and end its task, for this reason (empty: none was given)."""
        why = f"stopped: {reason or 'no reason given'}"
        self.pilot.task.end(Task.CANCELLED, why, Cause.STOP, self._clock())
        self._governor.stop()
        self._drive()
        self._update()
        _logger.warning("%s", why)

    def _slept(self, why: str) -> None:
        self._stop(why)
        self._lately.slept(why, self._clock())
        self._look_for_problems()

    def _on_owner_change(self, state: ControlState, before: int) -> None:
        """Another client has control than before."""
        self._governor.controlled_by(state.owner, before)
        if state.owner and before:
            why = f"{state.operator} has control now"
            self.pilot.task.end(Task.CANCELLED, why, Cause.CONTROL, self._clock())
        self._drive()
        self._update()

    def reported(self, state: navigation.DriveState, reception: MessageInfo) -> None:
        """Take what the driver reports."""
        now = self._clock()
        if self._driver not in (None, reception.publisher):
            _logger.warning("the driver restarted: the robot waits for a neutral command")
            if self._newest is not None and _has_jumped(self._newest[0], state):
                self._end_task("the driver restarted and reports another place", now)
            self._governor.driver_restarted()
        self._driver = reception.publisher
        before = self._frames.frame.number
        frame = self._frames.reported(state)
        if frame is not None:
            if frame.number != before:
                self._end_task("the robot has lost its place", now)
            _logger.info("the robot's pose is in frame %d", frame.number)
            self.pilot.restart(frame.odom)
        self._newest = (state, reception.measured)
        self._governor.driver_reported(now)
        self.pilot.reported(state, reception.measured, now)

    def _powered(self, state: battery.BatteryState, _reception: MessageInfo) -> None:
        self._battery = state

    def _scanned(self, readings: ranges.RangeReadings, reception: MessageInfo) -> None:
        """Take ranges of the driver whose poses are known."""
        if reception.publisher != self._driver:
            return
        self.pilot.scanned(readings, reception.measured, self._clock())
        self._look_for_problems()

    def _look_for_problems(self) -> None:
        """Write and publish problems that are new, without waiting for the next second."""
        found = self._found_problems()
        names = tuple(each.name for each in found)
        if names != self._problems:
            for each in found:
                if each.name not in self._problems:
                    _logger.warning("%s", each.message)
            self._problems = names
            self._publish_problems()

    def _found_problems(self) -> tuple[diagnostics.DiagnosticStatus, ...]:
        now = self._clock()
        return (*self._lately.problems(now), *problems(self.pilot, now))

    def _tilted(self, value: imu.Imu, reception: MessageInfo) -> None:
        self.pilot.tilted(value, reception.measured)

    def _not_followed(self, why: str) -> None:
        """End the task: when the vehicle follows again, it begins to move only on an order."""
        self._end_task(why, self._clock())
        self._drive()
        self._update()

    def _end_task(self, why: str, now: float) -> None:
        """End the task: the driver cannot go on with it."""
        self.pilot.task.end(Task.CANCELLED, why, Cause.DRIVER, now)
        self._governor.end_task()

    def go(self, goal: navigation.GoalCommand, reception: MessageInfo) -> None:
        """Begin the task of a goal, or refuse it."""
        if not self._gate.admits(navigation.GOAL_COMMAND, reception):
            return
        now = self._clock()
        if not goal.points:
            self.pilot.go(goal, reception.publisher, now)
            self._update()
            return
        why = self._own.refusal(now) or self._vehicle.why or self._governor.begin_task(now)
        if why:
            usual = Cause.DRIVER if self._vehicle.why else Cause.BUSY
            cause = _NOT_BEGUN.get(self._governor.state(now), usual)
            self.pilot.task.refuse(goal, reception.publisher, why, cause, now)
        else:
            why = self.pilot.go(goal, reception.publisher, now)
        if not why:
            self._own.begin(now)
        self._begun("a goal", why)
        self._maps.ask()

    def _turn(self, command: navigation.TurnCommand, reception: MessageInfo) -> None:
        if not self._gate.admits(navigation.TURN_COMMAND, reception):
            return
        now = self._clock()
        why = self._vehicle.why or self._governor.begin_task(now)
        why = why or self.pilot.turn(command, reception.publisher, now)
        self._begun("a turn", why)

    def _begun(self, what: str, why: str) -> None:
        if why:
            _logger.warning("%s is not followed: %s", what, why)
        self._drive()
        self._update()

    def _assist(self, command: navigation.AssistanceCommand, reception: MessageInfo) -> None:
        if self._gate.admits(navigation.ASSISTANCE_COMMAND, reception):
            self.pilot.assist(command.assistance, self._clock())
            self._update()

    def _correct(self, landmark: navigation.LandmarkCorrection, reception: MessageInfo) -> None:
        if self._gate.admits(navigation.LANDMARK_CORRECTION, reception):
            _logger.info("landmark: %s", self.pilot.correct(landmark, self._clock()))

    def _cycle(self) -> None:
        self._drive()
        self._update()

    def _drive(self) -> None:
        """Decide on the velocity, or the robot's own goal, and publish it to the driver."""
        now = self._clock()
        self._governor.state(now)  # applies its time limits first
        goal = self._own.steered(self._governor, now)
        if self._governor.held is not Cause.NONE:
            self.pilot.task.hold(self._governor.held, HELD[self._governor.held], now)
        elif self._governor.has_task:
            steered = (0.0, 0.0) if goal is not None else self.pilot.steered(now)
            if steered is None:
                self._governor.end_task()
            else:
                self._governor.steer(*steered, now)
        self._commanded = given = self._governor.velocity(now)
        if goal is not None:
            self._client.publish(DRIVE_GOAL, goal)
            return
        if self._governor.state(now) is MotionState.MOVING:
            given = self.pilot.assisted(given, now)
        elif not self.pilot.task.active:
            self.pilot.rest()
        self._client.publish(navigation.DRIVE_COMMAND, TwistStamped.of(given))

    def _update(self) -> None:
        """Act on changes of state without waiting for the next cycle."""
        now = self._clock()
        velocity = self._governor.velocity(now)
        task = self.pilot.task
        if task.active and not self._governor.has_task:
            task.end(Task.CANCELLED, "somebody drives", Cause.STICK, now)
        elif self._governor.has_task and not task.active:
            self._governor.end_task()
            if task.by_robot:
                self._drive()  # ends the robot's goal without waiting for the next cycle
        if velocity != self._commanded:
            self._drive()
        self._deadline.due = self._governor.deadline
        self._update_assistance(now)
        said = (
            task.number,
            task.state,
            (task.cause, task.why),
            self._governor.driver,
            len(task.points),
            task.route,
        )
        if said != self._published:
            self._published = said
            self._publish_status()

    def _update_assistance(self, now: float) -> None:
        assistance = self.pilot.assistance(now)
        if assistance is not self._assistance:
            self._assistance = assistance
            off = assistance is Assistance.OFF
            _logger.warning(
                "assistance is %s", "off: the robot drives into things" if off else "on"
            )

    def _publish_state(self) -> None:
        if self._newest is None:
            return
        drive, measured = self._newest
        now = self._clock()
        counts = self._client.faults.counts
        refused = self._governor.refused + self._gate.refused
        refused += sum(counts[reason] for reason in _NOT_TAKEN)
        self._frames.corrected(self.pilot.correction.odom)
        frame = self._frames.frame.number
        state = robot_state(drive, self._battery, self.pilot, self._governor, refused, frame, now)
        self._client.publish(navigation.ROBOT_STATE, state, measured=measured)

    def _publish_transforms(self) -> None:
        if self._newest is not None and self._client.has_subscribers(TRANSFORMS):
            drive, measured = self._newest
            given = transforms(drive, self.pilot.correction.odom)
            self._client.publish(TRANSFORMS, given, measured=measured)

    def _publish_problems(self) -> None:
        found = self._found_problems()
        self._client.publish(diagnostics.DIAGNOSTICS, diagnostics.Diagnostics(status=found))

    def _publish_edges(self) -> None:
        known = known_edges(self.pilot)
        if known.cells or self._had_edges:
            self._client.publish(edges.EDGES, known)
        self._had_edges = bool(known.cells)

    def _publish_status(self) -> None:
        said = status(self.pilot.task, self._governor.driver, self._clock())
        self._client.publish(navigation.NAVIGATION_STATUS, said)


def _has_jumped(before: DriveState, after: DriveState) -> bool:
    """Whether the dead reckoning of a restarted driver begins elsewhere than the last one ended."""
    way = math.hypot(after.x - before.x, after.y - before.y)
    near = way <= _JUMP and abs(wrapped(after.theta - before.theta)) <= _TURN
    return not near


def abilities(_robot: RobotDescription) -> Abilities:
    """The abilities of navigation on a robot."""
    return Abilities(
        provides=(Capability.NAV_MOVE, Capability.NAV_STATE, Capability.NAV_GOAL),
        needs=(Capability.DRV_BASE,),
    )


def main() -> int:
    """Run the process."""
    purpose = "Follows velocity commands and goals, avoids obstacles, reports the robot's state."
    return run_module(
        "navigation", purpose, abilities, lambda client, robot: Navigation(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
