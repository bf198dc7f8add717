"""`rune-hub vehicle parameters`: shows the parameters of a vehicle, and sets them when asked."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import math
from collections.abc import Mapping, Sequence

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
from hub.robots.mavlink.profiles.profile import OLDER_NAMES
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
    names = [name.upper() for name in options.names] or _with_older(finder.wanted)
    if not names and not options.all:
        print_error("Rune knows no parameters of vehicles of this type: name some, or give --all")
        return ExitCode.USAGE
    reading = _read(session, finder, [] if options.all else names)
    checked = {each.name: each for each in _unsafe(finder, place, reading.values)}
    unsafe = {name: each for name, each in checked.items() if not math.isnan(each.value)}
    unread = [] if options.names else [name for name in checked if name not in unsafe]
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
    elif options.unsafe and not unread:
        put("no parameter that Rune knows is unsafe")
    return _missing(reading, unread, named=bool(options.names))


def _with_older(names: Sequence[str]) -> list[str]:
    """Names, and those that older firmware has for them."""
    return [*names, *(old for old, name in OLDER_NAMES.items() if name in names)]


def _without_older(reading: ParameterReading) -> list[str]:
    """The names that were not read, under no name that the vehicle may have for them."""
    read = {OLDER_NAMES.get(name, name) for name in reading.values}
    return [name for name in reading.missing if OLDER_NAMES.get(name, name) not in read]


def _missing(reading: ParameterReading, unread: list[str], *, named: bool) -> int:
    """Say what was not read; returns the exit code.

    Args:
        reading: What was asked.
        unread: Those of it that decide whether the vehicle is safe.
        named: Whether the operator named what to read; else the vehicle may lack some.
    """
    for name in unread:
        print_error(f"not known whether safe: {name} was not read")
    others = [name for name in _without_older(reading) if name not in unread]
    if others:
        print_error(f"it has no parameter {', '.join(others)}, or did not answer")
    if unread or (others and named):
        return ExitCode.FAULT
    if reading.missing:
        return ExitCode.OK  # the vehicle has the present names of these
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
    present = {OLDER_NAMES.get(name, name): name for name in values}
    known = {OLDER_NAMES.get(name, name): each.value for name, each in values.items()}
    return [
        dataclasses.replace(each, name=present.get(each.name, each.name))
        for each in unsafe_parameters(finder.profile, known, place.station)
    ]


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
        wanted_names = [each.name for each in wanted_parameters(finder.profile, place.station)]
        names = _with_older(wanted_names)
    else:
        names = [*changes]
    present = _read(session, finder, names) if names else None
    if present is None:
        print_error("Rune knows no safe parameters of vehicles of this type; nothing was changed")
        return ExitCode.FAULT
    unread: list[str] = []
    if safe:
        found = _unsafe(finder, place, present.values)
        changes = {each.name: each.wanted for each in found if not math.isnan(each.value)}
        unread = [each.name for each in found if math.isnan(each.value)]
    elif present.missing:
        text = f"it has no parameter {', '.join(present.missing)}, or did not answer"
        print_error(f"{text}; nothing was changed")
        return ExitCode.FAULT
    for name in unread:
        print_error(f"{name} was not read, so it was not set: give this command again")
    wanted = changes_of(changes, present.values)
    if not wanted and not unread:
        put("all parameters have these values already")
    code = _written(session, finder, place, present.values, wanted) if wanted else ExitCode.OK
    return ExitCode.FAULT if unread else code


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
