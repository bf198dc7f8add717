"""`rune-hub serve ros2`: from start to end."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
from collections.abc import Callable
from typing import Final

from hub.command_output import put, put_json
from hub.doors.panels.serving import body_of, serve
from hub.doors.panels.wishes import CMD_VEL, SenderKind
from hub.doors.ros2.node_server import NodeSettings, RosNodeServer
from hub.errors import DoorError
from hub.ipc.client import Client
from hub.zenoh.router_tls import tls_settings
from hub.zenoh.session import open_session

_SENDER: Final = SenderKind(
    owner="a node of ROS 2",
    noun="node",
    release="end its velocities for 0.3 s",
    rate="publish velocities at 10 Hz or faster",
)
_NAMESPACE: Final = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)*", re.ASCII)


def run(options: argparse.Namespace, connect: Callable[[], Client]) -> int:
    """Serve until Ctrl-C; returns the exit code.

    Args:
        options: Those of the command line.
        connect: Makes a connection to the hub.

    Raises:
        DoorError: The namespace is none, or certificates are for no TLS.
        HubError: No hub or no router answers, or Zenoh is not installed.
    """
    namespace = options.namespace.rstrip("/")
    if _NAMESPACE.fullmatch(namespace) is None:
        text = f"{options.namespace!r} is no namespace of ROS 2; write one as /rover"
        raise DoorError(text)
    if options.tls is not None and not options.connect.startswith("tls/"):
        text = f"--tls is for a router with TLS: --connect tls/HOST:7447, not {options.connect}"
        raise DoorError(text)
    tls = tls_settings(options.tls.resolve()) if options.tls is not None else {}
    settings = NodeSettings(domain=options.domain, namespace=namespace, drive=options.drive)
    with contextlib.closing(connect()) as client:
        session = open_session(options.connect, settings=tls)
        serve(
            client,
            options,
            lambda changed: RosNodeServer(session, settings, changed),
            sender=_SENDER,
            announce=lambda: _announce(client, settings, options),
        )
    return 0


def _announce(client: Client, settings: NodeSettings, options: argparse.Namespace) -> None:
    """Say what nodes see."""
    if options.json:
        facts = {"event": "ready", "router": options.connect, "domain": settings.domain}
        put_json(facts | {"drive": settings.drive, "pid": os.getpid()})
        return
    body = body_of(client)
    name = f"{settings.namespace}/rune"
    put(
        f"{body.name if body else 'The robot'} is the node {name} of domain {settings.domain}, by "
        f"the router at {options.connect}"
    )
    if settings.drive:
        put(f"Every node of this domain drives it by {settings.namespace}{CMD_VEL}.")
    put("Ctrl-C ends it.")
