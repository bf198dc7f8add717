"""`rune-hub doctor`: checks the robot file and the machine, and reports problems and remedies."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from hub.command_output import put
from hub.errors import RobotFileError
from hub.inspection.doctor import (
    autopilot_checks,
    fleet_checks,
    hub_checks,
    library_checks,
    machine_checks,
    port_checks,
    robot_checks,
    ros_checks,
)
from hub.inspection.doctor.finding import Finding, Level, ok, problem, unknown
from hub.plain_text import plain
from hub.robots.description import RobotDescription
from hub.robots.robot_file import find_robot_file, read_description
from hub.table_text import json_text

_NOTHING_WRONG, _WRONG, _WRONG_ROBOT_FILE = 0, 1, 2
_ROBOT_FILE = "robot file"

MACHINE: Mapping[str, Callable[[], list[Finding]]] = {
    "versions": library_checks.versions,
    "shared memory": machine_checks.shared_memory,
    "open files": machine_checks.open_files,
    "clock": machine_checks.clock,
    "memory": machine_checks.memory,
    "processors": machine_checks.processors,
}
WITH_COMMANDS: Mapping[str, Callable[[str], list[Finding]]] = {
    "service": machine_checks.service,
    "user": machine_checks.user,
}
"""Checks with commands in their advice that contain the robot file's name."""
ROBOT: Mapping[str, Callable[[RobotDescription], list[Finding]]] = {
    "hub": hub_checks.hub,
    "sockets": hub_checks.sockets,
    "tcp": port_checks.tcp,
    "gateway": port_checks.gateway,
    "kept": hub_checks.kept,
    "keys": robot_checks.keys,
    "folders": robot_checks.folders,
    "space": machine_checks.space,
    "devices": robot_checks.devices,
    "extras": library_checks.extras,
    "autopilot": autopilot_checks.autopilot,
    "ros": ros_checks.ros,
    "fleet": fleet_checks.fleet,
}


def examine(name_or_path: str, load: Callable[[str], object], *, as_json: bool) -> int:
    """Run all checks, and print a line for each.

    Args:
        name_or_path: The robot file, or the name of a shipped one.
        load: Reads it whole, or raises RobotFileError.
        as_json: JSON, one line a finding.

    Returns:
        The exit code: 2 if the robot file is wrong, 1 if something else is or is not known, else 0.
    """
    counts = dict.fromkeys(Level, 0)
    robot_file_wrong = False
    for check, finding in _findings(name_or_path, load):
        counts[finding.level] += 1
        robot_file_wrong |= check == _ROBOT_FILE and finding.level is Level.PROBLEM
        put(_as_json(check, finding) if as_json else _as_line(check, finding))
    problems, warnings = counts[Level.PROBLEM], counts[Level.WARNING]
    if not as_json:
        not_known = f", not known: {counts[Level.UNKNOWN]}" if counts[Level.UNKNOWN] else ""
        put(f"problems: {problems}, warnings: {warnings}{not_known}")
    if robot_file_wrong:
        return _WRONG_ROBOT_FILE
    return _WRONG if problems or counts[Level.UNKNOWN] else _NOTHING_WRONG


def attempt(check: Callable[[], list[Finding]]) -> list[Finding]:
    """The findings of a check; its own failure is a finding too."""
    try:
        return check()
    except Exception as fault:  # noqa: BLE001 - a failed check does not end the others
        text = f"could not be looked at ({type(fault).__name__}: {fault})"
        return [unknown(text, "look yourself, and please report it")]


def _findings(name_or_path: str, load: Callable[[str], object]) -> Iterator[tuple[str, Finding]]:
    for finding in attempt(lambda: _robot_file(name_or_path, load)):
        yield _ROBOT_FILE, finding
    robot = _readable(name_or_path)
    if robot is not None:
        for name, of_robot in ROBOT.items():
            for finding in attempt(functools.partial(of_robot, robot)):
                yield name, finding
    for name, of_machine in MACHINE.items():
        for finding in attempt(of_machine):
            yield name, finding
    for name, of_name in WITH_COMMANDS.items():
        for finding in attempt(functools.partial(of_name, name_or_path)):
            yield name, finding


def _robot_file(name_or_path: str, load: Callable[[str], object]) -> list[Finding]:
    try:
        load(name_or_path)
    except RobotFileError as error:
        found = Path(name_or_path).exists()
        remedy = f"correct {name_or_path}" if found else "name a robot file or a shipped robot"
        return [problem(text, remedy) for text in error.problems]
    return [ok(f"{find_robot_file(name_or_path)} has no mistakes")]


def _readable(name_or_path: str) -> RobotDescription | None:
    """The robot, as far as its file can be read."""
    try:
        return read_description(find_robot_file(name_or_path))[0]
    except RobotFileError:
        return None


def _as_line(check: str, finding: Finding) -> str:
    line = f"{finding.level.value:8}{check}: {finding.text}"
    line += f" -> {finding.advice}" if finding.advice else ""
    return plain(line)


def _as_json(check: str, finding: Finding) -> str:
    return json_text(
        {
            "check": check,
            "level": finding.level.value,
            "text": finding.text,
            "advice": finding.advice,
        }
    )
