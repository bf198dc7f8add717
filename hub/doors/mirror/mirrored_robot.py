"""A robot of a fleet on this machine: its local hub is there while the robot answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hub.doors.definitions import MOST_OTHERS
from hub.doors.mirror.documents import definition_of, read_definitions, read_operators
from hub.doors.mirror.local_hub import LocalHub, endpoint_in
from hub.doors.mirror.robot_line import CLOCK_S, LOST_S, RobotLine
from hub.errors import HubError
from hub.ipc.definition import MessageDefinition
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.wire.control import Define
from hub.zenoh.fleet_keys import KeyKind

FOLLOW_S = 0.05
"""Time between two looks at what is subscribed to here [s]."""
_RETRY_S = 2.0


class MirroredRobot:
    """One robot, as it comes and goes."""

    def __init__(
        self,
        line: RobotLine,
        folder: Path,
        loop: Loop,
        faults: FaultCounter,
        report: Callable[[dict[str, object]], None],
    ) -> None:
        """Wait for it.

        Args:
            line: To the robot.
            folder: Private folder; the robot's hub listens in one of its name in it.
            loop: Serves it.
            faults: Counts what the robot says wrong of itself.
            report: Gets an event each time that its hub opens or closes, for each refusal,
                and for each change of the rate of states.
        """
        self._place = folder / line.robot
        self._line, self._loop, self._faults, self._report = line, loop, faults, report
        self._there, self._next_open = False, 0.0
        self._definitions: dict[str, MessageDefinition[Any]] = {}
        self._others: dict[str, Define | None] = {}
        """Messages that are not of GCM, by name; None: its definition was made."""
        self._hub: LocalHub | None = None
        self._timers = [loop.every(CLOCK_S, self._look), loop.every(FOLLOW_S, self._follow)]

    @property
    def is_there(self) -> bool:
        """Whether its token is there."""
        return self._there

    @property
    def is_open(self) -> bool:
        """Whether its local hub is open."""
        return self._hub is not None

    def changed(self, *, there: bool) -> None:
        """Its token came or went."""
        if there == self._there:
            return
        self._there = there
        if not there:
            self._shut("it left the fleet")
            return
        self._begin()

    def close(self) -> None:
        """End."""
        self._there = False
        self._shut("")
        for timer in self._timers:
            timer.cancel()

    def _begin(self) -> None:
        self._definitions.clear()
        self._others.clear()
        self._line.begin()
        self._line.read_clock()
        self._line.follow(KeyKind.DEFINITIONS, self._defined)
        self._line.hear_refusals(self._refused)

    def _refused(self, why: str) -> None:
        self._report({"event": "refused", "robot": self._line.robot, "why": why})

    def _defined(self, payload: bytes) -> None:
        try:
            listed = read_definitions(payload)
        except HubError as error:
            self._faults.count("malformed document", f"{self._line.robot}: {error}")
            return
        for each in listed:
            if not isinstance(each, Define):
                self._define(each)
            elif len(self._others) < MOST_OTHERS:
                self._others.setdefault(each.name, each)

    def _define(self, definition: MessageDefinition[Any]) -> None:
        self._definitions.setdefault(definition.name, definition)
        if self._hub is not None:
            self._hub.define([definition])

    def _define_next(self) -> None:
        """Make one definition of those that are listed: others are not kept waiting."""
        for name, listing in self._others.items():
            if listing is not None:
                self._others[name] = None
                definition = definition_of(listing)
                if definition is not None:
                    self._define(definition)
                return

    def _look(self) -> None:
        """Measure the clock, and open or shut by the answers."""
        if not self._there:
            return
        if self._line.silence > LOST_S:
            self._shut("it does not answer")
            self._begin()
        self._line.read_clock()
        if (thin := self._line.choose_rate()) is not None:
            self._report({"event": "rate", "robot": self._line.robot, "thin": thin})
        if not self._definitions:  # the question, or the answer, may be lost
            self._line.follow(KeyKind.DEFINITIONS, self._defined)
        elif self._hub is not None and not self._hub.knows_all:
            self._line.follow(KeyKind.OPERATORS, self._know)

    def _follow(self) -> None:
        self._line.read_documents()
        self._define_next()
        if self._hub is not None:
            self._hub.follow()
            if self._hub.show():
                said = {"robot": self._line.robot, "endpoint": endpoint_in(self._place)}
                self._report({"event": "robot", **said})
        elif (
            self._there
            and self._definitions
            and self._line.knows_clock
            and self._loop.clock() >= self._next_open
        ):
            self._open()

    def _open(self) -> None:
        try:
            self._hub = LocalHub(self._line, self._definitions.values(), self._place, self._loop)
        except (HubError, OSError) as error:
            self._next_open = self._loop.clock() + _RETRY_S
            self._faults.count("robot that cannot be shown", f"{self._line.robot}: {error}")

    def _know(self, payload: bytes) -> None:
        try:
            numbers: Mapping[int, int] = read_operators(payload, str(self._line.operator))
        except HubError as error:
            self._faults.count("malformed document", f"{self._line.robot}: {error}")
            return
        if self._hub is not None:
            self._hub.know(numbers)

    def _shut(self, why: str) -> None:
        hub, self._hub = self._hub, None
        if hub is not None:
            hub.close()
            self._report({"event": "gone", "robot": self._line.robot, "why": why})
        self._line.end()
