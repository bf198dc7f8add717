"""The recorder process: answers orders to record, and reports what is recorded.

| state | what is written |
| --- | --- |
| `[recording] always`, with `keep` | the ring |
| `[recording] always`, without | a recording, from the start |
| an order, or an earlier one before a crash | a recording, besides the ring |
| the extra `record` is not installed | nothing: reports and answers say so |
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from hub.errors import RecordingError
from hub.gcm.capability import Abilities, Capability
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.recording import (
    RECORD_COMMAND,
    RECORD_MARK,
    RECORD_STATE,
    RecordAction,
    RecordCommand,
    RecordMark,
    RecordState,
)
from hub.ipc.client import Client
from hub.robots.description import RobotDescription
from hub.runtime import publish_on_request, run_module

if TYPE_CHECKING:
    from hub.modules.recorder.recordings import Recordings

_logger = logging.getLogger(__name__)

_LOOK_S = 0.25
_STATE_S = 1.0 / RECORD_STATE.rate_hz
_INSTALL = (
    "nothing is recorded: a library is missing; install it on the robot with "
    "pip install 'robot-user-nexus[record]'"
)


class Recorder:
    """Connects the recordings with the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        """Begin or resume recordings, and answer orders."""
        self._client = client
        self._marks, self._mark = 0, ""
        self._recordings: Recordings | None = None
        try:
            from hub.modules.recorder.recordings import Recordings

            self._recordings = Recordings(client, robot)
        except ImportError as error:
            _logger.warning("%s (%s)", _INSTALL, error)
        client.define(RECORD_MARK, RECORD_STATE)
        client.respond(RECORD_COMMAND, COMMON_RESULT, self._requested)
        publish_on_request(client, RECORD_STATE, self._publish)
        client.every(_STATE_S, self._publish)
        if self._recordings is not None:
            client.every(_LOOK_S, self._recordings.look)

    def finish(self) -> None:
        """Complete all files."""
        if self._recordings is not None:
            self._recordings.close()
        self._publish()

    def _requested(self, command: RecordCommand) -> CommonResult:
        try:
            text = self._carry_out(command)
        except RecordingError as error:
            _logger.warning("%s", error)
            return CommonResult(done=0, text=str(error))
        _logger.info("%s", text)
        self._publish()
        return CommonResult(done=1, text=text)

    def _carry_out(self, command: RecordCommand) -> str:
        """Carry out an order; returns the result, for people.

        Raises:
            RecordingError: It cannot be done.
        """
        if self._recordings is None:
            raise RecordingError(_INSTALL)
        actions: dict[RecordAction, Callable[[Recordings, RecordCommand], str]] = {
            RecordAction.START: lambda on, order: on.start(order.name, order.by),
            RecordAction.STOP: lambda on, _: on.stop(),
            RecordAction.SPLIT: lambda on, _: on.split(),
            RecordAction.MARK: self._note_moment,
            RecordAction.SNAPSHOT: self._keep_snapshot,
        }
        return actions[command.action](self._recordings, command)

    def _note_moment(self, recordings: Recordings, command: RecordCommand) -> str:
        number, text = self._marks + 1, command.text
        mark = RecordMark(number=number, text=text, by=command.by, stamp=time.time())
        said = recordings.keep_mark(mark)
        self._marks, self._mark = number, text
        self._client.publish(RECORD_MARK, mark)
        return said

    def _keep_snapshot(self, recordings: Recordings, command: RecordCommand) -> str:
        text = recordings.keep_snapshot(command.name, command.before_s, command.after_s)
        self._note_moment(recordings, command)
        return text

    def _publish(self) -> None:
        if self._recordings is None:
            state = RecordState(fault=_INSTALL)
        else:
            state = self._recordings.state(self._marks, self._mark)
        self._client.publish(RECORD_STATE, state)


def abilities(_robot: RobotDescription) -> Abilities:
    """The abilities of the recorder on a robot."""
    return Abilities(provides=(Capability.REC_LOG,))


def main() -> int:
    """Run the process."""
    purpose = "Records what is published on the hub, always or on demand."
    return run_module(
        "recorder", purpose, abilities, lambda client, robot: Recorder(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
