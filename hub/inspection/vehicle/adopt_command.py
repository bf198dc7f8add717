"""`rune-hub adopt mavlink`: writes the robot file of a vehicle."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from pathlib import Path

from hub import files
from hub.inspection.output import print_error, put
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
    output: Path | None = options.output
    if output is not None and output.exists() and not options.force:
        print_error(f"{output} is there; give another name, or --force to replace it")
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
    if output is not None:
        try:
            files.replace(output, text.encode())
        except OSError as fault:
            print_error(f"{output} cannot be written: {fault.strerror}")
            return 1
    _report(finder, options, text)
    return 0


def _report(finder: VehicleFinder, options: argparse.Namespace, text: str) -> None:
    """Say what was found."""
    remarks = [*adopting.remarks(finder, station=options.station, signs=options.key is not None)]
    if options.json:
        put(json.dumps(_facts(finder, options, remarks)))
        return
    if options.output is None:
        put(text.rstrip())
    say = put if options.output is not None else _aside
    system = finder.vehicle.system if finder.vehicle is not None else 0
    say(plain(f"{options.address}: system {system}, a {adopting.title(finder)}"))
    for each in finder.streams.values():
        say(f"video {each.name!r} of component {each.component} at {each.address}")
    for remark in remarks:
        say(remark)
    if adopting.unsafe(finder, options.station):
        where = options.output or options.address
        say(f"`rune-hub vehicle parameters {where} --write-safe` sets the safe values")
    if options.output is not None:
        say(f"written: {options.output}; `rune-hub run {options.output}` starts its hub")


def _aside(line: str) -> None:
    sys.stderr.write(plain(line) + "\n")


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
