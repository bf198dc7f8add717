"""A robot file to the modules it names; everything that is wrong with the file, at once."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hub import toml_tables as toml
from hub.errors import ArenaError, RobotFileError
from hub.robots.description import RobotDescription, find_robot_file, read_description
from hub.robots.registry import KINDS


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleSpec:
    """A module that the daemon runs.

    Attributes:
        name: Its name at central.
        command: What to execute; options for hub and robot are added.
        restart_limit: Restarts within `restart_window_s` after which the daemon gives up.
        restart_window_s: [s].
        stop_timeout_s: Time between asking it to stop and killing it [s].
    """

    name: str
    command: tuple[str, ...]
    restart_limit: int
    restart_window_s: float
    stop_timeout_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotTable:
    """A robot file that has no mistakes.

    Attributes:
        robot: The robot itself.
        modules: Its modules, in the order in which they are started.
    """

    robot: RobotDescription
    modules: tuple[ModuleSpec, ...]


_MODULE = {
    "run": toml.Key(toml.text(200), ""),
    "command": toml.Key(toml.texts(1000, 64), ()),
    "restart_limit": toml.Key(toml.whole_number(0, 1000), 5),
    "restart_window_s": toml.Key(toml.number(1.0, 86400.0), 60.0),
    "stop_timeout_s": toml.Key(toml.number(0.1, 60.0), 2.0),
}


def load_robot_table(name_or_path: str) -> RobotTable:
    """Read and check a robot file.

    Raises:
        RobotFileError: All that is wrong with it.
    """
    path = find_robot_file(name_or_path)
    robot, problems = read_description(path)
    if robot.kind and robot.kind not in KINDS:
        known = ", ".join(KINDS)
        hint = toml.nearest(robot.kind, KINDS)
        problems.append(f"kind {robot.kind!r} is none of {known}{hint}")
    problems += _arena_problems(robot)
    modules = tuple(_module(name, values, problems) for name, values in robot.modules.items())
    if not modules:
        problems.append("it names no modules: add at least [modules.driver]")
    if problems:
        raise RobotFileError(str(path), problems)
    return RobotTable(robot=robot, modules=modules)


def _arena_problems(robot: RobotDescription) -> list[str]:
    from hub.sim.arena import load_arena

    if robot.kind in KINDS and not robot.simulated:
        return []
    try:
        load_arena(robot.arena)
    except ArenaError as error:
        return [f"[simulation], key 'arena': {problem}" for problem in str(error).splitlines()]
    return []


def _module(name: str, values: Any, problems: list[str]) -> ModuleSpec:  # noqa: ANN401 - TOML
    place = f"[modules.{name}]"
    fields = toml.read_table(_MODULE, values, place, problems)
    run, command = fields.pop("run"), fields.pop("command")
    if bool(run) == bool(command):
        problems.append(f"{place}: give either 'run', a Python module, or 'command', a list")
    elif run and not _importable(run):
        problems.append(f"{place}, key 'run': there is no Python module {run!r}")
    if not name.isidentifier() or len(name) > 32:
        problems.append(f"{place}: a module's name is up to 32 letters, digits and underscores")
    return ModuleSpec(name=name, command=command or (sys.executable, "-m", run), **fields)


def _importable(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def hub_arguments(endpoint: str, robot_file: Path) -> list[str]:
    """The options that every module gets."""
    return ["--hub", endpoint, "--robot", str(robot_file.resolve()), "--stop-with-stdin"]
