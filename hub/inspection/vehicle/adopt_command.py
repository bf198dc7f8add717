"""`rune-hub adopt mavlink`: writes the robot file of a vehicle.

The exit code is 1 where the file was written, and a parameter that decides was not read.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import time
from collections.abc import Iterator

from hub.command_line import ExitCode
from hub.command_output import put_json
from hub.inspection.robot_file_output import RobotFileOutput
from hub.inspection.vehicle.vehicle_link import open_session
from hub.plain_text import plain
from hub.robots.mavlink import adopting
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.search import find_vehicle


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        VehicleAddressError: The address is none.
        VehicleSilentError: There is no vehicle, or there are several.
        KeyFileError: The key cannot be used.
    """
    output = RobotFileOutput(options.output, replace=options.force)
    if not output.is_free():
        return 1
    key_file = str(options.key.absolute()) if options.key is not None else ""
    with contextlib.closing(open_session(options.address, key_file, options.station)) as session:
        finder = find_vehicle(session, options.system, options.seconds, extra=adopting.EXTRA)
    today = time.strftime("%Y-%m-%d")
    address = options.address.strip()
    text = adopting.robot_file(
        finder,
        address,
        name=options.name or "",
        key_file=key_file,
        station=options.station,
        today=today,
    )
    if not output.write(text):
        return 1
    remarks = [*adopting.remarks(finder, station=options.station, signs=options.key is not None)]
    if options.json:
        put_json(_facts(finder, options, remarks))
    else:
        output.report(text, *_lines(finder, options, remarks))
    return ExitCode.FAULT if _is_unread(finder, options) else ExitCode.OK


def _is_unread(finder: VehicleFinder, options: argparse.Namespace) -> bool:
    """Whether something that decides how it stops is not known."""
    decisive = adopting.unsafe(finder, options.station)
    return not finder.answers or any(math.isnan(each.value) for each in decisive)


def _lines(finder: VehicleFinder, options: argparse.Namespace, remarks: list[str]) -> Iterator[str]:
    """What was found, line by line."""
    system = finder.vehicle.system if finder.vehicle is not None else 0
    yield plain(f"{options.address}: system {system}, a {adopting.title(finder)}")
    for each in finder.streams.values():
        yield f"video {each.name!r} of component {each.component} at {each.address}"
    yield from remarks
    if any(not math.isnan(each.value) for each in adopting.unsafe(finder, options.station)):
        where = options.output or options.address
        yield f"`rune-hub vehicle parameters {where} --write-safe` sets the safe values"


def _facts(
    finder: VehicleFinder, options: argparse.Namespace, remarks: list[str]
) -> dict[str, object]:
    vehicle = finder.vehicle
    return {
        "path": str(options.output) if options.output is not None else None,
        "name": options.name or adopting.usual_name(finder),
        "address": options.address,
        "system": vehicle.system if vehicle is not None else 0,
        "vehicle": finder.profile.name if finder.profile is not None else "",
        "title": adopting.title(finder),
        "armed": vehicle is not None and vehicle.armed,
        "parameters": finder.parameters,
        "unsafe": [
            {"name": each.name, "value": each.value, "wanted": each.wanted, "why": each.why}
            for each in adopting.unsafe(finder, options.station)
        ],
        "streams": [each.address for each in finder.streams.values()],
        "remarks": remarks,
    }
