"""Sends velocities over a line, as messages of the type that the robot takes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.geometry import Twist
from hub.plain_text import plain
from hub.robots.ros.command_stream import CommandStream
from hub.robots.ros.commands import TYPES, velocity_payload
from hub.robots.ros.goals.goal_actions import driving_nodes
from hub.robots.ros.line import RosLine
from hub.robots.ros.own_nodes import rivals
from hub.robots.ros.whereabouts import PATIENCE_S
from hub.robots.ros_table import CommandType, RosTable

_MOST_NAMED: Final = 3
_STUCK_S: Final = 0.3
_BLOCKED_S: Final = 1.0
"""Times in which no velocity can leave [s]: then a zero has to come first; then what waits on the
line is dropped with it, since it would arrive late."""


class RosVelocities:
    """The velocities to one robot.

    Attributes:
        stream: Which are sent, and when.
    """

    def __init__(self, line: RosLine, table: RosTable) -> None:
        self.stream = CommandStream(hold=table.hold)
        self._line, self._table = line, table
        self._kind: CommandType | None = None
        self._connections = 0
        self._up_since = math.inf
        self._stuck_since = math.inf
        self._stopped_behind = False  # whether a zero waits behind what a stuck line holds

    def advance(self, now: float) -> None:
        """Look at the line, and send what is due [s, monotonic]."""
        state = self._line.state
        if not state.up or state.connections != self._connections:
            self._connections = state.connections
            self._stuck_since = math.inf
            self._up_since = now if state.up else math.inf
            self.stream.interrupt(now)
        if state.up:
            self._advertise(now)
            self.send(now)

    def send(self, now: float) -> None:
        """Send the velocity that is due, if one is [s, monotonic]."""
        velocity = self.stream.take(now)
        if velocity is None or self._kind is None or not self._line.state.up:
            return
        encoding = self._line.encoding(self._table.cmd_vel)
        if encoding:
            payload = velocity_payload(velocity, self._kind, encoding)
            if self._line.publish(self._table.cmd_vel, payload):
                self.stream.sent(now)
                self._stuck_since, self._stopped_behind = math.inf, False
                return
            self._stuck_since = min(self._stuck_since, now)
            if now - self._stuck_since > _STUCK_S:
                self.stream.interrupt(now)
            if self.stream.wanted.neutral and not self._stopped_behind:
                self._stop_behind(self._kind, encoding)
            if now - self._stuck_since > _BLOCKED_S:
                self._stuck_since = math.inf
                self._line.reconnect("velocities did not reach the robot")

    def _stop_behind(self, kind: CommandType, encoding: str) -> None:
        """Have a zero follow the velocities that the line holds: they arrive late, it with them."""
        zero = velocity_payload(self.stream.wanted, kind, encoding)
        self._stopped_behind = self._line.publish(self._table.cmd_vel, zero, late=True)

    def problems(self, now: float) -> Iterator[str]:
        """Why the robot may not follow, a sentence each."""
        name = self._table.cmd_vel
        topic = self._line.graph.topics.get(name)
        if now - self._stuck_since > _STUCK_S:
            yield "velocities do not reach the robot: the line to it is blocked"
        if now - self._up_since < PATIENCE_S:
            return
        if topic is None:
            if self._line.graph.whole or self._kind is None:
                yield f"nothing on the robot subscribes to {name}: see [ros], key 'cmd_vel'"
            return
        if self._kind is None and not topic.schema_name:
            yield f"the type of velocities on {name} is not known: set [ros], key 'cmd_vel_type'"
        elif self._kind is None:
            text = f"velocities on {name} are {plain(topic.schema_name)[:80]}"
            yield f"{text}, which is no Twist: see [ros], keys 'cmd_vel' and 'cmd_vel_type'"
        if self._line.graph.whole:
            if not topic.subscribers:
                yield f"no node of the robot subscribes to {name}: it does not follow"
            own = driving_nodes(self._line.graph, self._table.navigation)
            if others := [each for each in rivals(topic.publishers) if each not in own]:
                named = plain(", ".join(others[:_MOST_NAMED]))[:200]
                yield f"{named} may drive too, on {name}: the robot follows the newest"

    def _advertise(self, now: float) -> None:
        kind = self._found()
        if kind is self._kind:
            return
        if self._kind is not None:
            self._line.unadvertise(self._table.cmd_vel)
            self.stream.interrupt(now)
        self._kind = kind
        if kind is not None:
            self._line.advertise(self._table.cmd_vel, TYPES[kind])

    def _found(self) -> CommandType | None:
        """The type of velocities; None: not known, or none that can be sent."""
        if self._table.cmd_vel_type is not CommandType.AUTO:
            return self._table.cmd_vel_type
        graph = self._line.graph
        topic = graph.topics.get(self._table.cmd_vel)
        if topic is None and self._kind is not None:
            return self._kind  # what was known stays so after a loss
        if topic is not None and topic.schema_name:
            return next((each for each, name in TYPES.items() if name == topic.schema_name), None)
        # A bridge for ROS 1 knows the types of published topics only; nodes ignore a wrong type.
        may_take = topic is not None or not graph.whole
        return CommandType.TWIST if graph.version == 1 and may_take else None

    @property
    def wanted(self) -> Twist:
        """The velocity that the robot has to follow."""
        return self.stream.wanted
