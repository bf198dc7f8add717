"""Range sensors that fall silent: navigation says it, drives slowly, and trusts no old range."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.gcm.diagnostics import DIAGNOSTICS, Severity
from hub.gcm.navigation import (
    DRIVE_STATE,
    Assistance,
    Cause,
    DriveState,
    GoalCommand,
    Point,
    Task,
)
from hub.gcm.ranges import RangeReadings, scan_of
from hub.modules.navigation.__main__ import Navigation
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.obstacle_memory import ObstacleMemory
from hub.modules.navigation.path_follower import CAREFUL_SPEED
from hub.modules.navigation.problems import problems
from hub.modules.navigation.range_watch import LEAST_S, PERIODS, RangeWatch
from hub.modules.navigation.task import LONGEST_HOLD_S
from hub.pose import Pose
from hub.robots.interfaces import Sensors
from hub.robots.simulated_base import SimulatedBase
from hub.sim.arena import load_arena
from tests.hub.modules.navigation.bodies import LONG
from tests.hub.modules.navigation.drives import Drive
from tests.hub.modules.timed_bus import TimedBus
from tests.support.bodies import robot_of
from tests.support.magellan import magellan_body
from tests.support.messages import drive_state

BODY = magellan_body()
BEAMS = beams_of(BODY)


class Muted(SimulatedBase):
    """A base whose range sensors stop to measure; it repeats their last scans."""

    silent: frozenset[str] = frozenset()

    def sensors(self, stamp: float) -> Sensors:
        before = {scan.header.frame_id: scan for scan in self._scans}
        sensors = super().sensors(stamp)
        self._scans = tuple(
            before[scan.header.frame_id] if scan.header.frame_id in self.silent else scan
            for scan in sensors.scans
        )
        return dataclasses.replace(sensors, scans=self._scans)


def drive(x: float = 5.2, y: float = 0.9) -> tuple[Drive, Muted]:
    """A Magellan that looks north in the yellow arena."""
    start = Pose(x=x, y=y, theta=math.pi / 2.0)
    made = Drive(load_arena("yellow"), start)
    made.robot = muted = Muted(dataclasses.replace(load_arena("yellow"), start=start), BODY)
    return made, muted


def scans(*names: str, stamp: float, value: float = 2.0) -> RangeReadings:
    return RangeReadings(
        scans=tuple(
            scan_of(group, np.full(group.beams, value, np.float32), stamp)
            for group in BODY.ranges
            if group.name in names
        )
    )


def test_a_group_is_silent_after_five_periods_and_until_it_measures() -> None:
    watch = RangeWatch(BODY.ranges, BEAMS)
    watch.look(0.0)
    for number in range(1, 10):
        watch.heard(scans("sonar", "infrared", stamp=number), 0.1 * number)
        watch.look(0.1 * number)
        assert not watch.silent
    both = scans("sonar", "infrared", stamp=9.0)
    new = RangeReadings(scans=(both.scans[0], *scans("infrared", stamp=10.0).scans))
    watch.heard(new, 1.0)
    watch.look(0.9 + LEAST_S - 0.01)
    assert not watch.silent
    watch.look(0.9 + LEAST_S + 0.01)
    assert watch.silent == {"sonar": pytest.approx(LEAST_S + 0.01)}
    assert watch.beams[BEAMS.groups["sonar"]].all()
    assert not watch.beams[BEAMS.groups["infrared"]].any()
    assert not watch.blind
    watch.look(3.0)
    assert watch.blind
    watch.heard(scans("sonar", stamp=11.0), 3.0)
    watch.look(3.0)
    assert not watch.blind
    assert watch.silent.keys() == {"infrared"}


def test_slow_sensors_have_more_time_and_scans_without_a_number_do_not_count() -> None:
    slow = tuple(dataclasses.replace(group, rate_hz=1.0) for group in BODY.ranges)
    watch = RangeWatch(slow, BEAMS)
    for tenths in range(10 * PERIODS):
        watch.heard(scans("sonar", stamp=1.0 + tenths, value=math.nan), 0.1 * tenths)
        watch.look(0.1 * tenths)
        assert not watch.silent
    watch.look(float(PERIODS))
    assert watch.silent.keys() == {"sonar", "infrared"}
    never = tuple(dataclasses.replace(group, rate_hz=0.0) for group in BODY.ranges)
    watch = RangeWatch(never, BEAMS)
    watch.look(0.0)
    watch.look(1e6)
    assert not watch.silent


def test_a_body_without_range_sensors_is_not_blind() -> None:
    body = robot_of("blimp").body
    watch = RangeWatch(body.ranges, beams_of(body))
    watch.look(0.0)
    watch.look(9.0)
    assert not watch.blind


def test_with_a_silent_sensor_it_drives_slowly_until_the_sensor_measures() -> None:
    it, muted = drive()
    it.push(0.5, 0.0, 1.0)
    assert it.truth.linear > 0.4
    muted.silent = frozenset({"sonar"})
    it.push(0.5, 0.0, 1.0)
    assert it.truth.linear == pytest.approx(CAREFUL_SPEED, abs=0.01)
    (problem,) = problems(it.pilot, it.now)
    assert (problem.name, problem.level) == ("range sonar", Severity.WARN)
    assert "is silent" in problem.message
    muted.silent = frozenset()
    it.push(0.5, 0.0, 1.0)
    assert it.truth.linear > 0.4
    assert not problems(it.pilot, it.now)


def test_blind_it_says_so_drives_slowly_and_without_assistance_as_commanded() -> None:
    it, muted = drive()
    it.push(0.5, 0.0, 0.5)
    muted.silent = frozenset({"sonar", "infrared"})
    it.push(0.5, 0.0, 1.0)
    assert it.truth.linear == pytest.approx(CAREFUL_SPEED, abs=0.01)
    assert {(each.name, each.level) for each in problems(it.pilot, it.now)} == {
        ("range sonar", Severity.ERROR),
        ("range infrared", Severity.ERROR),
    }
    it.pilot.assist(Assistance.OFF, it.now)
    it.push(0.5, 0.0, 0.5)
    assert it.truth.linear > 0.4


def test_blind_it_goes_to_no_goal_and_goes_on_when_it_sees_again() -> None:
    it, muted = drive()
    it.push(0.1, 0.0, 0.3)
    it.pilot.go(GoalCommand(points=(Point(x=1.5, y=0.0),)), 1, it.now)
    muted.silent = frozenset({"sonar", "infrared"})
    it.carry_out(3.0)
    assert it.pilot.task.active
    y = it.truth.y
    it.carry_out(2.0)
    assert it.truth.y == y
    muted.silent = frozenset()
    it.carry_out(1.5)
    assert it.truth.y > y + 0.1
    muted.silent = frozenset({"sonar", "infrared"})
    it.carry_out(LONGEST_HOLD_S + 2.0)
    task = it.pilot.task
    assert (task.state, task.cause) == (Task.CANCELLED, Cause.BLIND)


def test_old_ranges_of_a_silent_sensor_neither_clear_nor_assume_points() -> None:
    beams = beams_of(LONG)
    silent = np.zeros(len(beams.kind), np.bool_)
    memory = ObstacleMemory(LONG, BeamRules(LONG, beams), 1.8, silent)
    laser, mast = beams.groups["laser"], beams.groups["mast"]

    def see(laser_m: float, mast_m: float, now: float, fresh: slice) -> None:
        ranges = np.full(len(beams.kind), np.nan)
        ranges[laser], ranges[mast] = laser_m, mast_m
        is_fresh = np.zeros(len(ranges), np.bool_)
        is_fresh[fresh] = True
        memory.moved(drive_state(x=0.02 * now), now)
        memory.scanned(BeamScan(pose=Pose(x=0.02 * now), ranges=ranges, fresh=is_fresh), now)

    def count() -> int:
        return len(memory.points(0.0, 0.0, 0.0, 3.0)[0])

    see(1.2, math.nan, 0.0, laser)
    met = count()
    assert met > 50
    # The mast looks through a point 1.2 m ahead, but it fell silent.
    silent[mast] = True
    for step in range(1, 8):
        see(math.nan, math.inf, float(step), mast)
    assert count() == met
    # Its last range was "too near to measure".
    see(math.nan, 0.01, 8.0, mast)
    assert count() == met
    silent[mast] = False
    see(math.nan, 0.01, 9.0, mast)
    assert count() > met


def test_navigation_says_it_although_no_ranges_come(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    bus = TimedBus(monkeypatch)
    Navigation(bus, robot_of("magellan"))  # type: ignore[arg-type]
    began = bus.now
    for _ in range(40):
        bus.send(DRIVE_STATE, DriveState(reckoning=11), "driver")
        bus.wait(0.02)
    said = [
        (at, {each.name for each in value.status})
        for at, name, value in bus.published
        if name == DIAGNOSTICS.name
    ]
    names = {"range sonar", "range infrared"}
    first = next(at for at, each in said if each == names)
    assert LEAST_S <= first - began <= LEAST_S + 0.25
