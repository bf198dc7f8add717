"""A robot file to its modules, with all mistakes of the file at once."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from typing import Any

from hub import toml_reader as toml
from hub.errors import ArenaError, RobotFileError, UnknownKindError
from hub.gcm.capability import Capability
from hub.nearest import did_you_mean
from hub.robots.description import RobotDescription
from hub.robots.registry import kind_of
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.ros_table import ROS_KIND
from hub.toml_reader import choice, key, number, several, text, variables, whole_number
from hub.values import dataclass

_OWN_PACKAGE = "hub.modules."
_OWN = "X_"
"""Prefix of capabilities outside GCM."""


def _capability(value: object) -> str:
    """Read a capability: one of GCM, or one with the prefix `X_`."""
    known = tuple(Capability)
    if isinstance(value, str) and (
        value in known or (value.startswith(_OWN) and value.isidentifier() and len(value) <= 32)
    ):
        return value
    reason = (
        f"{toml.shorten(value)} is none of {', '.join(known)}, and no capability of your own, "
        f"which begins with {_OWN}{did_you_mean(value, known)}"
    )
    raise toml.RefusedError(reason)


_SECONDS = number(0.0, 3600.0)
_CAPABILITIES = several(_capability, 64)
_COMMAND = several(text(1000, any_character=True), 64)
_START = choice({"always": True, "on demand": False})


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleSpec:
    """A module that the daemon runs; each field has its `key` in the table.

    Attributes:
        name: Its name at central.
        run: A Python module to execute; empty: `command` is executed.
        command: A program and its arguments; the daemon adds options for hub and robot.
        keep_alive_s: Silence after which it counts as hanging [s]; 0: it never announces itself;
            None: the default of its capabilities.
        settled_s: Run time after which a module restarts without a pause [s].
    """

    name: str
    run: str = key(text(200), "", "a Python module", without="`command` says what to run")
    command: tuple[str, ...] = key(
        _COMMAND, (), "a program and its arguments", without="`run` says what to run"
    )
    capabilities: tuple[str, ...] = key(
        _CAPABILITIES, (), "what it can do, until it says so itself", without="none"
    )
    needs: tuple[str, ...] = key(
        _CAPABILITIES, (), "what it needs of other modules, until it says so itself", without="none"
    )
    always: bool = key(
        _START,
        default=True,
        meaning="when it runs; on demand: while somebody wants one of its capabilities",
        at="start",
        without="`always`",
    )
    keep_alive_s: float | None = key(
        _SECONDS,
        None,
        "silence after which it hangs [s]; 0: it does not announce itself",
        without="1 for the driver, else 5",
    )
    start_timeout_s: float = key(
        number(0.1, 3600.0), 15.0, "from its start to its first announcement [s]"
    )
    linger_s: float = key(_SECONDS, 10.0, "how long it goes on when nobody wants it any more [s]")
    restart_limit: int = key(
        whole_number(0, 1000), 10, "restarts within `restart_window_s`; then it is given up"
    )
    restart_window_s: float = key(number(1.0, 86400.0), 60.0, "[s]")
    settled_s: float = key(
        _SECONDS, 2.0, "a module that ran for so long is started again at once [s]"
    )
    backoff_s: float = key(
        number(0.01, 3600.0),
        0.2,
        "pause before the second restart of one that did not; each further one is doubled [s]",
    )
    backoff_longest_s: float = key(number(0.01, 3600.0), 5.0, "longest pause [s]")
    ask_timeout_s: float = key(number(0.0, 60.0), 1.0, "from the command to stop to SIGTERM [s]")
    stop_timeout_s: float = key(number(0.1, 60.0), 2.0, "from the command to stop to SIGKILL [s]")
    nice: int = key(whole_number(-20, 19), 0, "what is added to its niceness")
    memory_limit_mb: float = key(
        number(0.0, 1e6), 0.0, "resident memory above which it is started again [MB]; 0: no limit"
    )
    environment: tuple[tuple[str, str], ...] = key(
        variables(4096, 256), (), "variables beside the daemon's own", without="none"
    )

    @property
    def python_module(self) -> str:
        """The Python module of the command; empty: another program, or another Python."""
        if len(self.command) == 3 and self.command[:2] == (sys.executable, "-m"):
            return self.command[2]
        return ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotTable:
    """A checked robot file.

    Attributes:
        robot: The robot itself.
        modules: Its modules, in the order of their start.
    """

    robot: RobotDescription
    modules: tuple[ModuleSpec, ...]


def load_robot_table(name_or_path: str, settings: Sequence[str] = ()) -> RobotTable:
    """Read and check a robot file.

    Args:
        name_or_path: A path, or the name of a shipped robot.
        settings: Values in place of the file's, each as "TABLE.KEY=VALUE".

    Raises:
        RobotFileError: All its mistakes.
    """
    path = find_robot_file(name_or_path)
    robot, problems = read_description(path, settings)
    if robot.kind:
        try:
            kind_of(robot)
        except UnknownKindError as error:
            problems.add(toml.TOP, str(error), "kind")
    _check_arena(robot, problems)
    _check_autopilot(robot, problems)
    _check_ros(robot, problems)
    modules = tuple(
        _module(name, values, problems) for name, values in (robot.modules | _fleet(robot)).items()
    )
    if not modules:
        problems.append("it names no modules: add at least [modules.driver]")
    if problems:
        raise RobotFileError(str(path), problems)
    return RobotTable(robot=robot, modules=modules)


def _check_arena(robot: RobotDescription, problems: toml.Problems) -> None:
    from hub.robots.simulation_faults import simulation_faults
    from hub.sim.arena import load_arena

    if not robot.simulated:
        return
    try:
        arena = load_arena(robot.arena)
    except ArenaError as error:
        for problem in str(error).splitlines():
            problems.add("[simulation]", f"[simulation], key 'arena': {problem}", "arena")
        return
    for place, which, fault in simulation_faults(robot, arena):
        problems.add(place, f"{place}, key '{which}': {fault}", which)


def _check_autopilot(robot: RobotDescription, problems: toml.Problems) -> None:
    from hub.robots.mavlink.robot_file_faults import autopilot_faults

    for place, which, fault in autopilot_faults(robot) if robot.has_autopilot else ():
        problems.add(place, f"{place}, key '{which}': {fault}", which)


def _check_ros(robot: RobotDescription, problems: toml.Problems) -> None:
    from hub.robots.ros.robot_file_faults import ros_faults

    for place, which, fault in ros_faults(robot) if robot.kind == ROS_KIND else ():
        problems.add(place, f"{place}, key '{which}': {fault}", which)


def _module(name: str, values: Any, problems: toml.Problems) -> ModuleSpec:  # noqa: ANN401 - TOML
    place = f"[modules.{name}]"
    fields = toml.read_table(toml.keys_of(ModuleSpec), values, place, problems)
    run, command = fields.pop("run"), fields.pop("command")
    if bool(run) == bool(command):
        problems.add(place, f"{place}: give either 'run', a Python module, or 'command', a list")
    elif run and not _importable(run):
        problems.add(place, f"{place}, key 'run': there is no Python module {run!r}", "run")
    if not name.isidentifier() or len(name) > 32:
        reason = f"{place}: a module's name is up to 32 letters, digits and underscores"
        problems.add(place, reason)
    return ModuleSpec(name=name, command=command or (sys.executable, "-m", run), **fields)


def _fleet(robot: RobotDescription) -> dict[str, Any]:
    """The gateway to the robot's fleet, unless the robot file says itself how it runs."""
    wanted = robot.fleet is not None and "fleet" not in robot.modules
    return {"fleet": {"run": "hub.doors.fleet"}} if wanted else {}


def _importable(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def common_imports(table: RobotTable) -> tuple[str, ...]:
    """The imports that modules of the robot share; none starts a thread.

    These are the imports of Rune's own modules and of the robot's kind. The effects of other
    modules' imports are unknown.
    """
    runs = (spec.python_module for spec in table.modules)
    own = (f"{run}.__main__" for run in runs if run.startswith(_OWN_PACKAGE))
    return (*own, *kind_of(table.robot).imports)


def robot_arguments(robot: RobotDescription) -> list[str]:
    """A module's options for its robot."""
    settings = [word for setting in robot.settings for word in ("--set", setting)]
    return ["--robot", str(robot.path.resolve()), *settings]


def hub_arguments(endpoint: str, robot: RobotDescription) -> list[str]:
    """The options of every module that runs."""
    return ["--hub", endpoint, *robot_arguments(robot), "--stop-with-stdin"]
