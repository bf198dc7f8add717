"""The hubs of `rune demo`: simulated robots in processes of their own, on free loopback ports."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from rune_tui.commands.own_hub import OwnAutopilot, OwnHub

DEMO_LAYOUT = "demo"
AUTO = "auto"
"""The layout that is made from what the robot's hub describes."""
ROBOTS = ("magellan", "tracked", "blimp", "rov")
"""The robots that come with the hub."""
ARENAS = ("empty", "hall", "orange", "pool", "red", "yellow")
"""The arenas that come with the hub."""
_OF_ARENA = {"pool": "rov"}
"""The robot of an arena where it is not the first of `ROBOTS`."""
_OF_ROLE = {name: name for name in ROBOTS} | {"submarine": "rov"}
AUTOPILOTS = {"rover": "yellow", "sub": "pool", "blimp": "yellow"}
"""The simulated autopilots, and the arena of each."""
AUTOPILOT_PREFIX = "autopilot-"
"""Begins the name of a robot of the demo that is a simulated autopilot."""
_ALL_ELEMENTS = "hall"
"""The arena of a demo with several kinds of robots: land, water and air."""


def demo_robots(roles: Sequence[str], arena: str, robot: str | None) -> tuple[list[str], str]:
    """The shipped robot of each role in a layout, and the arena of all of them.

    Args:
        roles: The layout's names of its robots.
        arena: Name or path of the arena; empty: that of the robots.
        robot: The robot of each role that names none; None: the one that suits the arena.
    """
    usual = robot or _OF_ARENA.get(arena, ROBOTS[0])
    robots = [_OF_ROLE.get(role, usual) for role in roles]
    if not arena and len(set(robots)) > 1:
        arena = _ALL_ELEMENTS
    return robots, arena


def demo_layout(arena: str, robot: str | None, named: str = "") -> str:
    """The layout of a demo.

    Args:
        arena: Name or path of the arena; empty: that of the robot.
        robot: Name of the robot; None: the one that suits the arena.
        named: Its name or path; empty: the one that suits the robot.

    Raises:
        LayoutError: The name is that of no layout.
    """
    if named:
        _check_layout(named)
        return named
    (chosen,), _ = demo_robots(["robot"], arena, robot)
    # The shipped layout has no keys for holds, joints or motion up and down.
    return DEMO_LAYOUT if chosen == ROBOTS[0] else AUTO


def _check_layout(named: str) -> None:
    from hub.nearest import did_you_mean
    from rune_tui.errors import LayoutError, LayoutProblem
    from rune_tui.startup.opening import shipped_layouts

    layouts = [*shipped_layouts()]
    if named in (AUTO, *layouts) or Path(named).exists():
        return
    hint = did_you_mean(named, [*layouts, *ARENAS])
    hint = hint or f"; `rune layouts` lists layouts, and arenas are {', '.join(ARENAS)}"
    text = f"there is no such file, layout or arena{hint}"
    raise LayoutError([LayoutProblem(path=named, line=0, column=0, message=text)])


class DemoHubs:
    """The hubs of a demo; they end in parallel, with this context."""

    def __init__(self, log: Path) -> None:
        """Prepare.

        Args:
            log: File for the logs of all hubs.
        """
        self._log = log
        self._hubs: list[OwnHub] = []
        self._autopilots: list[OwnAutopilot] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        programs = [*self._hubs, *self._autopilots]
        for program in programs:
            program.begin_end()
        with ExitStack() as stack:
            for program in programs:
                stack.callback(program.close)

    def start(self, robots: Sequence[str], arena: str, settings: Sequence[str] = ()) -> None:
        """Start the hubs of more robots.

        Args:
            robots: Names of shipped robots, or of simulated autopilots.
            arena: Name or path of the arena; empty: that of each robot.
            settings: More values that replace those of robot files.

        Raises:
            OwnHubError: A process cannot be started, or an autopilot does not listen.
        """
        settings = [*([f"simulation.arena={arena}"] if arena else []), *settings]
        for robot in robots:
            name, address = self._vehicle(robot, arena)
            self._hubs.append(OwnHub(name, self._log, [*settings, *address]))

    def _vehicle(self, robot: str, arena: str) -> tuple[str, list[str]]:
        """The robot file, and the settings that its vehicle needs; starts an autopilot."""
        kind = robot.removeprefix(AUTOPILOT_PREFIX)
        if kind == robot:
            return robot, []
        autopilot = OwnAutopilot(kind, arena or AUTOPILOTS[kind], self._log)
        self._autopilots.append(autopilot)
        return autopilot.robot()

    def __len__(self) -> int:
        return len(self._hubs)

    def endpoints(self) -> list[str]:
        """Wait until all hubs listen; returns their endpoints.

        Raises:
            OwnHubError: A hub ended, or takes too long.
        """
        return [hub.endpoint() for hub in self._hubs]
