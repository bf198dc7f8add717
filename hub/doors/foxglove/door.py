"""`rune-hub serve foxglove`: from start to end."""

from __future__ import annotations

import argparse
import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hub import files
from hub.command_output import put, put_json
from hub.doors.foxglove.layout import LAYOUT, layout_of
from hub.doors.panels.serving import body_of, serve
from hub.doors.panels.wishes import SenderKind
from hub.errors import DoorError
from hub.gcm.body import RobotBody
from hub.ipc.client import Client
from hub.ros.panel_door_name import panel_door_name

if TYPE_CHECKING:
    from hub.doors.foxglove.tool_server import ServerSettings

_SENDER: Final = SenderKind(
    owner="a panel of Foxglove",
    noun="panel",
    release="release it",
    rate="set its publish rate to 10 Hz",
)
_INSTALL: Final = "websockets is missing; install it with pip install 'robot-user-nexus[tools]'"


def run(options: argparse.Namespace, connect: Callable[[], Client]) -> int:
    """Serve until Ctrl-C; returns the exit code.

    Args:
        options: Those of the command line.
        connect: Makes a connection to the hub.

    Raises:
        DoorError: websockets is missing, the port is busy, or a file cannot be used.
        HubError: No hub answers.
    """
    try:
        from hub.doors.foxglove.tool_server import ServerSettings, ToolServer
    except ImportError as error:
        raise DoorError(_INSTALL) from error
    with contextlib.closing(connect()) as client:
        body = body_of(client)
        settings = ServerSettings(
            name=panel_door_name(body.name if body else ""),
            host=options.host,
            port=options.port,
            drive=options.drive,
            names=tuple(options.allow),
            certificate=options.tls_cert,
            key=options.tls_key,
        )
        if options.layout is not None:
            _write_layout(options.layout, body)
        opened: list[ToolServer] = []

        def open_server(changed: Callable[[], None]) -> ToolServer:
            opened.append(ToolServer(settings, changed))
            return opened[0]

        def announce() -> None:
            _announce(opened[0].address, settings, options)

        serve(client, options, open_server, sender=_SENDER, announce=announce)
    return 0


def _write_layout(path: Path, body: RobotBody | None) -> None:
    if body is None:
        text = f"{path} is not written: the hub does not say yet which robot it has; try again"
        raise DoorError(text)
    try:
        files.replace(path, layout_of(body).encode())
    except OSError as error:
        text = f"{path} cannot be written: {error.strerror}"
        raise DoorError(text) from error


def _announce(address: str, settings: ServerSettings, options: argparse.Namespace) -> None:
    """Say where programs connect."""
    layout = options.layout or LAYOUT
    if options.json:
        facts = {"event": "ready", "address": address, "layout": str(layout)}
        put_json(facts | {"drive": settings.drive, "pid": os.getpid()})
        return
    put(f"{settings.name} at {address}")
    put("In Foxglove or Lichtblick, open this address as a Foxglove WebSocket. It has the key of")
    put("this door, which is another one after each start. Keep it as a password.")
    put(f"Layout: {layout} (import it there)")
    if settings.drive:
        put("Panels drive the robot by /cmd_vel: every program with this address can do that.")
    put("Ctrl-C ends it.")
