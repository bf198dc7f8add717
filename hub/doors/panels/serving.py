"""A door's process: what it asks the hub, how it opens, and when it ends."""

from __future__ import annotations

import argparse
import contextlib
import signal
from collections.abc import Callable
from typing import Final

from hub.command_output import stdin_ended
from hub.doors.panels.hub_topics import PictureWishes
from hub.doors.panels.panel_door import PanelDoor
from hub.doors.panels.wishes import SenderKind, TopicServer
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


def serve(
    client: Client,
    options: argparse.Namespace,
    open_server: Callable[[Callable[[], None]], TopicServer],
    *,
    sender: SenderKind,
    announce: Callable[[], None],
) -> None:
    """Open a door, and serve until a signal, or the end of standard input.

    Args:
        client: A connected client for this alone.
        options: Those that all doors have.
        open_server: Opens the server; it calls its argument when panels want something else.
        sender: What drives, if the options allow it.
        announce: Says that the door is open.
    """
    width_px, height_px = options.size
    door = PanelDoor(
        client,
        open_server,
        PictureWishes(rate=options.pictures, width_px=width_px, height_px=height_px),
        sender=sender if options.drive else None,
        keys=options.keys,
    )
    with contextlib.closing(door):
        announce()
        _listen(door, stop_with_stdin=options.stop_with_stdin)


def _listen(door: PanelDoor, *, stop_with_stdin: bool) -> None:
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
