"""`rune-hub vehicle parameters`: shows the parameters of a vehicle, and sets them when asked."""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Mapping

from hub.command_line import ExitCode
from hub.command_output import print_error, put, put_json
from hub.gcm.autopilot import UnsafeParameter
from hub.inspection.output import table
from hub.inspection.vehicle.vehicle_link import (
    VehiclePlace,
    claimed,
    find_at,
    hub_with_autopilot,
    open_session,
    place_of,
)
from hub.robots.mavlink import adopting
from hub.robots.mavlink.asking.findings import STATION_KIND, VehicleFinder
from hub.robots.mavlink.asking.parameter_file import (
    keep_parameters,
    parameter_in,
    read_parameters,
)
from hub.robots.mavlink.asking.parameters import (
    Parameter,
    ParameterReading,
    ParameterWriting,
    changes_of,
    shown,
)
from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.mavlink.profiles.unsafe_parameters import unsafe_parameters, wanted_parameters

_LISTING_S = 60.0
_ARDUPILOT = 3


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: The robot file, the address or a file of parameters cannot be used, or there is
            no vehicle.
    """
    try:
        changes = _asked(options)
    except ValueError as fault:
        print_error(str(fault))
        return ExitCode.USAGE
    place = place_of(options)
    writes = bool(changes or options.write_safe)
    if writes and (hub := hub_with_autopilot(place)):
        print_error(f"its hub runs at {hub}: end it first; nothing was changed")
        return ExitCode.FAULT
    with contextlib.closing(open_session(place.address, place.key_file, place.station)) as session:
        finder = find_at(session, place, options.seconds)
        if writes:
            with claimed(session, _system(finder)) as rival:
                if rival:
                    print_error(f"{rival} has this vehicle: end it first; nothing was changed")
                    return ExitCode.FAULT
                return _write(session, finder, place, changes, safe=options.write_safe)
        return _show(session, finder, place, options)


def _asked(options: argparse.Namespace) -> dict[str, float]:
    """The changes that the options ask for.

    Raises:
        ValueError: One is not understood.
        ParameterFileError: The file cannot be used.
    """
    if options.restore is not None:
        return read_parameters(options.restore)
    changes: dict[str, float] = {}
    for each in options.write:
        name, _, value = each.partition("=")
        try:
            changes |= [parameter_in(f"{name.upper()},{value}")]
        except ValueError as fault:
            message = f"--write {each[:40]!r} is no NAME=VALUE"
            raise ValueError(message) from fault
    return changes


def _show(
    session: VehicleSession,
    finder: VehicleFinder,
    place: VehiclePlace,
    options: argparse.Namespace,
) -> int:
    names = [name.upper() for name in options.names] or [*finder.wanted]
    if not names and not options.all:
        print_error("Rune knows no parameters of vehicles of this type: name some, or give --all")
        return ExitCode.USAGE
    reading = _read(session, finder, [] if options.all else names)
    unsafe = {each.name: each for each in _unsafe(finder, place, reading.values)}
    rows = [
        reading.values[name]
        for name in (sorted(reading.values) if options.all else names)
        if name in reading.values and (name in unsafe or not options.unsafe)
    ]
    if options.json:
        for each in rows:
            put_json(_facts(each, unsafe.get(each.name)))
    elif rows:
        table(("parameter", "value", "safe", "why"), [_row(each, unsafe) for each in rows], words=4)
    elif options.unsafe:
        put("no parameter that Rune knows is unsafe")
    return _missing(reading, named=bool(options.names))


def _missing(reading: ParameterReading, *, named: bool) -> int:
    """Say what was not read; returns the exit code."""
    if reading.missing:
        print_error(f"the vehicle has no parameter {', '.join(reading.missing)}")
        return ExitCode.FAULT if named else ExitCode.OK
    if not reading.complete:
        print_error(f"only {len(reading.values)} of {reading.total} parameters came")
        return ExitCode.FAULT
    if reading.has_more:
        print_error(f"the vehicle says it has more: only {reading.total} parameters are read")
        return ExitCode.FAULT
    return ExitCode.OK


def _row(each: Parameter, unsafe: Mapping[str, UnsafeParameter]) -> tuple[str, str, str, str]:
    wrong = unsafe.get(each.name)
    if wrong is None:
        return each.name, shown(each.value), "", ""
    return each.name, shown(each.value), shown(wrong.wanted), wrong.why


def _facts(each: Parameter, wrong: UnsafeParameter | None) -> dict[str, object]:
    value = float(shown(each.value))
    facts: dict[str, object] = {
        "name": each.name,
        "value": value if math.isfinite(value) else None,
        "type": each.kind,
        "unsafe": wrong is not None,
    }
    return facts | ({"wanted": wrong.wanted, "why": wrong.why} if wrong is not None else {})


def _read(session: VehicleSession, finder: VehicleFinder, names: list[str]) -> ParameterReading:
    """Read parameters; no names: all."""
    vehicle = finder.vehicle
    system, autopilot = (vehicle.system, vehicle.autopilot) if vehicle is not None else (0, 0)
    reading = ParameterReading(system, names, autopilot)
    session.ask(reading, _LISTING_S)
    return reading


def _unsafe(
    finder: VehicleFinder, place: VehiclePlace, values: Mapping[str, Parameter]
) -> list[UnsafeParameter]:
    if finder.profile is None:
        return []
    known = {name: each.value for name, each in values.items()}
    return [*unsafe_parameters(finder.profile, known, place.station)]


def _write(
    session: VehicleSession,
    finder: VehicleFinder,
    place: VehiclePlace,
    changes: Mapping[str, float],
    *,
    safe: bool,
) -> int:
    if refusal := _refusal(finder, place):
        print_error(f"{refusal}; nothing was changed")
        return ExitCode.FAULT
    if safe and finder.profile is not None:
        names = [each.name for each in wanted_parameters(finder.profile, place.station)]
    else:
        names = [*changes]
    present = _read(session, finder, names) if names else None
    if present is None:
        print_error("Rune knows no safe parameters of vehicles of this type; nothing was changed")
        return ExitCode.FAULT
    if safe:
        changes = {each.name: each.wanted for each in _unsafe(finder, place, present.values)}
    elif present.missing:
        text = f"the vehicle has no parameter {', '.join(present.missing)}; nothing was changed"
        print_error(text)
        return ExitCode.FAULT
    wanted = changes_of(changes, present.values)
    if not wanted:
        put("all parameters have these values already")
        return ExitCode.OK
    return _written(session, finder, place, present.values, wanted)


def _written(
    session: VehicleSession,
    finder: VehicleFinder,
    place: VehiclePlace,
    present: Mapping[str, Parameter],
    wanted: list[Parameter],
) -> int:
    """Keep the old values, set the new ones, and say which failed; returns the exit code."""
    kept = keep_parameters(place.name, adopting.title(finder), [present[e.name] for e in wanted])
    put(f"the old values are in {kept}; --restore {kept} sets them again")
    writing = ParameterWriting(_system(finder), wanted)
    ended = session.ask(writing, 5.0 + 3.0 * len(wanted))
    for each in wanted:
        if each.name in writing.written:
            put(f"{each.name}: {shown(present[each.name].value)} -> {shown(each.value)}")
        else:
            why = writing.failed.get(each.name, "" if ended else "the time was over")
            print_error(f"{each.name} was not set: {why}")
    return ExitCode.OK if len(writing.written) == len(wanted) else ExitCode.FAULT


def _system(finder: VehicleFinder) -> int:
    return finder.vehicle.system if finder.vehicle is not None else 0


def _refusal(finder: VehicleFinder, place: VehiclePlace) -> str:
    """Why parameters cannot be set now; empty: they can."""
    vehicle = finder.vehicle
    if vehicle is None or vehicle.autopilot != _ARDUPILOT:
        return "Rune sets parameters of ArduPilot only"
    if vehicle.armed:
        return "it is armed: disarm it first"
    for each in finder.components.values():
        if each.kind == STATION_KIND and each.system == place.station:
            return (
                f"a ground station with the number {each.system}, such as a hub, is connected to "
                "it: end that first"
            )
    return ""
