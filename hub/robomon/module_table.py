"""A robot file to the modules it names; everything that is wrong with the file, at once."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hub import toml_reader as toml
from hub.errors import ArenaError, RobotFileError, UnknownKindError
from hub.gcm.capability import Capability
from hub.robots.description import RobotDescription, find_robot_file, read_description
from hub.robots.registry import kind_of

_OWN_PACKAGE = "hub.modules."
_OWN = "X_"
"""Capabilities that are not of the common vocabulary begin so."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleSpec:
    """A module that the daemon runs.

    Attributes:
        name: Its name at central.
        command: What to execute; options for hub and robot are added.
        capabilities: What the file says it can do; a hint, until the module says so itself.
        needs: What the file says it needs of other modules; a hint as well.
        always: Whether it runs always, or when one of its capabilities is wanted.
        keep_alive_s: Silence after which it counts as hanging [s]; 0: it does not announce itself;
            None: as long as its capabilities say.
        start_timeout_s: Time from its start to its first announcement [s].
        linger_s: Time that it goes on when nobody wants it any more [s].
        restart_limit: Restarts within `restart_window_s` after which the daemon gives up.
        restart_window_s: [s].
        settled_s: A module that ran for so long before it ended is started again at once [s].
        backoff_s: Pause before the second restart of one that did not; each further pause is twice
            as long [s]. The first restart is at once.
        backoff_longest_s: Longest pause [s].
        ask_timeout_s: Time between the common command STOP and SIGTERM [s].
        stop_timeout_s: Time between the common command STOP and SIGKILL [s].
        nice: What is added to its niceness.
        memory_limit_mb: Resident memory from which on it is started anew [MB]; 0: no limit.
        environment: Variables of its environment, beside the daemon's.
    """

    name: str
    command: tuple[str, ...]
    capabilities: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    always: bool = True
    keep_alive_s: float | None = None
    start_timeout_s: float = 15.0
    linger_s: float = 10.0
    restart_limit: int = 10
    restart_window_s: float = 60.0
    settled_s: float = 2.0
    backoff_s: float = 0.2
    backoff_longest_s: float = 5.0
    ask_timeout_s: float = 1.0
    stop_timeout_s: float = 2.0
    nice: int = 0
    memory_limit_mb: float = 0.0
    environment: tuple[tuple[str, str], ...] = ()

    @property
    def python_module(self) -> str:
        """The Python module that the command runs by this Python; empty if it is another one."""
        if len(self.command) == 3 and self.command[:2] == (sys.executable, "-m"):
            return self.command[2]
        return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotTable:
    """A robot file that has no mistakes.

    Attributes:
        robot: The robot itself.
        modules: Its modules, in the order in which they are started.
    """

    robot: RobotDescription
    modules: tuple[ModuleSpec, ...]


def _capability(value: object) -> str:
    """Read a capability: one of the vocabulary, or one of a module of one's own."""
    known = tuple(Capability)
    if isinstance(value, str) and (
        value in known or (value.startswith(_OWN) and value.isidentifier() and len(value) <= 32)
    ):
        return value
    text = (
        f"{toml.shorten(value)} is none of {', '.join(known)}, and no capability of your own, "
        f"which begins with {_OWN}{toml.nearest(value, known)}"
    )
    raise toml.RefusedError(text)


_SECONDS = toml.number(0.0, 3600.0)
_CAPABILITIES = toml.Key(toml.several(_capability, 64), ())
_MODULE = {
    "run": toml.Key(toml.text(200), ""),
    "command": toml.Key(toml.several(toml.text(1000, any_character=True), 64), ()),
    "capabilities": _CAPABILITIES,
    "needs": _CAPABILITIES,
    "start": toml.Key(
        toml.choice({"always": True, "on demand": False}), default=True, field="always"
    ),
    "keep_alive_s": toml.Key(_SECONDS, None),
    "start_timeout_s": toml.Key(toml.number(0.1, 3600.0), 15.0),
    "linger_s": toml.Key(_SECONDS, 10.0),
    "restart_limit": toml.Key(toml.whole_number(0, 1000), 10),
    "restart_window_s": toml.Key(toml.number(1.0, 86400.0), 60.0),
    "settled_s": toml.Key(_SECONDS, 2.0),
    "backoff_s": toml.Key(toml.number(0.01, 3600.0), 0.2),
    "backoff_longest_s": toml.Key(toml.number(0.01, 3600.0), 5.0),
    "ask_timeout_s": toml.Key(toml.number(0.0, 60.0), 1.0),
    "stop_timeout_s": toml.Key(toml.number(0.1, 60.0), 2.0),
    "nice": toml.Key(toml.whole_number(-20, 19), 0),
    "memory_limit_mb": toml.Key(toml.number(0.0, 1e6), 0.0),
    "environment": toml.Key(toml.variables(4096, 256), ()),
}


def load_robot_table(name_or_path: str, settings: Sequence[str] = ()) -> RobotTable:
    """Read and check a robot file.

    Args:
        name_or_path: A path, or the name of a shipped robot.
        settings: Values in place of the file's, each as "TABLE.KEY=VALUE".

    Raises:
        RobotFileError: All that is wrong with it.
    """
    path = find_robot_file(name_or_path)
    robot, problems = read_description(path, settings)
    if robot.kind:
        try:
            kind_of(robot)
        except UnknownKindError as error:
            problems.add(toml.TOP, str(error), "kind")
    _check_arena(robot, problems)
    modules = tuple(_module(name, values, problems) for name, values in robot.modules.items())
    if not modules:
        problems.append("it names no modules: add at least [modules.driver]")
    if problems:
        raise RobotFileError(str(path), problems)
    return RobotTable(robot=robot, modules=modules)


def _check_arena(robot: RobotDescription, problems: toml.Problems) -> None:
    from hub.sim.arena import load_arena

    if not robot.simulated:
        return
    try:
        load_arena(robot.arena)
    except ArenaError as error:
        for problem in str(error).splitlines():
            problems.add("[simulation]", f"[simulation], key 'arena': {problem}", "arena")


def _module(name: str, values: Any, problems: toml.Problems) -> ModuleSpec:  # noqa: ANN401 - TOML
    place = f"[modules.{name}]"
    fields = toml.read_table(_MODULE, values, place, problems)
    run, command = fields.pop("run"), fields.pop("command")
    if bool(run) == bool(command):
        problems.add(place, f"{place}: give either 'run', a Python module, or 'command', a list")
    elif run and not _importable(run):
        problems.add(place, f"{place}, key 'run': there is no Python module {run!r}", "run")
    if not name.isidentifier() or len(name) > 32:
        text = f"{place}: a module's name is up to 32 letters, digits and underscores"
        problems.add(place, text)
    return ModuleSpec(name=name, command=command or (sys.executable, "-m", run), **fields)


def _importable(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def common_imports(table: RobotTable) -> tuple[str, ...]:
    """What several modules of the robot import and can share; it starts no threads.

    That is what Rune's own modules import, and the robot's kind. Modules of other people are not
    among it: nobody knows what their import does.
    """
    runs = (spec.python_module for spec in table.modules)
    own = (f"{run}.__main__" for run in runs if run.startswith(_OWN_PACKAGE))
    return (*own, *kind_of(table.robot).imports)


def robot_arguments(robot: RobotDescription) -> list[str]:
    """The options that say to a module which robot it belongs to."""
    settings = [word for setting in robot.settings for word in ("--set", setting)]
    return ["--robot", str(robot.path.resolve()), *settings]


def hub_arguments(endpoint: str, robot: RobotDescription) -> list[str]:
    """The options that every module gets when it is to run."""
    return ["--hub", endpoint, *robot_arguments(robot), "--stop-with-stdin"]
