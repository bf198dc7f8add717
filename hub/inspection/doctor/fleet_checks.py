"""The doctor on a robot's fleet: its certificate, the router, and whether its name is free."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from hub.errors import HubError, KeyFileError
from hub.inspection.doctor.finding import Finding, Level, ok, problem, unknown, warning
from hub.inspection.doctor.hub_checks import modules_of_hub
from hub.inspection.doctor.library_checks import missing
from hub.robots.description import RobotDescription
from hub.robots.fleet_table import FleetTable
from hub.zenoh.certificate_facts import read_certificate
from hub.zenoh.fleet_keys import FleetKey, KeyKind, pattern
from hub.zenoh.fleet_session import open_fleet_session
from hub.zenoh.session import EXTRA
from hub.zenoh.settings import CertificateFiles

_TOKENS_S = 2.0
GATEWAY = "fleet"
"""Name of the robot's own gateway among the clients of its hub."""


def fleet(robot: RobotDescription) -> list[Finding]:
    """Whether the robot can join its fleet, now and in a month."""
    if robot.fleet is None:
        return [ok("not needed: the robot file has no table [fleet]")]
    return [*_findings(robot, robot.fleet)]


def _findings(robot: RobotDescription, table: FleetTable) -> Iterator[Finding]:
    if lacks := missing("fleet"):
        text = f"{', '.join(lacks)} is missing, which [fleet] needs"
        yield problem(text, f'pip install "{EXTRA}"')
        return
    name = table.name or robot.name
    if table.certificates:
        certificate = _certificate(table, name)
        yield certificate
        if certificate.level is Level.PROBLEM:
            return
    try:
        session = open_fleet_session(table.place, table.client_settings(name))
    except HubError as error:
        yield problem(str(error), "start it, or correct [fleet], key 'router'")
        return
    with contextlib.closing(session):
        own = FleetKey(kind=KeyKind.ALIVE, robot=name).under(table.fleet)
        there = session.tokens(pattern(table.fleet, KeyKind.ALIVE, robot=name), timeout=_TOKENS_S)
    yield ok(f"the router at {table.place} answers")
    if own not in there:
        yield ok(f"the name {name} is free in the fleet {table.fleet}")
        return
    try:
        modules = modules_of_hub(robot.name) or ""
    except HubError as error:
        why = f"its hub does not answer: {type(error).__name__}"
        text = f"whether {name} in the fleet {table.fleet} is this robot is not known ({why})"
        yield unknown(text, "see the check `hub`")
        return
    if GATEWAY in modules.split(", "):
        yield ok(f"{name} is in the fleet {table.fleet} now")
    else:
        text = f"another robot of the fleet {table.fleet} has the name {name} now"
        yield problem(text, "give one of them another name: [fleet], key 'name'")


def _certificate(table: FleetTable, name: str) -> Finding:
    files = CertificateFiles.of(Path(table.certificates), f"robot-{name}")
    try:
        facts = read_certificate(files)
    except KeyFileError as error:
        return problem(str(error), "see [fleet], key 'certificates'")
    remedy = f"rune-hub fleet keys remove {facts.name}, then make {name} --role robot again"
    if facts.name != f"robot:{name}":
        text = f"{files.certificate} is for {facts.name}, and this robot is robot:{name}"
        return problem(text, "copy the robot's own certificate, or correct [fleet], key 'name'")
    if facts.ends_soon:
        text = f"the certificate of {facts.name} ends on {facts.last_day}"
        return warning(text, f"where the fleet's authority is: {remedy}")
    return ok(f"the certificate is for {facts.name}, until {facts.last_day}")
