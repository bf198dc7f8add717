"""A robot with ROS as the body of a robot: its topics are what it measures and follows."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import Final

from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.joints import JointState, JointStates
from hub.gcm.navigation import GroundTruth
from hub.gcm.own_navigation import DriveGoal, OwnNavigation
from hub.gcm.vehicle import LightState, VehicleState
from hub.plain_text import plain
from hub.robots.description import RobotDescription
from hub.robots.interfaces import FileLoop, Sensors
from hub.robots.ros.diagnosis import RosDiagnosis
from hub.robots.ros.goals.own_goals import OwnGoals, goal_tag
from hub.robots.ros.line import RosLine, RosMessage
from hub.robots.ros.newest import Newest
from hub.robots.ros.problems import battery_problems, line_problems
from hub.robots.ros.robot_claim import RobotClaim
from hub.robots.ros.scans import RosRanges
from hub.robots.ros.services import RosServices
from hub.robots.ros.settings import RosSettings
from hub.robots.ros.sparse_watch import SparseWatch
from hub.robots.ros.topic_reader import TopicReader
from hub.robots.ros.velocities import RosVelocities
from hub.robots.ros.whereabouts import RosWhereabouts
from hub.ros import messages
from hub.ros.battery import BatteryReader
from hub.ros.goal_messages import GoalPlace
from hub.ros.values import RosValue

_BATTERY_S: Final = 60.0
_IMU_S: Final = 0.5
_SLOW_S: Final = 3.0
"""Ages up to which measurements count [s]: of the battery, the IMU, all others."""
_MOST_ANGLE: Final = 100.0
"""Largest angle of a joint [rad]."""


class RosBody:
    """Implements `Body`, `BodyWakes`, `BodyStops`, `BodyLights`, `BodyJoints`, `BodyNavigates`."""

    def __init__(
        self,
        robot: RobotDescription,
        line: RosLine,
        clock: Callable[[], float] = time.monotonic,
        claim: RobotClaim | None = None,
    ) -> None:
        """Subscribe; nothing is sent before the first `advance`.

        Args:
            robot: The robot file.
            line: The line to the robot.
            clock: The monotonic clock [s].
            claim: While another process has it, the line is not opened; None: others may drive too.
        """
        self._claim = claim
        self._robot, self._line, self._clock = robot, line, clock
        self._table = table = robot.ros
        self._watch: SparseWatch | None = None
        self._velocities = RosVelocities(line, table)
        self._own = OwnGoals(line, table.navigation, goal_tag(robot.name, table.identity))
        self._services = RosServices(line)
        self._settings = RosSettings(robot, line, self._services)
        self._ranges = tuple(RosRanges(each.sensors) for each in robot.ranges)
        self._charge = BatteryReader(percent=table.battery_percent)
        self._battery = Newest(self._charge.read, _BATTERY_S)
        self._imu = Newest(messages.imu, _IMU_S)
        self._pressure = Newest(messages.fluid_pressure, _SLOW_S)
        self._joints = Newest(messages.joint_states, _SLOW_S)
        self._diagnosis = RosDiagnosis()
        self._touched: dict[int, bool] = {}
        self._reader = TopicReader(line)
        self._places = RosWhereabouts(robot, line, self._reader)
        for source, topic in (
            (self._battery, table.battery),
            (self._imu, table.imu),
            (self._pressure, table.pressure),
            (self._joints, table.joints),
        ):
            self._reader.read(topic, source.take)
        self._reader.read(table.diagnostics, self._said, each=True)
        for group, ranges in zip(robot.ranges, self._ranges, strict=True):
            self._reader.read(group.topic, self._scanned(ranges))

    def command(self, twist: Twist) -> None:
        """Follow a velocity, after the end of a goal of the robot's own navigation."""
        now = self._clock()
        self._own.end(now)
        # Two that drive at once would pull the robot about: it stands until the goal has ended.
        wanted = self._possible(twist) if self._own.settled(now) else Twist()
        self._velocities.stream.command(wanted, now)
        self._velocities.send(now)

    def go(self, goal: DriveGoal) -> None:
        """Drive to a place by the robot's own navigation, and send no velocities."""
        now = self._clock()
        place = GoalPlace(frame=self._places.frame, x=goal.x, y=goal.y, theta=goal.theta)
        self._own.go(goal.number, place, now)
        self._share_wheels(now)

    def own_navigation(self) -> OwnNavigation:
        """The state of the robot's own navigation."""
        return self._own.report(self._clock())

    def advance(self, seconds: float) -> None:
        """Read the line, and send what is due."""
        self._look()
        self._settings.advance(seconds)
        self._places.advance(self._clock())
        if self._watch is not None:
            self._watch.step()

    def wake_by(self, loop: FileLoop, report: Callable[[], bool]) -> None:
        """Report new messages soon; at rest only read the line, so that its ages are right."""

        def woken() -> None:
            if not report():
                self._look()

        self._watch = SparseWatch(loop)
        self._line.watch(self._watch, woken)

    def stop(self) -> None:
        """End all goals of the robot's own navigation, and call its stop, if it has these."""
        self._own.stop(self._clock())
        self._services.stop(self._table.stop_service)

    def set_light(self, name: str, brightness: float) -> None:
        """Set the brightness of a light."""
        self._settings.set_light(name, brightness)

    def turn_joint(self, name: str, rate: float) -> None:
        """Turn a joint [rad/s]."""
        self._settings.turn_joint(name, rate, self._joint_angles())

    def ground_truth(self) -> GroundTruth | None:
        """Not known."""
        return None

    def close(self) -> None:
        """Leave the line."""
        self._line.close()
        if self._claim is not None:
            self._claim.close()

    def sensors(self, _stamp: float) -> Sensors:
        """The present measurements."""
        self._reader.decode_newest()
        now = self._clock()
        place = self._places.known(now)
        imu, battery = self._imu.value(now), self._battery.value(now)
        pressure = self._pressure.value(now)
        roll, pitch, _ = imu.roll_pitch_yaw if imu is not None else (math.nan,) * 3
        floats = self._robot.heave_limit > 0.0 and place is not None
        return Sensors(
            known=place is not None,
            measured=place.measured if place is not None else math.nan,
            x=place.pose.x if place is not None else 0.0,
            y=place.pose.y if place is not None else 0.0,
            z=place.z if place is not None and floats else 0.0,
            theta=place.pose.theta if place is not None else 0.0,
            velocity=place.velocity if place is not None else Twist(),
            commanded=self._velocities.wanted,
            scans=tuple(each.scan for each in self._ranges),
            scanned=max(
                (each.measured for each in self._ranges if math.isfinite(each.measured)),
                default=math.nan,
            ),
            battery_voltage=battery.voltage if battery is not None else math.nan,
            battery_fraction=battery.percentage if battery is not None else math.nan,
            battery=battery,
            imu=imu,
            roll=roll,
            pitch=pitch,
            height=place.z if place is not None and floats else math.nan,
            turning=imu.angular_velocity if imu is not None else None,
            acceleration=imu.linear_acceleration if imu is not None else None,
            pressure=pressure.fluid_pressure if pressure is not None else math.nan,
            climb=place.velocity.linear.z if place is not None and floats else math.nan,
            reckoning=self._places.number,
            diagnostics=tuple(self._problems(now)),
            joints=self._joint_states(now),
            vehicle=VehicleState(
                activity=self._activity,
                lights=tuple(
                    LightState(name=each.name, brightness=self._settings.brightness(each.name))
                    for each in self._robot.lights
                ),
            ),
        )

    def _look(self) -> None:
        """Read the line, and send what is due."""
        now = self._clock()
        if self._claim is None or self._claim.held(now):
            self._line.advance(now)
        self._own.advance(now)
        self._share_wheels(now)
        self._velocities.advance(now)

    def _share_wheels(self, now: float) -> None:
        """Be silent while the robot's own navigation drives; stand when it drives no more."""
        if self._own.drives:
            self._velocities.stream.leave()
        else:
            self._velocities.stream.take_back(now)

    def _said(self, value: RosValue, message: RosMessage) -> None:
        self._diagnosis.take(value, message.arrived)

    def _scanned(self, ranges: RosRanges) -> Callable[[RosValue, RosMessage], None]:
        def take(value: RosValue, message: RosMessage) -> None:
            stamp = time.time() - (self._clock() - message.measured)
            ranges.take(value, message.measured, stamp)

        return take

    def _possible(self, twist: Twist) -> Twist:
        """A velocity without the motions that the robot file does not have."""
        robot, linear, angular = self._robot, twist.linear, twist.angular
        return Twist(
            linear=Vector3(
                x=_within(linear.x, robot.linear_limit),
                y=_within(linear.y, robot.sway_limit),
                z=_within(linear.z, robot.heave_limit),
            ),
            angular=Vector3(
                x=_within(angular.x, robot.roll_limit),
                y=_within(angular.y, robot.pitch_limit),
                z=_within(angular.z, robot.angular_limit),
            ),
        )

    def _joint_angles(self) -> dict[str, float]:
        return {each.name: each.position for each in self._joint_states(self._clock())}

    def _joint_states(self, now: float) -> tuple[JointState, ...]:
        known: JointStates | None = self._joints.value(now)
        return tuple(
            JointState(
                name=each.name,
                position=_angle(known.position_of(each.name)) if known is not None else math.nan,
            )
            for each in self._robot.joints
        )

    @property
    def _activity(self) -> str:
        state = self._line.state
        if not state.up:
            return "gone" if state.connections else "links"
        return "navigates" if self._own.drives else ""

    def _problems(self, now: float) -> Iterator[DiagnosticStatus]:
        if self._claim is not None and self._claim.rival:
            text = (
                f"{self._claim.rival} has this robot: end it, such as another hub or `rune drive`"
            )
            yield DiagnosticStatus(level=Severity.ERROR, name="ros", message=text)
            return
        yield from line_problems(self._line, self._table.address, self._places, now)
        if self._line.state.up:
            for text in self._velocities.problems(now):
                yield DiagnosticStatus(level=Severity.WARN, name="velocities", message=text)
        yield from battery_problems(self._charge, scaled=self._table.battery_percent)
        for topic, why in self._reader.faults.items():
            text = f"messages of {topic} cannot be used: {why}"
            yield DiagnosticStatus(level=Severity.WARN, name=topic[:64], message=text)
        for name, why in self._line.state.refusals.items():
            drives = name == self._table.cmd_vel
            text = f"the robot's bridge does not serve {name}: {plain(why)[:200]}"
            if drives:
                text = f"the robot cannot be driven: {text}"
            if name not in self._services.failed:
                level = Severity.ERROR if drives else Severity.WARN
                yield DiagnosticStatus(level=level, name=name[:64], message=text)
        for service, why in self._services.failed.items():
            text = f"the service {service} failed: {why}"
            yield DiagnosticStatus(level=Severity.ERROR, name=service[:64], message=text)
        yield from self._own.problems(now)
        yield from self._diagnosis.problems(now)


def _angle(position: float) -> float:
    """The angle of a joint [rad]; NaN: it makes no sense."""
    return position if abs(position) <= _MOST_ANGLE else math.nan


def _within(velocity: float, limit: float) -> float:
    return max(-limit, min(limit, velocity)) + 0.0  # never -0.0
