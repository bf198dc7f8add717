"""`rune-hub fleet mirror`: runs a mirror, and says which robots come and go."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import signal
import sys
import tempfile
import threading
from pathlib import Path

from hub.command_line import ExitCode, ending_signals
from hub.command_output import put
from hub.doors.mirror.mirror import Mirror
from hub.ipc.roles import Principal
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.table_text import json_text
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.fleet_session import check_certificates
from hub.zenoh.settings import CertificateFiles, RouterPlace, client_settings

_logger = logging.getLogger(__name__)

_LISTEN_S = 1.0
_LOOK_S = 0.1


class MirrorEvents:
    """Says on standard output what happens."""

    def __init__(self, place: RouterPlace, *, as_json: bool) -> None:
        """Say nothing yet."""
        self._place, self._as_json = place, as_json
        self._why: str | None = None

    def say(self, event: dict[str, object]) -> None:
        """Say one thing."""
        put(json_text(event) if self._as_json else _sentence(event))

    def look(self, *, joined: bool, trouble: str) -> None:
        """Say whether a router answers and else why not, at each change."""
        why = "" if joined else trouble or f"no router of the fleet answers at {self._place}"
        if why == self._why:
            return
        self._why = why
        if joined:
            self.say({"event": "joined", "router": str(self._place)})
        else:
            self.say({"event": "apart", "why": why})


def run_mirror(
    options: argparse.Namespace, operator: Principal, certificates: CertificateFiles | None
) -> int:
    """Mirror robots until a signal, or the end of standard input; returns the exit code.

    Args:
        options: Of the command.
        operator: Who asks and commands.
        certificates: The operator's, for a router with TLS.

    Raises:
        EndpointError: TLS and certificates do not go together.
        KeyFileError: A certificate is not there.
    """
    place: RouterPlace = options.connect
    settings = client_settings(place, certificates=certificates)
    check_certificates(settings)
    ended = threading.Event()
    loop = Loop()
    for number in ending_signals():
        signal.signal(number, lambda *_: ended.set())
    if options.stop_with_stdin:
        threading.Thread(target=_wait_for_stdin, args=(ended, loop), daemon=True).start()
    events = MirrorEvents(place, as_json=options.json)
    with contextlib.ExitStack() as stack:
        stack.callback(loop.close)
        folder = options.folder
        if folder is None:  # only this user may enter it
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rune-fleet-")))
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        line = ZenohFleetLine(place, settings, loop)
        stack.callback(line.close)
        mirror = Mirror(
            line,
            options.fleet,
            operator,
            robots=options.robot,
            folder=folder,
            loop=loop,
            faults=FaultCounter(_logger, loop.clock),
            report=events.say,
        )
        stack.callback(mirror.close)
        loop.every(_LOOK_S, lambda: events.look(joined=line.connected, trouble=line.trouble))
        while not ended.is_set():
            loop.listen(_LISTEN_S)
    return ExitCode.OK


def _wait_for_stdin(ended: threading.Event, loop: Loop) -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    ended.set()
    loop.post(lambda: None)


def _sentence(event: dict[str, object]) -> str:
    kind, robot = event["event"], event.get("robot")
    if kind == "robot":
        return f"{robot} is there: {event['endpoint']}"
    if kind == "gone":
        return f"{robot} is gone: {event['why']}" if event["why"] else f"{robot} is shown no more"
    if kind == "refused":
        return f"{robot} refused a command: {event['why']}"
    if kind == "rate" and event["thin"]:
        return f"the line to {robot} falls behind: its states come at the low rate"
    if kind == "rate":
        return f"the line to {robot} carries all again: its states come at the full rate"
    if kind == "joined":
        return f"joined the router at {event['router']}"
    return str(event["why"])
