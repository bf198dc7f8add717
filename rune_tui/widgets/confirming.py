"""Marks, changes and removals on the way to a robot: sent again until the robot confirms them.

| report of the robot | action |
| --- | --- |
| it has the command, on its disk | confirm it, and report that to the operator |
| it has it in memory only, for ANSWER_S | an alarm; wait |
| it refuses it | drop it; the link has reported the reason |
| its map has another sheet | an alarm: the place is not valid any more; drop it |
| none for AGAIN_S | send it again, while there is a link |
| none for ANSWER_S | an alarm, once; go on to send it |
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator

from hub.gcm.mapping import (
    INTEREST_POINTS,
    POINT_COMMAND,
    POINT_REFUSAL,
    InterestPoint,
    PointAction,
    PointCommand,
)
from hub.gcm.mission import MISSION_STATE
from hub.values import dataclass
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, MarksWaiting, Notify, SendEffect
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.world import WorldPoint

ANSWER_S = 3.0
"""Time without a confirmation after which there is an alarm [s]."""
AGAIN_S = 1.0
"""Period of repeats until the confirmation [s]."""
USES = (INTEREST_POINTS.name, POINT_REFUSAL.name, MISSION_STATE.name)
"""Messages with the outcome of a command."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Waiting:
    """A command that is not confirmed.

    Attributes:
        robot: The robot.
        command: The command.
        after: The highest number of a point at that time; a new point gets a higher one.
        sheet: Its sheet of the map; 0: not known.
        since: Time of the command [s].
        sent: Time at which it was last sent [s].
        alarmed: Whether the operator got an alarm that it is not confirmed.
    """

    robot: str
    command: PointCommand
    after: int
    sheet: int
    since: float
    sent: float
    alarmed: bool = False


class Confirming:
    """The commands of one widget that are not confirmed."""

    def __init__(self, words: Callable[[PointCommand, InterestPoint | None], str]) -> None:
        """Start without commands.

        Args:
            words: Gives the report of a confirmation to the operator.
        """
        self._words = words
        self._waiting: list[_Waiting] = []
        self._reported: dict[str, tuple[int, int]] = {}

    def send(
        self, command: PointCommand, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Send a command, and wait for its confirmation."""
        points = points_of(robot)
        self._waiting.append(
            _Waiting(
                robot=robot.name,
                command=command,
                after=max((known.number for known in points), default=0),
                sheet=_sheet(robot),
                since=state.now,
                sent=state.now,
            )
        )
        return (_effect(robot.name, command),)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Results of the commands, and the commands to send again."""
        before, self._waiting = self._waiting, []
        effects = [effect for waiting in before for effect in self._look(waiting, state)]
        return (*effects, *self._counts())

    def _counts(self) -> Iterator[MarksWaiting]:
        """How many wait for each robot, where that has changed."""
        for name in {waiting.robot for waiting in self._waiting} | self._reported.keys():
            alarmed = [waiting.alarmed for waiting in self._waiting if waiting.robot == name]
            now = len(alarmed), sum(alarmed)
            if now != self._reported.get(name, (0, 0)):
                yield MarksWaiting(source=id(self), robot=name, count=now[0], overdue=now[1])
            self._reported[name] = now

    def _look(self, waiting: _Waiting, state: ConsoleState) -> Iterator[Effect]:
        robot = state.robot(waiting.robot)
        if robot is None:
            return
        what = _name(waiting.command)
        confirmed, point = _outcome(waiting, robot)
        if confirmed:
            text = self._words(waiting.command, point)
            yield Notify.now(state, text, robot=waiting.robot)
            return
        if _refused(waiting, robot):
            return
        sheet = _sheet(robot)
        if waiting.sheet and sheet and sheet != waiting.sheet:
            text = f"{what} is LOST: the robot began sheet {sheet} of its map before it had it"
            yield Notify.now(state, text, robot=waiting.robot, alarm=True)
            return
        late = state.now - waiting.since >= ANSWER_S
        if late and not waiting.alarmed:
            waiting = dataclasses.replace(waiting, alarmed=True)
            yield Notify.now(state, _lateness(what, point, robot), robot=waiting.robot, alarm=True)
        linked = robot.link.phase is LinkPhase.CONNECTED
        if point is None and linked and state.now - waiting.sent >= AGAIN_S:
            waiting = dataclasses.replace(waiting, sent=state.now)
            yield _effect(waiting.robot, waiting.command)
        self._waiting.append(waiting)


def points_of(robot: RobotState) -> tuple[InterestPoint, ...]:
    """The marks on a robot's map, as known here."""
    newest = robot.newest(INTEREST_POINTS)
    return newest.value.points if newest is not None else ()


def _outcome(waiting: _Waiting, robot: RobotState) -> tuple[bool, InterestPoint | None]:
    """Whether a command is confirmed, and the robot's point since then."""
    command, wanted = waiting.command, waiting.command.point
    newest = robot.newest(INTEREST_POINTS)
    if newest is None or (wanted.number and newest.measured < waiting.since):
        return False, None
    for point in newest.value.points:
        if wanted.number == 0:
            same = (point.kind, point.x, point.y) == (wanted.kind, wanted.x, wanted.y)
            if same and point.number > waiting.after:
                return bool(point.kept), point
        elif point.number == wanted.number:
            if command.action is PointAction.REMOVE or point.version <= wanted.version:
                return False, None
            return bool(point.kept), point
    return wanted.number != 0, None


def _refused(waiting: _Waiting, robot: RobotState) -> bool:
    newest = robot.newest(POINT_REFUSAL)
    if newest is None or newest.measured < waiting.since:
        return False
    own = newest.value.sender == robot.link.number
    return own and newest.value.number == waiting.command.point.number


def _lateness(what: str, point: InterestPoint | None, robot: RobotState) -> str:
    if point is not None:
        newest = robot.newest(MISSION_STATE)
        fault = newest.value.fault if newest is not None else ""
        return f"{what} is in the robot's memory only{': ' if fault else ''}{fault}"
    return f"{what} is NOT KEPT: the robot has not confirmed it; it is sent again until it does"


def _sheet(robot: RobotState) -> int:
    newest = robot.newest(MISSION_STATE)
    return newest.value.sheet if newest is not None else 0


def _name(command: PointCommand) -> str:
    point = command.point
    kind = point.kind.name.lower()
    if command.action is PointAction.REMOVE:
        return f"the removal of {kind} {point.number}"
    if point.number:
        return f"the change of {kind} {point.number}"
    return f"the {kind} at {point.x:.1f}, {point.y:.1f} m"


def _effect(robot: str, command: PointCommand) -> SendEffect:
    return SendEffect(robot=robot, definition=POINT_COMMAND, value=command)


def nearest_mark(
    place: WorldPoint,
    robot: RobotState,
    radius: float,
    counts: Callable[[InterestPoint], bool] = lambda _: True,
) -> InterestPoint | None:
    """The nearest mark that counts; None if all are farther away than the radius [m]."""

    def distance(point: InterestPoint) -> float:
        return math.hypot(point.x - place.x, point.y - place.y)

    near = [p for p in points_of(robot) if counts(p) and distance(p) <= radius]
    return min(near, key=distance, default=None)
