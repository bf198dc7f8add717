"""What the driver finds wrong with a body."""

from __future__ import annotations

import math

import pytest

from hub.gcm.body import HoldKind
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.vehicle import Arming, HoldPhase, HoldState, VehicleState
from hub.modules.driver.problems import problems
from hub.robots.interfaces import Sensors

FAILING = HoldPhase.FAILING


def found(**measured: object) -> list[tuple[str, Severity, str]]:
    sensors = Sensors(**measured)  # type: ignore[arg-type]
    return [(each.name, each.level, each.message) for each in problems(sensors)]


def test_a_body_that_measures_nothing_has_no_problems() -> None:
    assert found() == []
    assert found(roll=0.9, pitch=-0.9) == []


def test_problems_of_the_body_are_passed_on() -> None:
    leak = DiagnosticStatus(level=Severity.ERROR, name="leak", message="water in the hull")
    assert found(diagnostics=(leak,)) == [("leak", Severity.ERROR, "water in the hull")]


@pytest.mark.parametrize(
    ("measured", "text"),
    [
        ({"roll": math.radians(87.0), "pitch": 0.1}, "tipped over: roll 87 deg"),
        ({"roll": 0.0, "pitch": math.radians(-65.0)}, "tipped over: pitch -65 deg"),
        ({"roll": math.nan, "pitch": math.radians(65.0)}, "tipped over: pitch 65 deg"),
    ],
)
def test_a_body_on_its_side_is_tipped(measured: dict[str, float], text: str) -> None:
    assert found(**measured) == [("tipped", Severity.ERROR, text)]


def test_motors_that_are_off_are_said() -> None:
    text = "disarmed: the motors are off, and commands change nothing"
    disarmed = [("disarmed", Severity.WARN, text)]
    for arming, said in ((Arming.NONE, []), (Arming.ARMED, []), (Arming.DISARMED, disarmed)):
        assert found(vehicle=VehicleState(arming=arming)) == said


def test_a_hold_that_fails_is_said_with_its_error() -> None:
    holds = (
        HoldState(kind=HoldKind.DEPTH, phase=FAILING, target=1.0, error=0.45),
        HoldState(kind=HoldKind.HEADING, phase=FAILING, target=1.0, error=-0.5),
        HoldState(kind=HoldKind.HEIGHT, phase=HoldPhase.HOLDING, target=1.0, error=0.1),
    )
    assert found(vehicle=VehicleState(holds=holds)) == [
        ("hold depth", Severity.WARN, "cannot hold depth: +0.5 m off"),
        ("hold heading", Severity.WARN, "cannot hold heading: -29 deg off"),
    ]


@pytest.mark.parametrize(
    ("paid", "turns", "text"),
    [
        (20.0, 0.5, ""),
        (24.0, 0.5, "tether nearly all out: 24 of 25 m"),
        (5.0, 2.5, "tether twisted: turn 2.5 times to the right"),
        (5.0, -2.5, "tether twisted: turn 2.5 times to the left"),
    ],
)
def test_a_tether_that_is_out_or_twisted_is_said(paid: float, turns: float, text: str) -> None:
    state = VehicleState(tether_paid=paid, tether_length=25.0, tether_turns=turns)
    assert found(vehicle=state) == ([("tether", Severity.WARN, text)] if text else [])
