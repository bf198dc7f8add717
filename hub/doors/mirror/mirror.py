"""The robots of a fleet on this machine, as they come and go."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

from hub.doors.mirror.fleet_line import FleetLine
from hub.doors.mirror.mirrored_robot import MirroredRobot
from hub.doors.mirror.robot_line import RobotLine
from hub.errors import FleetKeyError
from hub.ipc.roles import Principal
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.zenoh.fleet_keys import KeyKind, parse_key, pattern

MOST_ROBOTS = 64
"""Most robots that one mirror shows: each has threads and sockets of its own."""


class Mirror:
    """A local hub for each robot of a fleet that is there."""

    def __init__(
        self,
        line: FleetLine,
        fleet: str,
        operator: Principal,
        *,
        robots: Collection[str],
        folder: Path,
        loop: Loop,
        faults: FaultCounter,
        report: Callable[[dict[str, object]], None],
    ) -> None:
        """Begin.

        Args:
            line: To the fleet.
            fleet: Its name.
            operator: Who asks and commands.
            robots: Names of the wanted robots; empty: all.
            folder: Private folder for their hubs.
            loop: Serves all.
            faults: Counts what is refused.
            report: Gets an event each time that a robot comes, goes or refuses a command.
        """
        self._line, self._fleet, self._operator = line, fleet, operator
        self._wanted, self._folder = frozenset(robots), folder
        self._loop, self._faults, self._report = loop, faults, report
        self._robots: dict[str, MirroredRobot] = {}
        self._watch = line.watch(pattern(fleet, KeyKind.ALIVE), self._changed)

    def close(self) -> None:
        """End all."""
        self._watch.withdraw()
        for robot in self._robots.values():
            robot.close()

    def _changed(self, key: str, there: bool) -> None:  # noqa: FBT001 - as the line calls it
        try:
            name = parse_key(self._fleet, key).robot
        except FleetKeyError as error:
            self._faults.count("no key of the fleet", str(error))
            return
        if self._wanted and name not in self._wanted:
            return
        robot = self._robots.get(name)
        if robot is None:
            if not there:
                return
            self._make_room()
            if len(self._robots) >= MOST_ROBOTS:
                text = f"{name} is one more than {MOST_ROBOTS}; name those you want with --robot"
                self._faults.count("too many robots", text)
                return
            line = RobotLine(
                self._line, self._fleet, name, self._operator, self._loop.clock, self._faults
            )
            robot = MirroredRobot(line, self._folder, self._loop, self._faults, self._report)
            self._robots[name] = robot
        robot.changed(there=there)

    def _make_room(self) -> None:
        """Forget the robot that was first seen of those that are gone, if there is no room."""
        gone = next((name for name, each in self._robots.items() if not each.is_there), None)
        if gone is not None and len(self._robots) >= MOST_ROBOTS:
            self._robots.pop(gone).close()
