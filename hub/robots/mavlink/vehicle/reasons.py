"""Why a vehicle does not follow velocities, in words; pure."""

from __future__ import annotations

from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle

_PREARM_S: Final = 40.0
"""Age up to which a text on arming still holds; vehicles repeat them every 30 s [s]."""
_WATCHED: Final = "Rune does not drive vehicles of this type: it only watches"


def why(vehicle: MavlinkVehicle, now: float) -> str:
    """Why it does not follow velocities; empty: it does.

    Args:
        vehicle: The vehicle.
        now: Monotonic time [s].
    """
    match vehicle.phase:
        case AutopilotPhase.LINKING:
            other = f"; vehicles heard: {sorted(vehicle.others)}" if vehicle.others else ""
            return f"no heartbeat came yet{other}"
        case AutopilotPhase.GONE:
            return vehicle.liveness.gone(now) or "it is asked again"
        case AutopilotPhase.LEARNING:
            return vehicle.learns_because or "its streams and parameters are asked for"
        case AutopilotPhase.ARMING:
            return "it was asked to arm"
        case AutopilotPhase.DISARMED:
            return vehicle.orders.refusal() or _disarmed(vehicle, now)
        case AutopilotPhase.ELSEWHERE:
            return _elsewhere(vehicle, now)
        case _:
            return "release the stick first" if vehicle.must_be_neutral else ""


def _disarmed(vehicle: MavlinkVehicle, now: float) -> str:
    if vehicle.profile is None:
        return _WATCHED
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
    if orders.follows:
        return f"it is asked for the mode {profile.mode_name(orders.number)}"
    by = "asked for here" if orders.chosen_here(vehicle.mode, now) else "not asked for here"
    failsafe = "; one of its failsafes acts" if vehicle.failsafe else ""
    text = f"it is in {profile.mode_name(vehicle.mode)}, {by}{failsafe}: ask it to drive"
    refusal = orders.refusal()
    return f"{refusal}; {text}" if refusal else text
