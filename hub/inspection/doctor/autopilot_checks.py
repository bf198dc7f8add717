"""The doctor on the vehicle of a robot file with an autopilot."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator

from hub.errors import HubError, VehicleSilentError
from hub.gcm.autopilot import AutopilotPhase, UnsafeParameter
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.inspection.vehicle.vehicle_link import (
    autopilot_at,
    hub_with_autopilot,
    open_session,
    place_in,
)
from hub.robots.description import RobotDescription
from hub.robots.mavlink import adopting
from hub.robots.mavlink.asking.search import find_vehicle
from hub.robots.mavlink.asking.silence import unanswered
from hub.robots.mavlink.profiles.stop_times import stop_times

_LISTENING_S = 3.0


def autopilot(robot: RobotDescription) -> list[Finding]:
    """Whether the vehicle is there, and which of its parameters are unsafe."""
    if robot.kind != "mavlink":
        return [ok("not needed: the robot has none")]
    place = place_in(robot)
    if hub := hub_with_autopilot(place):
        return [*_reported(hub, robot)]
    try:
        session = open_session(place.address, place.key_file, place.station)
    except HubError as fault:
        return [problem(str(fault), "correct [mavlink] in the robot file")]
    with contextlib.closing(session):
        try:
            finder = find_vehicle(session, place.system, _LISTENING_S)
        except VehicleSilentError as fault:
            return [problem(str(fault), "connect the vehicle, or correct [mavlink]")]
    system = finder.vehicle.system if finder.vehicle is not None else place.system
    found = f"{place.address}: system {system}, a {adopting.title(finder)}"
    if not finder.answers and finder.vehicle is not None:
        words = unanswered(signed=finder.vehicle.signed, signs=session.signs)
        advice = "nothing of how it stops is known: see its link and its key"
        return [problem(f"{found}; {words}", advice)]
    findings = [ok(found)]
    kind = finder.profile.name if finder.profile is not None else ""
    findings += _other_kind(kind, robot)
    findings += _unsafe(adopting.unsafe(finder, place.station), robot)
    if finder.profile is not None:
        receiver = finder.receiver
        times = stop_times(finder.profile, finder.parameters, robot, receiver=receiver)
        having = ", whether it has a radio receiver or not,"
        if receiver is not None:
            having = f", {'with' if receiver else 'without'} a radio receiver,"
        findings += _stopping(*times, robot, having)
    return findings


def _reported(hub: str, robot: RobotDescription) -> Iterator[Finding]:
    """What a running hub, which has the link, reports of the vehicle."""
    state, text = autopilot_at(hub), f"its hub runs at {hub} and has the link"
    if state is None or not state.vehicle:
        yield warning(f"{text}, and knows no vehicle yet", "connect the vehicle, and try again")
        return
    text = f"{text} to a {state.vehicle} with {state.firmware}: {state.phase.name}"
    if state.phase in (AutopilotPhase.LINKING, AutopilotPhase.GONE):
        yield problem(f"{text}: {state.why}", "see the link to the vehicle")
    else:
        yield ok(text)
    yield from _other_kind(state.vehicle, robot)
    yield from _unsafe(state.unsafe, robot)
    yield from _stopping(state.stops_after_zero_s, state.stops_after_cut_s, robot, "")


def _other_kind(kind: str, robot: RobotDescription) -> Iterator[Finding]:
    """Whether the vehicle is of the kind that the robot file is for."""
    if kind and robot.vehicle_kind not in ("", kind):
        text = f"a {kind} answers, and the robot file is for a {robot.vehicle_kind}"
        yield problem(text, "adopt this vehicle anew, or correct [mavlink], key 'vehicle'")


def _unsafe(parameters: Iterable[UnsafeParameter], robot: RobotDescription) -> Iterator[Finding]:
    for each in parameters:
        words = adopting.unsafe_words(each)
        command = f"rune-hub vehicle parameters {robot.path}"
        if math.isnan(each.value):
            yield problem(words, f"{command} {each.name}")
        else:
            yield warning(words, f"{command} --write {each.name}={each.wanted:g}")


def _stopping(zero: float, cut: float, robot: RobotDescription, having: str) -> Iterator[Finding]:
    """How long the vehicle moves on with its parameters, at the limits of the robot file.

    Args:
        zero: Time until it stands after zero speed [s].
        cut: The same after the link is cut [s].
        robot: The robot file.
        having: What it has, between commas; empty: it is not said.
    """
    if cut == math.inf:
        remedy = f"rune-hub vehicle parameters {robot.path} --write-safe"
        yield problem(
            f"at the limits of the robot file{having} it never stops after the link is cut", remedy
        )
    elif math.isnan(zero + cut):
        text = f"at the limits of the robot file{having} its times to stop are not known"
        yield warning(text, "take care: see the parameters that were not read, or try it slowly")
    else:
        text = f"stops {zero:.1f} s after zero, {cut:.1f} s after the link is cut"
        yield ok(f"at the limits of the robot file{having} it {text}")
