"""The control of a link's robot: heartbeats, requests and refusals; used by the link's thread."""

from __future__ import annotations

import math
from collections.abc import Callable

from hub.errors import NoHandlerError, QueryError
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import (
    CONSOLE_HEARTBEAT,
    CONTROL_REFUSAL,
    CONTROL_REQUEST,
    HEARTBEAT_HZ,
    ConsoleHeartbeat,
    ControlAction,
    ControlRefusal,
    ControlRequest,
)
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.model.control import Standing, standing
from rune_tui.model.robot_state import RobotState

ATTENDED_S = 1.0
"""Time without a turn of the console after which its heartbeats end [s]."""
_ANSWER_S = 2.0


class ControlLine:
    """Sends heartbeats and requests for control, and reports refusals.

    Attributes:
        attended: Time of the console's last turn [s]; any thread may set it. The thread of a link
        goes on when the console hangs, but its heartbeat must not.
    """

    def __init__(
        self,
        client: Client,
        operator: str,
        state: Callable[[], RobotState],
        say: Callable[[str], None],
    ) -> None:
        """Begin.

        Args:
            client: The link's.
            operator: Operator of this console.
            state: State of the robot.
            say: Gets refusals in words.
        """
        self.attended = -math.inf
        self._client = client
        self._operator = operator
        self._state = state
        self._say = say
        client.define(CONSOLE_HEARTBEAT, CONTROL_REQUEST, COMMON_RESULT)
        client.subscribe(CONTROL_REFUSAL, self._refused)
        client.every(1.0 / HEARTBEAT_HZ, self._next_heartbeat)

    def want(self, action: ControlAction, *, by_driving: bool) -> None:
        """Ask the robot's hub for something; any thread may."""
        self._client.post(lambda: self._ask(action, by_driving=by_driving))

    def _ask(self, action: ControlAction, *, by_driving: bool) -> None:
        def answered(result: CommonResult, _reception: MessageInfo) -> None:
            if not result.done:
                self._say(result.text)

        def failed(error: QueryError) -> None:
            if isinstance(error, NoHandlerError):
                if not by_driving:
                    self._say("this robot's hub knows no control: everybody commands it")
            else:
                self._say(f"control: {error}")

        self._client.query_notify(
            CONTROL_REQUEST,
            ControlRequest(action=action, operator=self._operator),
            COMMON_RESULT,
            timeout=_ANSWER_S,
            answered=answered,
            failed=failed,
        )

    def _next_heartbeat(self) -> None:
        lives = self._client.loop.clock() - self.attended < ATTENDED_S
        if lives and self._client.connected:
            holds = standing(self._state()) is Standing.MINE
            self._client.publish(CONSOLE_HEARTBEAT, ConsoleHeartbeat(holds=int(holds)))

    def _refused(self, refusal: ControlRefusal, _reception: MessageInfo) -> None:
        if refusal.sender == self._client.number:
            what = refusal.message.removeprefix("GCM_").replace("_", " ").lower()
            self._say(f"{what} refused: {refusal.operator} has control")
