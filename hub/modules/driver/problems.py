"""What is wrong with a body, from what it measures; pure.

| problem | severity | when |
| --- | --- | --- |
| those that the body reports | its own | |
| tipped | ERROR | roll or pitch beyond 60 degrees |
| disarmed | WARN | its motors are off |
| hold KIND | WARN | the hold fails |
| tether | WARN | more than 90 % of it is out, or more than two turns twist it |
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub.gcm.body import HoldKind
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.vehicle import Arming, HoldPhase, HoldState, VehicleState
from hub.robots.interfaces import Sensors

TIPPED = math.radians(60.0)
"""A body that leans further lies on its side [rad]."""
TETHER_USED = 0.9
"""Largest share of the tether that should be out."""
TETHER_TURNS = 2.0
"""Most turns that may twist the tether."""


def problems(sensors: Sensors) -> Iterator[DiagnosticStatus]:
    """All present problems."""
    yield from sensors.diagnostics
    yield from _tilt(sensors.roll, sensors.pitch)
    if sensors.vehicle.arming is Arming.DISARMED:
        text = "disarmed: the motors are off, and commands change nothing"
        yield DiagnosticStatus(level=Severity.WARN, name="disarmed", message=text)
    for hold in sensors.vehicle.holds:
        if hold.phase is HoldPhase.FAILING:
            yield _failing(hold)
    yield from _tether(sensors.vehicle)


def _tilt(roll: float, pitch: float) -> Iterator[DiagnosticStatus]:
    for name, angle in (("roll", roll), ("pitch", pitch)):
        if abs(angle) > TIPPED:
            text = f"tipped over: {name} {math.degrees(angle):.0f} deg"
            yield DiagnosticStatus(level=Severity.ERROR, name="tipped", message=text)
            return


def _failing(hold: HoldState) -> DiagnosticStatus:
    kind = hold.kind.name.lower()
    heading = hold.kind is HoldKind.HEADING
    off = f"{math.degrees(hold.error):+.0f} deg" if heading else f"{hold.error:+.1f} m"
    return DiagnosticStatus(
        level=Severity.WARN, name=f"hold {kind}", message=f"cannot hold {kind}: {off} off"
    )


def _tether(state: VehicleState) -> Iterator[DiagnosticStatus]:
    used = state.tether_paid / state.tether_length if state.tether_length > 0.0 else math.nan
    if used > TETHER_USED:
        text = f"tether nearly all out: {state.tether_paid:.0f} of {state.tether_length:.0f} m"
        yield DiagnosticStatus(level=Severity.WARN, name="tether", message=text)
    elif abs(state.tether_turns) > TETHER_TURNS:
        way = "right" if state.tether_turns > 0.0 else "left"
        text = f"tether twisted: turn {abs(state.tether_turns):.1f} times to the {way}"
        yield DiagnosticStatus(level=Severity.WARN, name="tether", message=text)
