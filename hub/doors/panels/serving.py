"""A door's process: what it asks the hub at its start, and when it ends."""

from __future__ import annotations

import contextlib
import signal
from typing import Final

from hub.command_output import stdin_ended
from hub.doors.panels.panel_door import PanelDoor
from hub.errors import QueryError
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.ipc.client import Client

_ANSWER_S: Final = 2.0
_LISTEN_S: Final = 0.2
_ENDS: Final = (signal.SIGINT, signal.SIGTERM)


def body_of(client: Client) -> RobotBody | None:
    """The robot of the hub; None: it has not said it yet."""
    with contextlib.suppress(QueryError):
        return client.last_value(ROBOT_DESCRIPTION, timeout=_ANSWER_S)
    return None


def serve(door: PanelDoor, *, stop_with_stdin: bool) -> None:
    """Serve until a signal, or the end of standard input."""
    ending = False

    def end(*_: object) -> None:
        nonlocal ending
        ending = True

    before = {each: signal.signal(each, end) for each in _ENDS}
    try:
        while not ending:
            door.listen(_LISTEN_S)
            if stop_with_stdin and stdin_ended():
                ending = True
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
