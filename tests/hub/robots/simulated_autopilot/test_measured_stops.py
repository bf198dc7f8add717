"""What stops a simulated vehicle, and when, beside what was measured on ArduPilot's simulator.

Times count from the last message that moves it. It slows below 90 % of its speed, and rests below
0.05 m/s. Where measurements of one case differ, the least and the largest are given.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

from tests.support.mavlink_numbers import (
    ACRO,
    BLIMP_LOITER,
    BLIMP_VELOCITY,
    DEPTH_HOLD,
    GUIDED,
    HOLD,
    POSITION_HOLD,
    SUB_GUIDED,
    SUB_MANUAL,
    SURFACE,
)
from tests.support.simulated_station import NEUTRAL, World, blimp_sticks, velocity

STEP = 0.02
ROVER_AHEAD = (NEUTRAL["rover"], velocity(1.0))
ROVER_STICK = (("MANUAL_CONTROL", {"target": 1, "z": 185}),)
SUB_AHEAD = (("MANUAL_CONTROL", {"target": 1, "x": 500, "z": 500}),)
SUB_DOWN = (("MANUAL_CONTROL", {"target": 1, "z": 0}),)
SUB_SETPOINT = velocity(0.3)
BLIMP_AHEAD = (blimp_sticks(c2=2000),)
BARE = {"SIM_RC_FAIL": 1}
"""No receiver."""
PILOT_ENDS = BARE | {"FS_PILOT_INPUT": 1, "FS_PILOT_TIMEOUT": 0.5}
SAMPLED_S = {"slows": 0.1, "rests": 0.05, "changes": 0.1}
"""How well the measured times are known: the motion was sampled ten times a second [s]."""
Span = tuple[float, float] | None
"""The least and the largest time that was measured [s]; None: none was."""


def span(least: float, largest: float | None = None) -> Span:
    """What was measured."""
    return least, least if largest is None else largest


NEVER = span(math.inf)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A vehicle that drives, an event, and what was measured.

    Attributes:
        name: What happens.
        kind: The vehicle.
        mode: It drives in this mode.
        ahead: The messages that move it.
        settings: Its parameters.
        seconds: It drives for so long before [s].
        event: "zero", "silent", "disarm", "hold", or "setpoints silent".
        slows: When it slows.
        rests: When it stands.
        changes: When the mode changes or it is disarmed.
        into: The mode then; None: it is disarmed.
        axis: What is watched.
        drives_again: Whether it drives when the link is back and the stick still deflected; None:
            this was not measured.
    """

    name: str
    kind: str
    mode: int
    ahead: tuple[tuple[str, dict], ...]
    settings: dict[str, float] = field(default_factory=dict)
    seconds: float = 6.0
    event: str = "silent"
    slows: Span = None
    rests: Span = None
    changes: Span = None
    into: int | None = None
    axis: str = "ahead"
    drives_again: bool | None = None


def rover(name: str, **more: Any) -> Case:
    """A rover in GUIDED."""
    usual = {"kind": "rover", "mode": GUIDED, "ahead": ROVER_AHEAD}
    return Case(name=f"rover {name}", **(usual | more))


def stick_rover(name: str, **more: Any) -> Case:
    """A rover in ACRO."""
    return rover(f"with sticks {name}", **({"mode": ACRO, "ahead": ROVER_STICK} | more))


def sub(name: str, **more: Any) -> Case:
    """A Sub in position hold."""
    usual = {"kind": "sub", "mode": POSITION_HOLD, "ahead": SUB_AHEAD}
    return Case(name=f"sub {name}", **(usual | more))


def blimp(name: str, **more: Any) -> Case:
    """A blimp in VELOCITY."""
    usual = {"kind": "blimp", "mode": BLIMP_VELOCITY, "ahead": BLIMP_AHEAD, "seconds": 10.0}
    return Case(name=f"blimp {name}", **(usual | more))


def station_fails(timeout: float, later: float) -> dict[str, float]:
    """A rover that looks for its station."""
    return {"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": timeout, "FS_TIMEOUT": later}


CASES = (
    rover("zero", event="zero", slows=span(0.29), rests=span(1.36)),
    rover("hold", event="hold", slows=span(0.16), rests=span(1.04)),
    rover("disarm", event="disarm", slows=span(0.08), rests=span(0.90)),
    rover("silent", slows=span(3.25), rests=span(4.3), drives_again=True),
    stick_rover("3 s", settings={"RC_OVERRIDE_TIME": 3}, slows=span(3.1), rests=span(3.8)),
    stick_rover("0.5 s", settings={"RC_OVERRIDE_TIME": 0.5}, slows=span(0.6), rests=span(1.3)),
    stick_rover(
        "bare",
        settings=BARE | {"RC_OVERRIDE_TIME": 3, "FS_TIMEOUT": 1.5},
        slows=span(0.6),
        rests=span(1.3),
        changes=span(2.0),
        into=HOLD,
        drives_again=False,
    ),
    stick_rover("bare without failsafe", settings=BARE | {"FS_THR_ENABLE": 0}, rests=NEVER),
    rover("bare 1.5 s", settings=BARE, slows=span(2.2), rests=span(3.1), drives_again=False),
    rover("bare 0.1 s", settings=BARE | {"FS_TIMEOUT": 0.1}, slows=span(0.77), rests=span(1.66)),
    rover("station 5 s", settings=station_fails(5, 1.5), changes=span(6.6), into=HOLD),
    rover(
        "station 2 s",
        settings=station_fails(2, 0.5),
        rests=span(3.6),
        changes=span(2.55),
        into=HOLD,
        drives_again=False,
    ),
    rover(
        "station 1.2 s",
        settings=station_fails(1.2, 0.1),
        rests=span(2.4),
        changes=span(1.33),
        into=HOLD,
    ),
    sub("zero", event="zero", slows=span(0.2), rests=span(2.0)),
    sub("zero down", ahead=SUB_DOWN, axis="sinking", event="zero", rests=span(1.1)),
    sub("zero manual", mode=SUB_MANUAL, event="zero", slows=span(0.1), rests=span(4.0)),
    sub("bare", settings=BARE, changes=span(3.0), rests=span(6.9)),
    sub("pilot", settings=PILOT_ENDS, slows=span(0.5, 0.7), rests=span(2.5, 3.2)),
    sub(
        "pilot depth hold",
        mode=DEPTH_HOLD,
        settings=PILOT_ENDS,
        slows=span(0.5, 0.7),
        rests=span(4.4),
    ),
    sub(
        "without failsafes",
        mode=DEPTH_HOLD,
        settings=BARE | {"FS_PILOT_INPUT": 0, "FS_GCS_ENABLE": 0},
        rests=NEVER,
    ),
    sub(
        "station surfaces",
        settings={"FS_GCS_ENABLE": 4, "FS_GCS_TIMEOUT": 2},
        changes=span(2.17),
        into=SURFACE,
        drives_again=True,
    ),
    sub("station disarms", settings={"FS_GCS_ENABLE": 2}, changes=span(5.2, 5.8)),
    sub(
        "setpoints silent",
        mode=SUB_GUIDED,
        ahead=(SUB_SETPOINT, NEUTRAL["sub"]),
        settings=BARE,
        event="setpoints silent",
        slows=span(3.1),
    ),
    blimp("zero", event="zero", slows=span(0.28), rests=span(1.5, 3.2)),
    blimp(
        "zero loiter", mode=BLIMP_LOITER, event="zero", slows=span(0.65, 0.8), rests=span(1.8, 2.2)
    ),
    blimp("silent 3 s", settings={"RC_OVERRIDE_TIME": 3}, slows=span(3.3), rests=span(4.5, 5.1)),
    blimp(
        "silent 0.5 s",
        settings={"RC_OVERRIDE_TIME": 0.5},
        slows=span(0.68),
        rests=span(2.0, 2.6),
        drives_again=True,
    ),
    blimp(
        "bare 3 s",
        settings=BARE | {"RC_OVERRIDE_TIME": 3},
        changes=span(1.05),
        rests=NEVER,
        drives_again=False,
    ),
    blimp("bare 0.5 s", settings=BARE | {"RC_OVERRIDE_TIME": 0.5}, changes=span(0.51), rests=NEVER),
    blimp("bare without failsafe", settings=BARE | {"FS_THR_ENABLE": 0}, rests=NEVER),
    blimp(
        "station",
        settings={"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 2, "RC_OVERRIDE_TIME": 3},
        changes=span(2.04),
    ),
)


class Drive:
    """A vehicle that drives."""

    def __init__(self, case: Case) -> None:
        settings, kind = case.settings, case.kind
        self.world = World(kind, settings=settings, depth=9.0 if kind == "sub" else 0.0)
        self.station = self.world.station()
        self.station.stream(NEUTRAL[kind])
        self.world.wait(2.0)
        assert self.station.mode(case.mode) == 0
        assert self.station.arm() == 0
        self.station.stream(*case.ahead)
        self.world.wait(case.seconds)
        self.motion, self.vehicle = self.world.motion.state, self.world.autopilot.vehicle
        self.axis = case.axis
        self.top = self.speed
        assert self.top > 0.1
        self.began = self.world.now

    @property
    def speed(self) -> float:
        return abs(getattr(self.motion, self.axis))

    def happens(self, case: Case) -> None:
        """The event."""
        station, kind = self.station, case.kind
        match case.event:
            case "zero" if case.mode == GUIDED and kind == "rover":
                station.stream(NEUTRAL[kind], velocity())
            case "zero":
                station.stream(NEUTRAL[kind])
            case "hold":
                assert station.mode(HOLD) == 0
            case "disarm":
                assert station.command(400, 0) == 0
            case "setpoints silent":
                self.began = station.repeated_at
                station.stream(NEUTRAL[kind])
            case _:
                self.began = station.repeated_at
                station.alive = False
                station.stream()

    def watched(self, case: Case, most: float = 13.0) -> dict[str, float]:
        """When what happened after the event [s]; inf: not in this time [s]."""
        found = dict.fromkeys(("slows", "rests", "changes"), math.inf)
        while self.world.now - self.began < most:
            self.world.wait(STEP)
            took, vehicle = self.world.now - self.began, self.vehicle
            there = vehicle.mode == case.into if case.into is not None else not vehicle.armed
            for name, seen in (
                ("slows", self.speed < 0.9 * self.top),
                ("rests", self.speed < 0.05),
                ("changes", there),
            ):
                if seen:
                    found[name] = min(found[name], took)
        return found

    def comes_back(self, case: Case) -> bool:
        """Whether it drives when the link is back, and the stick still deflected."""
        self.station.alive = True
        self.station.stream(*case.ahead)
        self.world.wait(3.0)
        return self.speed > 0.6 * self.top


def off(name: str, measured: Span, simulated: float) -> bool:
    """Whether it differs by more than a tenth, and by more than the samples are apart."""
    if measured is None:
        return False
    least, largest = measured
    if math.isinf(least):
        return simulated < math.inf
    apart = SAMPLED_S[name]
    return not min(0.9 * least, least - apart) <= simulated <= max(1.1 * largest, largest + apart)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_it_stops_when_such_vehicles_stopped(case):
    drive = Drive(case)
    drive.happens(case)
    found = drive.watched(case)
    wrong = {
        name: f"{getattr(case, name)} measured, {when:.2f} s simulated"
        for name, when in found.items()
        if off(name, getattr(case, name), when)
    }
    assert not wrong
    if case.drives_again is not None:
        assert drive.comes_back(case) is case.drives_again


def test_the_words_of_failsafes_are_the_measured_ones():
    silent = rover("station", settings=station_fails(2, 0.5))
    for case, text in (
        (silent, "Radio Failsafe"),  # those of another failsafe: its receiver is sound
        (sub("pilot", settings=PILOT_ENDS), "Lost manual control"),
        (blimp("bare", settings=BARE), "Radio Failsafe - Disarming"),
    ):
        drive = Drive(case)
        drive.happens(case)
        drive.watched(case, 3.0)
        assert text in drive.station.texts()


def test_a_sub_that_surfaced_holds_its_depth_armed():
    case = sub("surfaces", settings={"FS_GCS_ENABLE": 4, "FS_GCS_TIMEOUT": 2})
    drive = Drive(case)
    drive.happens(case)
    assert drive.watched(case)["changes"] == math.inf  # it is not disarmed
    assert drive.vehicle.mode == DEPTH_HOLD


def test_a_sub_in_guided_is_disarmed_without_sticks():
    case = sub("guided", mode=SUB_GUIDED, ahead=(SUB_SETPOINT,), seconds=2.5, settings=BARE)
    drive = Drive(case)
    assert drive.watched(case, 0.8)["changes"] < 0.6


def test_a_disarmed_blimp_drifts_as_far_as_measured():
    case = blimp("bare", settings=BARE | {"RC_OVERRIDE_TIME": 0.5})
    drive = Drive(case)
    drive.happens(case)
    north = drive.motion.north
    drive.watched(case, 12.0)
    assert 1.6 < drive.motion.north - north < 2.4


def test_a_blimp_ignores_manual_control_but_counts_it_as_life():
    case = blimp("life", settings={"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 2})
    drive = Drive(case)
    drive.station.alive = False
    drive.station.stream(("MANUAL_CONTROL", {"target": 1, "x": 1000}))
    drive.world.wait(8.0)
    assert abs(drive.motion.ahead) < 0.05
    assert drive.vehicle.armed
