"""The line's side of a robot's own navigation: goals of Nav2 or move_base, over any `RosLine`."""

from __future__ import annotations

import contextlib
import math
import socket
import zlib
from collections.abc import Iterator
from typing import Final

from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.own_navigation import OwnGoal, OwnNavigation
from hub.plain_text import counted, plain
from hub.robots.ros.commands import CDR, ROS1
from hub.robots.ros.goals.goal_actions import GoalAction, GoalEnds, action_of, missing_action
from hub.robots.ros.goals.goal_keeper import ANSWER_S, CANCEL_AGAIN_S, GoalKeeper
from hub.robots.ros.line import Payload, RosGraph, RosLine, RosMessage
from hub.robots.ros.topic_reader import UNFIT
from hub.robots.ros.whereabouts import PATIENCE_S
from hub.ros import goal_messages as wire
from hub.ros.goal_messages import GoalPlace
from hub.values import dataclass

_QUIET_S: Final = 1.0
"""Age of the last message about a goal from which on it is said [s]."""
_OLD_LIST_S: Final = 3.0
"""Age from which on the list of ROS 1, which comes 5 times a second, is not shown [s]."""


def goal_tag(robot: str, identity: str) -> str:
    """First digits of the names of a hub's goals: equal for each process of this hub."""
    number = zlib.crc32(f"{socket.gethostname()} {robot} {identity}".encode())
    return b"rune".hex() + f"{number:08x}"


class OwnGoals:
    """The goals of one hub at one robot; without the name of an action it has none."""

    def __init__(self, line: RosLine, name: str, tag: str) -> None:
        """Listen to the action.

        Args:
            line: The line to the robot.
            name: Name of the action, such as "/navigate_to_pose"; empty: none.
            tag: See `GoalKeeper`.
        """
        self._line, self._name = line, name
        self._port = _LinePort(line=line, name=name)
        self._keeper = self._port.keeper = GoalKeeper(self._port, tag)
        self._connections = 0
        self._up_since = math.inf
        self._now = self._listed_at = -math.inf
        self._fault = ""
        self._graph: RosGraph | None = None
        if name:
            for ends in (GoalEnds.of(name, old=False), GoalEnds.of(name, old=True)):
                line.subscribe(ends.status, self._take)
                line.subscribe(ends.feedback, self._take)

    @property
    def drives(self) -> bool:
        """Whether the robot may drive to a goal of this hub, so that no velocity is sent."""
        return self._keeper.drives

    def settled(self, now: float) -> bool:
        """Whether velocities may follow a cancelled goal [s, monotonic]."""
        return self._keeper.settled(now)

    def go(self, number: int, place: GoalPlace, now: float) -> None:
        """Drive to a place; a number that is known changes nothing."""
        self._keeper.go(number, place, now)

    def end(self, now: float) -> None:
        """Drive there no more."""
        self._keeper.end(now)

    def stop(self, now: float) -> None:
        """End every goal, also of other nodes."""
        self._keeper.stop(now)

    def advance(self, now: float) -> None:
        """Look at the line, and send what is due [s, monotonic]."""
        if not self._name:
            return
        self._now = self._port.now = now
        state = self._line.state
        if not state.up or state.connections != self._connections:
            self._connections = state.connections
            self._up_since = now if state.up else math.inf
            self._port.find(None)
            self._graph = None
            self._keeper.reach(now, ready=False)
        if state.up:
            graph = self._line.graph
            if graph is not self._graph:
                self._graph = graph
                self._port.find(action_of(graph, self._name))
            self._keeper.reach(now, ready=self._port.ready)
        self._keeper.advance(now)

    def report(self, now: float) -> OwnNavigation:
        """The state of the robot's own navigation [s, monotonic]."""
        keeper = self._keeper
        return OwnNavigation(
            available=int(self._port.ready),
            number=keeper.number,
            goal=keeper.state,
            distance_left=keeper.left,
            heard_s=keeper.heard_s(now),
            others=len(keeper.others) if self._is_fresh(now) else 0,
            ending=int(keeper.ending),
            unanswered=int(keeper.unanswered(now)),
            why=keeper.why,
        )

    def problems(self, now: float) -> Iterator[DiagnosticStatus]:
        """What the operator has to know."""
        keeper, name = self._keeper, self._name
        if keeper.unanswered(now):
            away = "" if self._port.ready else ", and its own navigation cannot be reached"
            text = f"the end of a goal is not acknowledged: the robot may still drive to it{away}"
            yield _problem(text, Severity.ERROR)
        if not name or not self._line.state.up:
            return
        if not self._port.ready and now - self._up_since >= PATIENCE_S:
            why = missing_action(self._line.graph, name)
            yield _problem(f"{why}; goals go to Rune's own navigation", Severity.WARN)
        if self._fault:
            yield _problem(f"messages of {name} cannot be used: {self._fault}", Severity.WARN)
        if keeper.state is OwnGoal.DRIVES and (quiet := keeper.heard_s(now)) >= _QUIET_S:
            yield _problem(f"{name} was silent for {quiet:.0f} s about its goal", Severity.WARN)
        if self._port.ready and not self._is_fresh(now):
            yield _problem(f"{name} is silent: its goals are not known", Severity.WARN)
        elif others := keeper.others:
            text = f"another node sent the robot to {counted(len(others), 'goal')} by {name}"
            yield _problem(f"{text}: it drives by itself; a stop ends that too", Severity.WARN)

    def _is_fresh(self, now: float) -> bool:
        """Whether the list of goals is as it is now; in ROS 2 it comes at changes only."""
        action = self._port.action
        old = action is not None and action.ends.old
        return not old or now - max(self._listed_at, self._up_since) < _OLD_LIST_S

    def _take(self, message: RosMessage) -> None:
        """Take a message of states, or of feedback."""
        name = message.topic.name
        encoding = ROS1 if message.topic.encoding == ROS1 else CDR
        try:
            if name.endswith("status"):
                self._listed_at = message.arrived
                self._keeper.listed(wire.known_goals(message.payload, encoding), message.arrived)
            else:
                self._keeper.moved(*wire.feedback_of(message.payload, encoding), message.arrived)
        except UNFIT as error:
            self._fault = plain(str(error))[:200]
        else:
            self._fault = ""


@dataclass(slots=True, kw_only=True, eq=False)
class _LinePort:
    """Implements `GoalPort`."""

    line: RosLine
    name: str
    keeper: GoalKeeper | None = None
    action: GoalAction | None = None
    now: float = -math.inf
    _advertised: bool = False
    _asks: bool = False

    @property
    def ready(self) -> bool:
        """Whether goals and cancels can leave."""
        if self.action is None:
            return False
        ends = self.action.ends
        return not ends.old or bool(self.line.encoding(ends.goal))

    def find(self, action: GoalAction | None) -> None:
        """Take what the robot has now; None: the line is away."""
        self.action = action
        if action is not None and action.ends.old and not self._advertised:
            self._advertised = True
            self.line.advertise(action.ends.goal, wire.OLD_GOAL)
            self.line.advertise(action.ends.cancel, wire.OLD_CANCEL)

    def send(self, name: str, place: GoalPlace) -> bool:
        """Send a goal; returns whether it left."""
        if self.action is None:
            return False
        ends = self.action.ends
        if ends.old:
            return self.line.publish(ends.goal, wire.old_goal(name, place))

        def answered(payload: Payload | None, why: str) -> None:
            self._sent(name, payload, why)

        self.line.call(ends.goal, wire.send_request(name, place), answered, ANSWER_S)
        return True

    def cancel(self, name: str) -> bool:
        """Cancel a goal, or all; returns whether that left."""
        if self.action is None:
            return False
        ends = self.action.ends
        if ends.old:
            return self.line.publish(ends.cancel, wire.old_cancel(name))

        def answered(payload: Payload | None, _why: str) -> None:
            # An answer that cannot be read is none: the cancel is repeated.
            with contextlib.suppress(*UNFIT):
                if payload is not None and self.keeper is not None:
                    self.keeper.cancelled(name, wire.cancel_answer(payload))

        self.line.call(ends.cancel, wire.cancel_request(name), answered, CANCEL_AGAIN_S)
        return True

    def explain(self, name: str) -> bool:
        """Ask why a goal was aborted; returns whether that left, or cannot be asked."""
        if self.action is None or not self.action.explains:
            return True
        if self._asks:
            return False  # one question at a time, so that no other call lacks room

        def answered(payload: Payload | None, _why: str) -> None:
            self._asks = False
            # Nav2 of Humble gives no reason: its answer is too short.
            with contextlib.suppress(*UNFIT):
                if payload is not None and self.keeper is not None:
                    self.keeper.explained(name, wire.failure_of(payload))

        self._asks = True
        self.line.call(self.action.ends.result, wire.result_request(name), answered, ANSWER_S)
        return True

    def _sent(self, name: str, payload: Payload | None, why: str) -> None:
        keeper = self.keeper
        if keeper is None:
            return
        try:
            accepted = payload is not None and wire.was_accepted(payload)
        except UNFIT as error:
            payload, accepted, why = None, False, str(error)
        if accepted:
            keeper.taken(name, self.now)
        elif payload is not None:
            keeper.refused(name)
        else:
            keeper.failed(name, plain(why)[:200], self.now)


def _problem(text: str, level: Severity) -> DiagnosticStatus:
    return DiagnosticStatus(level=level, name="own navigation", message=text)
