"""`rune-hub vehicle mission`: the mission items, the geofence and the rally points of a vehicle."""

from __future__ import annotations

import argparse
import contextlib
import math
from typing import Final

from hub.command_line import ExitCode
from hub.command_output import print_error, put, put_json
from hub.inspection.output import table
from hub.inspection.vehicle.vehicle_link import find_at, open_session, place_of
from hub.robots.mavlink.asking.mission import MissionItem, MissionReading

_LONGEST_S: Final = 120.0
_NO_PLACE: Final = 2
"""MAV_FRAME_MISSION."""


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: The robot file or the address cannot be used, or there is no vehicle.
    """
    place = place_of(options)
    with contextlib.closing(open_session(place.address, place.key_file, place.station)) as session:
        finder = find_at(session, place, options.seconds)
        reading = MissionReading(finder.vehicle.system if finder.vehicle is not None else 0)
        ended = session.ask(reading, _LONGEST_S)
    if options.json:
        for each in reading.items:
            put_json(_facts(each))
    elif reading.items:
        heads = ("list", "number", "command", "place", "height", "parameters")
        table(heads, [_row(each) for each in reading.items], words=6)
    elif ended and not reading.missing:
        put("the vehicle has no mission, no geofence and no rally points")
    for kind, why in reading.missing.items():
        print_error(f"{kind.name.lower()}: {why}")
    if not ended:
        print_error(f"not all came within {_LONGEST_S:g} s")
    return ExitCode.FAULT if reading.missing or not ended else ExitCode.OK


def _row(each: MissionItem) -> tuple[str, str, str, str, str, str]:
    number = f"{each.number}{' now' if each.current else ''}"
    if each.frame == _NO_PLACE:
        where = ""
    elif math.isnan(each.latitude):
        where = f"{each.x:g} m, {each.y:g} m"
    else:
        where = f"{each.latitude:.7f}, {each.longitude:.7f}"
    own = " ".join("-" if math.isnan(value) else f"{value:g}" for value in each.parameters)
    return each.kind.name.lower(), number, each.name, where, f"{each.z:g} m", own


def _facts(each: MissionItem) -> dict[str, object]:
    return {
        "list": each.kind.name.lower(),
        "number": each.number,
        "command": each.command,
        "name": each.name,
        "frame": each.frame,
        "parameters": [_finite(value) for value in each.parameters],
        "latitude": _finite(each.latitude),
        "longitude": _finite(each.longitude),
        "x": _finite(each.x),
        "y": _finite(each.y),
        "z": _finite(each.z),
        "current": each.current,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
