"""Why a vehicle does not follow velocities, and what to know of it, in words; pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.vehicle.liveness import ECHO_LOST_S, SLOW_S
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle

_PREARM_S: Final = 40.0
"""Age up to which a text on arming still holds; vehicles repeat them every 30 s [s]."""
_LONGEST: Final = 900
"""Most letters of a reason."""
_LOSES: Final = 0.2
"""Share of lost echoes from which the operator is warned."""
_KEYLESS: Final = (
    "it signs its frames and ignores those without its key: name the key's file in the robot file "
    "([mavlink] key_file); by cable, `rune-hub vehicle key FILE --setup ROBOT.toml` gives it a new "
    "one"
)
_WATCHED: Final = "Rune does not drive vehicles of this type: it only watches"
_GROUND: Final = "it is on the ground, and Rune does not take off: a pilot brings it into the air"


def why(vehicle: MavlinkVehicle, now: float) -> str:
    """Why it does not follow velocities; empty: it does.

    Args:
        vehicle: The vehicle.
        now: Monotonic time [s].
    """
    reason = _reason(vehicle, now)
    return reason if len(reason) <= _LONGEST else reason[: _LONGEST - 3] + "..."


def warnings(vehicle: MavlinkVehicle, now: float) -> Iterator[str]:
    """What an operator should know of the vehicle and its link, a sentence each.

    Args:
        vehicle: The vehicle.
        now: Monotonic time [s].
    """
    yield from _link(vehicle, now)
    if vehicle.system and vehicle.identity.others:
        yield f"other vehicles are on its link{_others(vehicle)}; Rune drives {vehicle.system}"
    profile = vehicle.profile
    if profile is None:
        return
    if vehicle.better.waits:
        now_in, best = profile.mode_name(vehicle.mode), profile.mode_name(profile.drives[0])
        yield (
            f"it knows its place now, and drives in {now_in}: release all sticks and keys for 1 s, "
            f"or ask it to drive, and it changes to {best}"
        )
    if not profile.verified:
        yield f"the rules of a {profile.autopilot} {profile.name} were never compared with one"
    if vehicle.telemetry.silent:
        silent = ", ".join(sorted(vehicle.telemetry.silent))
        yield f"it sends {silent} no more, so what they say is not known: see if its link is full"
    missing = [name for name in profile.scales if name in vehicle.parameters.missing]
    if missing:
        yield f"it does not tell {', '.join(missing)}: it does not move where these are needed"


def _link(vehicle: MavlinkVehicle, now: float) -> Iterator[str]:
    """What a slow or lossy link means for driving."""
    if vehicle.liveness.delay > SLOW_S:
        yield (
            f"its answers take {vehicle.liveness.delay:.1f} s: it obeys and stops that much later, "
            f"and is not driven from {ECHO_LOST_S:g} s on"
        )
    if (lost := vehicle.liveness.lost(now)) >= _LOSES:
        yield f"{round(lost, 1):.0%} of its echoes are lost: orders may need a second try"


def _reason(vehicle: MavlinkVehicle, now: float) -> str:
    match vehicle.phase:
        case AutopilotPhase.LINKING:
            return f"no heartbeat came yet{_others(vehicle)}{_refused(vehicle)}"
        case AutopilotPhase.GONE:
            if vehicle.identity.signed and not vehicle.signs:
                return _KEYLESS
            gone = vehicle.liveness.gone(now, was=True) or "it is asked again"
            return f"{gone}{_refused(vehicle)}"
        case AutopilotPhase.LEARNING:
            return vehicle.learns_because or "its streams and parameters are asked for"
        case AutopilotPhase.ARMING:
            return "it was asked to arm"
        case AutopilotPhase.DISARMED:
            return vehicle.orders.refusal() or _disarmed(vehicle, now)
        case AutopilotPhase.ELSEWHERE:
            return _elsewhere(vehicle, now)
        case _:
            return _driving(vehicle)


def _refused(vehicle: MavlinkVehicle) -> str:
    """That frames come which are not signed with the key; empty: none do."""
    count = vehicle.heard.refused
    return f"; {count} frames had no signature of the key in [mavlink] key_file" if count else ""


def _others(vehicle: MavlinkVehicle) -> str:
    numbers = ", ".join(map(str, sorted(vehicle.identity.others)[:8]))
    return f", with the numbers {numbers}" if numbers else ""


def _disarmed(vehicle: MavlinkVehicle, now: float) -> str:
    if vehicle.profile is None:
        return _WATCHED
    if vehicle.profile.flies:
        return _GROUND
    if vehicle.telemetry.armable:
        return "it is disarmed: arm it"
    reasons = [
        each.text
        for each in vehicle.texts.since(now - _PREARM_S)
        if each.text.startswith(("PreArm", "Arm"))
    ]
    return "; ".join(["it is disarmed, and not ready to be armed", *dict.fromkeys(reasons)])


def _elsewhere(vehicle: MavlinkVehicle, now: float) -> str:
    profile, orders = vehicle.profile, vehicle.orders
    if profile is None:
        return _WATCHED
    if vehicle.grounded:
        return _GROUND
    if orders.disarming(now) and not orders.refusal():
        return "it was asked to disarm"
    if orders.follows or (orders.changing(now) and orders.number != vehicle.mode):
        return f"it is asked for the mode {profile.mode_name(orders.number)}"
    by = "asked for here" if orders.chosen_here(vehicle.mode, now) else "not asked for here"
    failsafe = "; one of its failsafes acts" if vehicle.failsafe else ""
    text = f"it is in {profile.mode_name(vehicle.mode)}, {by}{failsafe}: ask it to drive"
    refusal = orders.refusal()
    return f"{refusal}; {text}" if refusal else text


def _driving(vehicle: MavlinkVehicle) -> str:
    if vehicle.must_be_neutral:
        return "release the stick first"
    profile = vehicle.profile
    if profile is not None and vehicle.mode in profile.need_place:
        return "" if vehicle.telemetry.position else "it does not know its place"
    return ""
