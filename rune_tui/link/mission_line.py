"""The mission of a link's robot: orders and refusals; used by the link's thread."""

from __future__ import annotations

from collections.abc import Callable

from hub.errors import NoHandlerError, QueryError
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.mapping import POINT_REFUSAL, PointRefusal
from hub.gcm.mission import MISSION_COMMAND, MissionAction, MissionCommand
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo

_ANSWER_S = 5.0
"""The robot may wait for its disk [s]."""


class MissionLine:
    """Sends orders to start, name or end the mission, and reports refused marks."""

    def __init__(self, client: Client, operator: str, say: Callable[[str], None]) -> None:
        """Begin.

        Args:
            client: The link's.
            operator: Operator of this console.
            say: Gets refusals in words.
        """
        self._client, self._operator, self._say = client, operator, say
        client.define(MISSION_COMMAND, COMMON_RESULT)
        client.subscribe(POINT_REFUSAL, self._refused)

    def want(self, action: MissionAction, name: str) -> None:
        """Ask the robot for something; any thread may."""
        self._client.post(lambda: self._ask(action, name))

    def _ask(self, action: MissionAction, name: str) -> None:
        def answered(result: CommonResult, _reception: MessageInfo) -> None:
            if not result.done:
                self._say(f"mission: {result.text}")

        def failed(error: QueryError) -> None:
            if isinstance(error, NoHandlerError):
                self._say("no mission: the robot's mapping, which keeps it, does not run")
            else:
                self._say(f"mission: {error}")

        self._client.query_notify(
            MISSION_COMMAND,
            MissionCommand(action=action, name=name, by=self._operator),
            COMMON_RESULT,
            timeout=_ANSWER_S,
            answered=answered,
            failed=failed,
        )

    def _refused(self, refusal: PointRefusal, _reception: MessageInfo) -> None:
        if refusal.sender == self._client.number:
            self._say(f"mark refused: {refusal.text}")
