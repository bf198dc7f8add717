"""Orders to a robot's own recorder; used by the link's thread."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from hub.errors import NoHandlerError, QueryError
from hub.gcm.capability import Capability
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.recording import RECORD_COMMAND, RecordAction, RecordCommand
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.link.wants_line import WantsLine

_ANSWER_S = 5.0
_AGAIN_S = 0.5
"""Time between two tries while the recorder starts [s]."""
START_S = 15.0
"""Longest time for the recorder to start [s]."""


class RecordLine:
    """Sends orders, and reports refusals."""

    def __init__(
        self,
        client: Client,
        operator: str,
        wants: WantsLine,
        say: Callable[[str], None],
    ) -> None:
        """Begin.

        Args:
            client: The link's.
            operator: Operator of this console.
            wants: The link's; an order to record starts the recorder.
            say: Gets refusals in words.
        """
        self._client, self._operator = client, operator
        self._wants, self._say, self._clock = wants, say, client.loop.clock
        client.define(RECORD_COMMAND, COMMON_RESULT)

    def order(self, command: RecordCommand) -> None:
        """Order something; any thread may. It is lost while there is no connection."""
        whole = dataclasses.replace(command, by=self._operator[:64])
        self._client.post(lambda: self._begin(whole))

    def _begin(self, command: RecordCommand) -> None:
        if not self._client.connected:
            return
        if command.action is RecordAction.START:
            self._wants.want_also(Capability.REC_LOG, START_S)
        self._ask(command, self._clock() + START_S)

    def _ask(self, command: RecordCommand, until: float) -> None:
        def answered(result: CommonResult, _reception: MessageInfo) -> None:
            if not result.done:
                self._say(f"recording: {result.text}")

        def failed(error: QueryError) -> None:
            if not isinstance(error, NoHandlerError):
                self._say(f"recording: {error}")
            elif command.action is RecordAction.START and self._clock() < until:
                self._client.loop.after(_AGAIN_S, lambda: self._ask(command, until))
            else:
                self._say("no recording: the robot's recorder does not run")

        self._client.query_notify(
            RECORD_COMMAND,
            command,
            COMMON_RESULT,
            timeout=_ANSWER_S,
            answered=answered,
            failed=failed,
        )
