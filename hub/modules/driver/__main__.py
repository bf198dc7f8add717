"""The driver process: passes drive commands to the hardware and publishes its state."""

from __future__ import annotations

import math
import secrets
import sys
import time
from collections.abc import Callable
from typing import Any, TypeAlias

from hub.gcm import (
    battery,
    diagnostics,
    environment,
    flight,
    imu,
    joints,
    navigation,
    ranges,
    vehicle,
)
from hub.gcm.capability import Abilities, Capability
from hub.gcm.control import ControlState
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.simulation import SIMULATION_PAUSE, SimulationPause
from hub.gcm.standard import Time
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.modules.driver import reports
from hub.modules.driver.autopilot_reports import AutopilotReports
from hub.modules.driver.navigator import Navigator
from hub.modules.driver.operator_loss import OperatorLoss
from hub.modules.driver.own_goals import BodyGoals
from hub.modules.driver.publishing_rate import PublishingRate
from hub.modules.driver.vehicle_orders import VehicleOrders
from hub.modules.driver.watchdog import CommandWatchdog
from hub.robots.description import RobotDescription
from hub.robots.interfaces import BodyWakes, Sensors
from hub.robots.registry import kind_of
from hub.runtime import run_module, stop_after_sleep

_PERIOD = 1.0 / navigation.DRIVE_STATE.rate_hz
"""Time between two reports of the hardware [s]."""
_RESTING_PERIOD = 0.05
"""The same while the robot stands or only drifts, measures no more often, or its body wakes [s]."""
_WITH_COMMAND = 0.02
"""A report that is due within this time goes with a command: one wake-up in place of two [s]."""
_COMMAND_JITTER = 0.01
"""The report after that waits longer by this time, to go with the next command [s]."""
_CHANGING_PERIOD, _CHANGING = 0.003, 0.01
"""Time between two reports, and how long, after a command that starts or stops the robot [s]."""
_SOONEST = 0.01
"""Shortest time between two reports of a body that wakes [s]."""
_LONGEST_STEP = 0.25
"""Longest time that the hardware advances in one step; the rest of a pause is left out [s]."""

_Report: TypeAlias = Callable[[Sensors, float], object]
"""From measurements and their time [s since the epoch] to a message; None: not measured."""
_MEASUREMENTS: tuple[tuple[MessageDefinition[Any], _Report], ...] = (
    (battery.BATTERY, reports.battery),
    (environment.ENVIRONMENT, reports.environment),
    (imu.IMU, reports.imu),
    (flight.ALTITUDE, reports.altitude),
    (flight.FLUID_PRESSURE, reports.fluid_pressure),
)
"""Messages at rates of their own, each only from bodies that measure it."""


class Driver:
    """The hardware on the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._body = kind_of(robot).open_body(robot)
        self._wakes = isinstance(self._body, BodyWakes)
        self._rests = self._stands = True
        self._changing_until = -math.inf
        if isinstance(self._body, BodyWakes):
            self._body.wake_by(client.loop, self._report_soon)
        self._loss = OperatorLoss(self._body, robot)
        self._watchdog = CommandWatchdog()
        self._navigator = Navigator()
        self._stepped = time.monotonic()
        self._silence = client.alarm(self._watch)
        self._base_measured = math.nan
        self._measured: list[Time] = []
        self._due: dict[str, float] = {}
        # Each process has its own number: after a crash the dead reckoning starts elsewhere.
        self._reckoning = secrets.randbelow(2**32 - 1) + 1
        client.directory.follow(self._navigator.name, self._navigator.connected)
        client.subscribe(navigation.DRIVE_COMMAND, self._command)
        self._goals = BodyGoals(client, self._body, self._allows_goal)
        self._orders = VehicleOrders(
            client,
            self._body,
            robot,
            stop=self._halt,
            stopped=self._stopped,
            changed=self._control_changed,
        )
        stop_after_sleep(client, self._slept)
        self._paused = False
        if robot.simulated:
            client.subscribe(SIMULATION_PAUSE, self._pause)
        self._vehicle_rate = PublishingRate(vehicle.VEHICLE_STATE.rate_hz)
        self._problems_rate = PublishingRate(diagnostics.DIAGNOSTICS.rate_hz)
        self._autopilot = AutopilotReports(client, self._body)
        self._joints_rate = PublishingRate(1.0, joints.JOINT_STATES.rate_hz)
        client.define(
            navigation.DRIVE_STATE,
            ranges.RANGES,
            *(definition for definition, _ in _MEASUREMENTS),
            navigation.GROUND_TRUTH,
            vehicle.VEHICLE_STATE,
            diagnostics.DIAGNOSTICS,
            joints.JOINT_STATES,
        )
        self._next_report = client.alarm(self._report)
        self._reported = self._stepped
        self._report_at = self._next_report.due = self._stepped + _PERIOD

    def _command(self, command: TwistStamped, reception: MessageInfo) -> None:
        twist = command.twist
        now = time.monotonic()
        if self._paused:
            return
        obeys = self._navigator.obeys(reception.publisher, now)
        if obeys and self._watchdog.allows(now - reception.age, now, neutral=twist.neutral):
            self._silence.due = self._watchdog.deadline
            try:
                self._advance(now)  # the time until now passes with the velocity before
            finally:
                self._body.command(twist)
            if not twist.neutral:
                self._loss.watch.moved(now)
            if self._report_change(now, neutral=twist.neutral):
                return
            if self._rests and self._report_at - now < _WITH_COMMAND:
                self._report_by(now)
                self._report(_COMMAND_JITTER)
            elif not twist.neutral and (self._rests or not self._wakes):
                self._report_by(now + _PERIOD)

    def _report_change(self, now: float, *, neutral: bool) -> bool:
        """Report soon if a command starts or stops the robot; returns whether it does."""
        changes = neutral != self._stands and not self._wakes
        self._stands = neutral
        if changes:
            self._changing_until = now + _CHANGING
            self._report_by(max(now, self._reported) + _CHANGING_PERIOD)
        return changes

    def _allows_goal(self, reception: MessageInfo, now: float) -> bool:
        """Whether a goal is followed: as a velocity other than zero would be."""
        if self._paused or not self._navigator.obeys(reception.publisher, now):
            return False
        if not self._watchdog.allows(now - reception.age, now, neutral=False):
            return False
        self._silence.due = self._watchdog.deadline
        self._loss.watch.moved(now)
        return True

    def _pause(self, order: SimulationPause, _: MessageInfo) -> None:
        """Let the simulated time stand still, or run again."""
        self._advance(time.monotonic())
        self._halt()
        self._paused = bool(order.paused)

    def _stopped(self) -> None:
        """A robot without an operator that any client stops begins again to wait for one."""
        self._loss.watch.moved(time.monotonic())

    def _control_changed(self, state: ControlState) -> None:
        self._loss.watch.controlled_by(state.owner, time.monotonic())

    def _watch(self) -> None:
        """Stop the wheels if no command is fresh any more."""
        now = time.monotonic()
        try:
            self._advance(now)
        finally:
            if self._watchdog.expired(now):
                self._stop()

    def _stop(self) -> None:
        self._report_change(time.monotonic(), neutral=True)
        self._body.command(Twist())

    def _slept(self, _: str) -> None:
        """Stop: the commands until now are older than the sleep of the robot's computer."""
        try:
            self._halt()
        finally:
            self._orders.stop()

    def _halt(self) -> None:
        """Stop the wheels, and wait for a neutral command."""
        self._watchdog.expire()
        self._stop()

    def _report(self, later: float = 0.0) -> None:
        """Report; the next report of a body at rest comes `later` than usual [s]."""
        period = _RESTING_PERIOD + later
        self._reported = time.monotonic()
        try:
            self._watch()
            self._loss.update(self._stepped)
            self._rests = self._publish()
            if self._stepped < self._changing_until:
                period = _CHANGING_PERIOD
            elif not (self._rests or self._wakes):
                period = _PERIOD
        finally:  # also after a fault; after a pause the reports that were missed are left out
            self._next_report.due = self._report_at = max(self._report_at + period, self._stepped)

    def _report_soon(self) -> bool:
        """Report what the body has to read, now or soon; returns whether: not at rest."""
        if self._rests:
            return False
        now = time.monotonic()
        self._report_by(max(now, self._reported + _SOONEST))
        if self._report_at <= now:
            self._report()
        return True

    def _report_by(self, time: float) -> None:
        self._next_report.due = self._report_at = min(self._report_at, time)

    def _advance(self, now: float) -> None:
        seconds = min(now - self._stepped, _LONGEST_STEP)
        self._stepped = now
        if not self._paused:
            self._body.advance(seconds)

    def _publish(self) -> bool:
        """Publish each state that the hardware gives; returns whether it may rest."""
        now = time.monotonic()
        stamp = time.time()
        sensors = self._body.sensors(stamp)
        if sensors.known and sensors.measured != self._base_measured:  # NaN is always new
            self._base_measured = sensors.measured
            at = now if math.isnan(sensors.measured) else sensors.measured
            state = reports.drive_state(sensors, stamp - (now - at), self._reckoning)
            self._client.publish(navigation.DRIVE_STATE, state, measured=at)
        measured = [scan.header.stamp for scan in sensors.scans]
        if measured != self._measured:
            self._measured = measured
            readings = ranges.RangeReadings(scans=sensors.scans)
            at = now if math.isnan(sensors.scanned) else sensors.scanned
            self._client.publish(ranges.RANGES, readings, measured=at)
        self._publish_measurements(sensors, stamp, now)
        self._publish_vehicle(sensors, stamp, now)
        truth = self._body.ground_truth()
        if truth is not None:
            self._client.publish(navigation.GROUND_TRUTH, truth, measured=now)
        return sensors.slow or reports.rests(sensors)

    def _publish_vehicle(self, sensors: Sensors, stamp: float, now: float) -> None:
        """Publish what the body does besides its motion, what is wrong, and its joints."""
        state = reports.vehicle(sensors, stamp)
        self._orders.seen(state)
        if self._vehicle_rate.due(reports.change_of(state), now):
            self._client.publish(vehicle.VEHICLE_STATE, state, measured=now)
        self._autopilot.publish(stamp, now)
        self._goals.publish(now)
        found = reports.diagnostics(sensors, stamp)
        if self._problems_rate.due([(each.name, each.level) for each in found.status], now):
            self._client.publish(diagnostics.DIAGNOSTICS, found, measured=now)
        if sensors.joints and self._joints_rate.due(sensors.joints, now):
            states = reports.joints(sensors, stamp)
            self._client.publish(joints.JOINT_STATES, states, measured=now)

    def _publish_measurements(self, sensors: Sensors, stamp: float, now: float) -> None:
        """Publish each message of `_MEASUREMENTS` at its own rate, if the body measures it."""
        for definition, report in _MEASUREMENTS:
            due = self._due.get(definition.name, 0.0)
            if now >= due and (value := report(sensors, stamp)) is not None:
                self._due[definition.name] = max(due + 1.0 / definition.rate_hz, now)
                self._client.publish(definition, value, measured=now)

    def finish(self) -> None:
        """Stop the wheels and the joints."""
        self._stop()
        self._orders.stop_joints()
        self._goals.finish(self._body.advance)
        self._publish()


def build(client: Client, robot: RobotDescription) -> Callable[[], None]:
    """Connect the hardware to the bus."""
    return Driver(client, robot).finish


def abilities(robot: RobotDescription) -> Abilities:
    """The abilities of the driver on a robot."""
    has = {
        Capability.SIM_TRUTH: robot.simulated,
        Capability.DRV_HOLD: robot.holds,
        Capability.DRV_LIGHT: robot.lights,
        Capability.DRV_JOINT: robot.joints,
        Capability.DRV_ARM: robot.body.arms,
        Capability.DRV_MODE: kind_of(robot).modes,
    }
    return Abilities(provides=(Capability.DRV_BASE, *(each for each, part in has.items() if part)))


def main() -> int:
    """Run the process."""
    purpose = "Drives the robot's hardware: wheels, range sensors, bumpers, battery."
    return run_module("driver", purpose, abilities, build)


if __name__ == "__main__":
    sys.exit(main())
