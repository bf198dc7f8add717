"""The mission on the bus: orders to mark, begin and end, and the messages about it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from hub.bucket import Bucket
from hub.control_gate import ControlGate
from hub.errors import MissionError
from hub.gcm import mapping, mission
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import ControlState
from hub.gcm.mission import MissionAction
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import Reply
from hub.missions.keeper import MissionKeeper
from hub.robots.description import MissionBegin, RobotDescription
from hub.runtime import publish_on_request

_logger = logging.getLogger(__name__)

_POINTS_PERIOD = 1.0 / mapping.INTEREST_POINTS.rate_hz
_STATE_PERIOD = 1.0 / mission.MISSION_STATE.rate_hz
_ORDERS_PER_S, _ORDERS_AT_ONCE = 0.5, 20.0
"""Largest rate of orders to begin, name or end missions, and their largest burst [1/s]."""
_TOO_MANY = "too many orders to begin, name or end missions; wait some seconds and try again"


class MissionDesk:
    """Connects the keeper with the bus."""

    def __init__(
        self,
        client: Client,
        keeper: MissionKeeper,
        robot: RobotDescription,
        *,
        begun: Callable[[], None],
        marked: Callable[[mapping.InterestPoint], None],
        ending: Callable[[], None],
    ) -> None:
        """Subscribe and answer.

        Args:
            client: The module's connection.
            keeper: Keeps the mission; opened already.
            robot: The robot's description.
            begun: Called when another mission has begun after one that was ended.
            marked: Called with each point that was marked or changed.
            ending: Called before a mission ends.
        """
        self._client, self._keeper = client, keeper
        self._with_control = robot.mission_begin is MissionBegin.WITH_CONTROL
        self._begun, self._marked, self._ending = begun, marked, ending
        self._fault = ""
        self._orders = Bucket(_ORDERS_PER_S, _ORDERS_AT_ONCE)
        self._gate = ControlGate(client, self._on_owner_change)
        client.subscribe(mapping.POINT_COMMAND, self._point)
        client.respond_later(mission.MISSION_COMMAND, COMMON_RESULT, self._requested)
        client.define(mapping.INTEREST_POINTS, mapping.POINT_REFUSAL, mission.MISSION_STATE)
        publish_on_request(client, mapping.INTEREST_POINTS, self.publish_points)
        publish_on_request(client, mission.MISSION_STATE, self.publish_state)
        client.every(_POINTS_PERIOD, self.publish_points)
        client.every(_STATE_PERIOD, self._update)

    def publish_points(self) -> None:
        """Publish the points."""
        self._client.publish(mapping.INTEREST_POINTS, self._keeper.points)

    def publish_state(self) -> None:
        """Publish the state of the mission."""
        self._client.publish(mission.MISSION_STATE, self._keeper.state)

    def publish(self) -> None:
        """Publish both; the points come last, because they confirm marks."""
        self.publish_state()
        self.publish_points()

    def _point(self, command: mapping.PointCommand, reception: MessageInfo) -> None:
        point, by = command.point, f"client {reception.publisher}"
        ended = self._keeper.book.ended
        try:
            if command.action is mapping.PointAction.REMOVE:
                self._keeper.remove(point.number, point.version, by, reception.publisher)
            else:
                kept = self._keeper.mark(point, by, reception.publisher)
                if ended is not None and self._keeper.book.running:
                    self._begun()
                self._marked(kept)
        except MissionError as error:
            _logger.warning("point refused: %s", error)
            refusal = mapping.PointRefusal(
                sender=reception.publisher, number=point.number, text=str(error)
            )
            self._client.publish(mapping.POINT_REFUSAL, refusal)
            return
        self.publish()

    def _requested(self, command: mission.MissionCommand, reply: Reply[CommonResult]) -> None:
        if not self._gate.obeys(reply.asker):
            text = "somebody else has control of the robot; ask for control, or let them do it"
            reply.answer(CommonResult(done=0, text=text))
            return
        try:
            if not self._orders.take(1.0, time.monotonic()):
                raise MissionError(_TOO_MANY)
            text = self._carry_out(command)
        except MissionError as error:
            _logger.warning("%s", error)
            reply.answer(CommonResult(done=0, text=str(error)))
            return
        _logger.info("%s", text)
        reply.answer(CommonResult(done=1, text=text))
        self.publish()

    def _carry_out(self, command: mission.MissionCommand) -> str:
        keeper = self._keeper
        if command.action is MissionAction.BEGIN:
            self._begin(command.name, command.by)
            return f"mission {keeper.book.name} begins"
        if command.action is MissionAction.NAME:
            keeper.name(command.name, command.by)
            return f"the mission is named {keeper.book.name}"
        self._ending()
        name, count = keeper.book.name, len(keeper.book.points.points)
        where = keeper.path
        lost = keeper.end(command.by)
        if lost:
            return f"mission {name} is ended; {lost}"
        return f"mission {name} is ended; its {count} marks and its map are in {where}"

    def _begin(self, name: str, by: str) -> None:
        """Begin a mission; it keeps the present map, unless that belongs to an ended mission."""
        ended = self._keeper.book.ended
        self._keeper.begin(name, by)
        if ended is not None:
            self._begun()

    def _on_owner_change(self, state: ControlState, before: int) -> None:
        """Another client has control than before."""
        if not state.owner:
            return
        keeper = self._keeper
        if keeper.book.running:
            keeper.note(f"{state.operator} has control")
        elif self._with_control and not before:
            self._begin("", state.operator)
            _logger.info("mission %s begins: %s has control", keeper.book.name, state.operator)
        self.publish()

    def _update(self) -> None:
        """Retry failed writes, and publish the state of the mission if it changed."""
        before = self._keeper.unkept
        self._keeper.look()
        if self._keeper.fault != self._fault:
            self._fault = self._keeper.fault
            _logger.warning("%s", self._fault or "all of the mission is kept again")
        self.publish_state()
        if self._keeper.unkept != before:
            self.publish_points()
