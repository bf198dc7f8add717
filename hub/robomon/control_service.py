"""The control lease on the bus: requests to the arbiter, and reports to all."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import numpy as np

from hub.gcm import control, pad
from hub.gcm.autonomy import DrivingMode
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import ControlAction, ControlRequest
from hub.gcm.navigation import NAVIGATION_STATUS, NavigationStatus, Task
from hub.gcm.supervision import MODULE_INFO, ModuleInfo, is_console
from hub.ipc.broker.peers import Peer
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import Reply
from hub.ipc.roles import Action, Role, may
from hub.ipc.wire.control import Change, Presence
from hub.robomon.control_lease import Answer, ControlLease
from hub.runtime import publish_on_request

_logger = logging.getLogger(__name__)

_CHECK_S = 0.1
_FRESH_S = 4.0 / NAVIGATION_STATUS.rate_hz
"""Silence after which navigation counts as inactive [s]."""
_NOT_ALLOWED = (
    False,
    "to take control from others needs a key made with --role supervise, or a console on the robot",
)


class ControlService:
    """Connects the arbiter with the bus, for the life of the hub."""

    def __init__(self, client: Client, peer_of: Callable[[int], Peer | None]) -> None:
        """Start without an owner.

        Args:
            client: The daemon's connection.
            peer_of: The peer of a number at central; None: it is gone.
        """
        self._client = client
        self._peer_of = peer_of
        self._clock = time.monotonic
        self._arbiter = ControlLease(self._clock())
        self._modules: set[int] = set()
        self._status: tuple[NavigationStatus, float] | None = None
        self._published: tuple[object, ...] = ()
        self._why = self._arbiter.why
        # A key to operate may use messages, but define none.
        client.define(control.CONTROL_STATE, *pad.MESSAGES)
        client.subscribe(control.CONSOLE_HEARTBEAT, self._on_heartbeat)
        client.subscribe(MODULE_INFO, self.announced)
        client.subscribe(NAVIGATION_STATUS, self._navigation)
        client.respond_later(control.CONTROL_REQUEST, COMMON_RESULT, self._requested)
        client.directory.watch(self._presence)
        publish_on_request(client, control.CONTROL_STATE, self._publish)
        client.every(_CHECK_S, self._check)
        client.every(1.0 / control.CONTROL_STATE.rate_hz, self._publish)

    @property
    def owned(self) -> bool:
        """Whether a console has control."""
        return self._arbiter.owner is not None

    def _requested(self, request: ControlRequest, reply: Reply[CommonResult]) -> None:
        peer = self._peer_of(reply.asker)
        if peer is None:
            reply.fail("the hub does not know who asks; connect anew")
            return
        done, text = self._answer(request, peer)
        reply.answer(CommonResult(done=int(done), text=text))
        self._check()

    def _answer(self, request: ControlRequest, peer: Peer) -> Answer:
        arbiter, now = self._arbiter, self._clock()
        number, operator = peer.publisher, request.operator or peer.name
        match request.action:
            case ControlAction.TAKE:
                return arbiter.take(number, operator, now)
            case ControlAction.RELEASE:
                return arbiter.release(number, now)
            case ControlAction.ASK:
                return arbiter.ask(number, operator, now)
            case ControlAction.GRANT:
                return arbiter.grant(number, now)
            case ControlAction.DENY:
                return arbiter.deny(number, now)
        if not may(peer.principal.role, Action.TAKE_OVER):
            return _NOT_ALLOWED
        if request.action is ControlAction.FREE:
            return arbiter.free(now)
        return arbiter.take_over(number, operator, now)

    def _on_heartbeat(self, heartbeat: control.ConsoleHeartbeat, reception: MessageInfo) -> None:
        holds = bool(heartbeat.holds)
        self._arbiter.heartbeat(reception.publisher, self._clock(), holds=holds)

    def announced(self, info: ModuleInfo, reception: MessageInfo) -> None:
        """Note a sender of MODULE_INFO as a module, if it is one of this robot."""
        peer = self._peer_of(reception.publisher)
        if peer is None or peer.principal.role is not Role.MODULE:
            return  # an operator is no module, even with a module's INFO
        if is_console(info.capabilities.split()):
            return  # a module passes the control gate; a console must not
        if reception.publisher not in self._modules:
            self._modules.add(reception.publisher)
            self._check()

    def _navigation(self, status: NavigationStatus, reception: MessageInfo) -> None:
        self._status = status, reception.measured
        self._check()

    def _presence(self, presence: Presence) -> None:
        if presence.change is Change.DISCONNECTED:
            self._check()

    def _check(self) -> None:
        """Apply disconnects and limits of time, and publish a change."""
        now, arbiter = self._clock(), self._arbiter
        arbiter.expire(now)
        concerned = [console.number for console in arbiter.requests]
        concerned += [arbiter.owner.number] if arbiter.owner else []
        for number in concerned:
            if self._peer_of(number) is None:
                arbiter.disconnected(number, now)
        state = self.state()
        content = (
            state.owner,
            state.asker,
            state.waiting,
            state.why,
            state.commander,
            state.commander_name,
            state.silent_s >= control.WARNED_S,
            tuple(state.modules),
        )
        if content != self._published:
            self._published = content
            self._client.publish(control.CONTROL_STATE, state)
        if arbiter.why != self._why:
            self._why = arbiter.why
            _logger.info("control: %s", arbiter.why)

    def _publish(self) -> None:
        self._modules = {number for number in self._modules if self._peer_of(number)}
        self._client.publish(control.CONTROL_STATE, self.state())

    def state(self) -> control.ControlState:
        """The owner of control, and the requests for it."""
        now, arbiter = self._clock(), self._arbiter
        owner, requests = arbiter.owner, arbiter.requests
        asker = requests[0] if requests else None
        commander, name = self._commander()
        return control.ControlState(
            owner=owner.number if owner else 0,
            owner_name=self._name(owner.number) if owner else "",
            operator=owner.operator if owner else "",
            held_s=now - owner.since if owner else 0.0,
            silent_s=max(0.0, now - owner.last_heard) if owner else 0.0,
            asker=asker.number if asker else 0,
            asker_name=self._name(asker.number) if asker else "",
            asker_operator=asker.operator if asker else "",
            left_s=max(0.0, arbiter.left(now)),
            waiting=max(0, len(requests) - 1),
            commander=commander,
            commander_name=name,
            why=arbiter.why,
            modules=np.array(sorted(self._modules), np.uint32),
        )

    def _commander(self) -> tuple[DrivingMode, str]:
        """The console that moves the robot now, by navigation's report."""
        if self._status is None or self._clock() - self._status[1] > _FRESH_S:
            return DrivingMode.NOBODY, ""
        status = self._status[0]
        if status.driver:
            return DrivingMode.OPERATOR, self._operator(status.driver)
        if status.task not in (Task.GOING, Task.TURNING):
            return DrivingMode.NOBODY, ""
        if status.sender in self._modules:
            return DrivingMode.AUTONOMY, self._name(status.sender)
        return DrivingMode.OPERATOR, self._operator(status.sender)

    def _operator(self, number: int) -> str:
        owner = self._arbiter.owner
        return owner.operator if owner and owner.number == number else self._name(number)

    def _name(self, number: int) -> str:
        peer = self._peer_of(number)
        return peer.name if peer else "somebody who has left"
