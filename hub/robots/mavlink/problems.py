"""What is wrong with a vehicle, for the operator; pure.

| problem | severity | when |
| --- | --- | --- |
| autopilot | ERROR | it is silent, or another process of this machine has it |
| vehicle | ERROR | it is not of the kind that the robot file is for |
| autopilot | WARN | it is in a mode of another, or its link or its rules are in doubt |
| twins | ERROR | two vehicles answer with its number |
| stations | ERROR; WARN if it only is connected | another ground station is on its link |
| link | WARN | datagrams of another sender are dropped |
| failsafe | ERROR | one of its failsafes acts while it is armed |
| stops | ERROR; WARN while it is disarmed | it never stops by itself after the link is cut |
| left alone | WARN | it has no mode for what the robot file wants |
| leak, battery, estimator, vehicle | as the vehicle says | its own words, for a short time |
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.link.byte_link import ByteLinkState
from hub.robots.mavlink.vehicle.reasons import warnings, why
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle

_SILENT: Final = (AutopilotPhase.LINKING, AutopilotPhase.GONE)
_SHOWN_S: Final = 30.0
"""How long its own words count; a leak is repeated every 20 s [s]."""
_REASON_S: Final = 10.0
"""Age of words that give the reason of a failsafe [s]."""
_NAMES: Final = {"leak": "leak", "batt": "battery", "ekf": "estimator"}
"""Names of problems, by letters in the vehicle's words."""
_ARMING: Final = ("PreArm", "Arm:")
"""Words that say why it cannot be armed: the state of the autopilot has them."""


def vehicle_problems(
    vehicle: MavlinkVehicle,
    link: ByteLinkState,
    now: float,
    *,
    rival: str,
    other_kind: str,
    stops_after_cut: float,
    left_alone: LeftAlone,
) -> Iterator[DiagnosticStatus]:
    """All present problems.

    Args:
        vehicle: The vehicle.
        link: Its link.
        now: Monotonic time [s].
        rival: The process of this machine that has claimed it; empty: none.
        other_kind: That the robot file is for another kind, in words; empty: it is not.
        stops_after_cut: Time until it stands after the link is cut [s]; infinite: never.
        left_alone: What the robot file wants without an operator.
    """
    if rival:
        text = rival_words(rival)
        yield DiagnosticStatus(level=Severity.ERROR, name="autopilot", message=text)
        return
    if vehicle.phase in _SILENT:
        text = f"the autopilot is silent: {why(vehicle, now)}"
        text += f"; its link: {link.why}" if link.why and not link.up else ""
        yield DiagnosticStatus(level=Severity.ERROR, name="autopilot", message=text)
        return
    if other_kind:
        yield DiagnosticStatus(level=Severity.ERROR, name="vehicle", message=other_kind)
    if vehicle.phase is AutopilotPhase.ELSEWHERE:
        yield _warning("autopilot", why(vehicle, now))
    yield from _of_link(vehicle, link, now)
    for text in warnings(vehicle, now):
        yield _warning("autopilot", text)
    if vehicle.failsafe and vehicle.armed:
        words = [each.text for each in vehicle.texts.since(now - _REASON_S) if each.level.value]
        text = "; ".join(["a failsafe of the vehicle acts", *words[-2:]])
        yield DiagnosticStatus(level=Severity.ERROR, name="failsafe", message=text)
    if stops_after_cut == math.inf:
        level = Severity.ERROR if vehicle.armed else Severity.WARN
        text = "it never stops by itself after the link is cut: see its unsafe parameters"
        yield DiagnosticStatus(level=level, name="stops", message=text)
    profile = vehicle.profile
    if profile is not None and left_alone not in profile.alone:
        text = f"[safety] left_alone is {left_alone.value!r}, which a {profile.name} cannot"
        yield _warning("left alone", text)
    yield from _own_words(vehicle, now)


def _of_link(
    vehicle: MavlinkVehicle, link: ByteLinkState, now: float
) -> Iterator[DiagnosticStatus]:
    """Who else is on its link."""
    if vehicle.twin:
        yield DiagnosticStatus(level=Severity.ERROR, name="twins", message=why(vehicle, now))
    for level, text in vehicle.stations.problems(now):
        yield DiagnosticStatus(level=level, name="stations", message=text)
    if link.unheard:
        text = f"datagrams of {link.unheard} are dropped: another vehicle sent to this port first"
        yield _warning("link", text)


def other_kind_words(wanted: str, vehicle: MavlinkVehicle) -> str:
    """That a robot file is for another kind of vehicle; empty: it is for this one, or for any."""
    found = vehicle.profile.name if vehicle.profile is not None else ""
    if not wanted or found in ("", wanted):
        return ""
    return f"a {found} answers, and the robot file is for a {wanted}: adopt this vehicle anew"


def rival_words(rival: str) -> str:
    """What to do about another process that has the vehicle; empty: there is none."""
    return f"{rival} has this vehicle, so nothing is sent here: end one of the two" if rival else ""


def _own_words(vehicle: MavlinkVehicle, now: float) -> Iterator[DiagnosticStatus]:
    """The newest bad text about each thing."""
    newest: dict[str, DiagnosticStatus] = {}
    for each in vehicle.texts.since(now - _SHOWN_S):
        if each.level is Severity.OK or each.text.startswith(_ARMING):
            continue
        known = [name for letters, name in _NAMES.items() if letters in each.text.lower()]
        if not known and each.level is not Severity.ERROR:
            continue
        name = known[0] if known else "vehicle"
        text = f"the vehicle says: {each.text}"
        newest[name] = DiagnosticStatus(level=each.level, name=name, message=text)
    yield from newest.values()


def _warning(name: str, text: str) -> DiagnosticStatus:
    return DiagnosticStatus(level=Severity.WARN, name=name, message=text)
