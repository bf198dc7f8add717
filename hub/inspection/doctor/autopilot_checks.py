"""The doctor on the vehicle of a robot file with an autopilot."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator

from hub.errors import HubError, VehicleSilentError
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.inspection.vehicle.vehicle_link import hub_with_autopilot, open_session, place_in
from hub.robots.description import RobotDescription
from hub.robots.mavlink import adopting
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.search import find_vehicle
from hub.robots.mavlink.profiles.stop_times import stop_times

_LISTENING_S = 3.0


def autopilot(robot: RobotDescription) -> list[Finding]:
    """Whether the vehicle is there, and which of its parameters are unsafe."""
    if robot.kind != "mavlink":
        return [ok("not needed: the robot has none")]
    place = place_in(robot)
    if hub := hub_with_autopilot(place):
        text = f"its hub runs at {hub} and has the link, so the vehicle was not asked"
        return [ok(f"{text}; `rune-hub echo GCM_Autopilot_State` shows unsafe parameters")]
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
    findings = [ok(f"{place.address}: system {system}, a {adopting.title(finder)}")]
    findings += [
        warning(
            f"unsafe: {adopting.unsafe_words(each)}",
            f"rune-hub vehicle parameters {robot.path} --write {each.name}={each.wanted:g}",
        )
        for each in adopting.unsafe(finder, place.station)
    ]
    return [*findings, *_stopping(finder, robot)]


def _stopping(finder: VehicleFinder, robot: RobotDescription) -> Iterator[Finding]:
    """How long the vehicle moves on with its parameters, at the limits of the robot file."""
    if finder.profile is None:
        return
    receiver = bool(finder.receiver)
    zero, cut = stop_times(finder.profile, finder.parameters, robot, receiver=receiver)
    having = f"{'with' if receiver else 'without'} a radio receiver"
    if cut == math.inf:
        remedy = f"rune-hub vehicle parameters {robot.path} --write-safe"
        yield problem(f"{having} it never stops after the link is cut", remedy)
    elif not math.isnan(zero + cut):
        text = f"stops {zero:.1f} s after zero, {cut:.1f} s after the link is cut"
        yield ok(f"at the limits of the robot file, {having}, it {text}")
