"""`rune-hub play`: a recording on a bus of its own, for consoles and modules; nothing moves there.

The player is the hub's daemon: it reports itself as the owner of control, and refuses commands.
"""

from __future__ import annotations

import argparse
import datetime
import functools
import os
import select
import signal
import sys
import time
from contextlib import closing
from typing import Any

from hub.command_line import ExitCode
from hub.command_output import print_error, put, put_json
from hub.control_gate import ControlGate
from hub.errors import RecordingError
from hub.gcm.catalog import MESSAGES
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import (
    CONTROL_REQUEST,
    CONTROL_STATE,
    PLAYED,
    ControlState,
    is_restricted,
)
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics, DiagnosticStatus, Severity
from hub.gcm.mapping import MAP_COMMAND
from hub.gcm.mission import MISSION_COMMAND
from hub.gcm.recording import RECORD_COMMAND
from hub.gcm.standard import Header, Time
from hub.gcm.supervision import MODULE_COMMAND
from hub.hub_sockets import HubFolder
from hub.inspection.keys_of_terminal import read_keys
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.publish_rights import ROBOMON
from hub.recording.holes import said_of_holes
from hub.recording.live.player import Player, robots_of
from hub.recording.recording_set import RecordingSet

_STEP_NS = 5_000_000_000
_FASTEST, _SLOWEST = 100.0, 0.1
_CONNECT_S = 10.0
_STATE_S = 1.0
_SHOW_S = 0.25
_KEY_S = 0.05
_ENDS = (signal.SIGINT, signal.SIGTERM)


def play(options: argparse.Namespace) -> int:
    """Play recordings until the end, or until Ctrl-C; returns the exit code.

    Raises:
        RecordingError: They cannot be read, or have no such robot.
        EndpointError: A hub of this name runs.
    """
    with RecordingSet.open(options.files, unpacked=options.unpack) as log:
        log.drop_outliers()
        robots = robots_of(log)
        known: list[str] = []

        def say_faults() -> None:
            for fault in log.faults:
                if fault not in known:
                    known.append(fault)
                    print_error(fault)

        say_faults()
        for text in said_of_holes(log.holes):
            print_error(text)
        robot = _robot(robots, options.robot)
        empty = _why_empty(log, robot, options)
        say_faults()
        if empty:
            print_error(empty)
            return ExitCode.FAULT
        with (
            closing(HubFolder(options.name or f"{robot[:22]}-recording")) as folder,
            closing(Central([folder.endpoint])) as central,
            closing(Client(ROBOMON, central.endpoints[0])) as client,
        ):
            client.wait_connected(_CONNECT_S)
            code = _Playback(client, log, robot, options).run(central.endpoints[0])
        say_faults()
        return code or (ExitCode.FAULT if log.faults else ExitCode.OK)


def _chooses(topic: str, options: argparse.Namespace) -> bool:
    included = not options.topics or any(each.search(topic) for each in options.topics)
    return included and not any(each.search(topic) for each in options.exclude)


def _why_empty(log: RecordingSet, robot: str, options: argparse.Namespace) -> str:
    """Why there is nothing to play, in a sentence; empty: there is something."""
    channels = {
        channel
        for channel, topic in log.channels.items()
        if topic.robot == robot and _chooses(topic.name, options)
    }
    if not channels:
        return f"no topic of {robot} is chosen; `rune-hub log info` names its topics"
    if next(log.messages(channels=channels), None) is None:
        return f"no message of the chosen topics of {robot} can be read"
    return ""


def _robot(known: list[str], wanted: str) -> str:
    """The robot that is played.

    Raises:
        RecordingError: There is none of this name, or none at all.
    """
    if not known:
        text = "the recording has no messages of a robot of Rune"
        raise RecordingError(text)
    if wanted and wanted not in known:
        text = f"the recording has no robot {wanted[:40]!r}; it has {', '.join(known)}"
        raise RecordingError(text)
    if len(known) > 1 and not wanted:
        print_error(f"plays {known[0]}; with --robot NAME another of {', '.join(known)}")
    return wanted or known[0]


class _Playback:
    """Plays on a bus, and answers for the robot that is not there."""

    def __init__(
        self, client: Client, log: RecordingSet, robot: str, options: argparse.Namespace
    ) -> None:
        self._client, self._log, self._options, self._robot = client, log, options, robot
        self._ending = False
        self._player = Player(
            client,
            log,
            robot,
            chosen=functools.partial(_chooses, options=options),
            clock=time.monotonic,
            holes=log.holes,
        )
        self._player.rate, self._player.paused = options.rate, options.paused
        self._gate = ControlGate(client)
        client.define(CONTROL_STATE, DIAGNOSTICS)
        for definition in MESSAGES:
            if definition.plane is Plane.COMMAND:
                self._refuse(definition)
        client.every(_STATE_S, self._report)

    def run(self, endpoint: str) -> int:
        """Play until the end; returns the exit code."""
        before = {each: signal.signal(each, self._end) for each in _ENDS}
        try:
            self._client.wait_defined(_CONNECT_S)
            start = self._log.start
            self._player.seek(start + round(self._options.start * 1e9))
            self._report()
            self._announce(endpoint)
            with read_keys() as keys:
                self._serve(keys)
        finally:
            for each, handler in before.items():
                signal.signal(each, handler)
        return ExitCode.OK

    def _announce(self, endpoint: str) -> None:
        seconds = (self._log.end - self._log.start) / 1e9
        if self._options.json:
            facts = {"event": "ready", "hub": endpoint, "robot": self._robot, "seconds": seconds}
            put_json(facts | {"left_out": self._player.left_out})
        else:
            put(f"{self._robot}: RECORDING of {seconds:.1f} s at {endpoint}; Ctrl-C ends it")

    def _serve(self, keys: int | None) -> None:
        shown = 0.0
        while not self._ending:
            wait = self._player.step()
            self._client.listen(min(wait, _KEY_S if keys is not None else 0.2))
            if keys is not None:
                self._obey(keys)
            if self._over():
                if not self._options.loop:
                    self._wait_at_end(keys)
                    return
                self._player.seek(self._log.start + round(self._options.start * 1e9))
            if keys is not None and time.monotonic() - shown >= _SHOW_S:
                shown = time.monotonic()
                sys.stderr.write(f"\r{self._words()}\x1b[K")
                sys.stderr.flush()

    def _over(self) -> bool:
        most = self._options.duration
        begun = self._log.start + round(self._options.start * 1e9)
        late = 0.0 < most * 1e9 <= self._player.now - begun
        return (self._player.ended or late) and not self._player.paused

    def _wait_at_end(self, keys: int | None) -> None:
        """A person may go back from the end; a program is done."""
        if keys is None:
            return
        self._player.paused = True
        sys.stderr.write(f"\r{self._words()}\x1b[K")
        while not self._ending:
            self._client.listen(_KEY_S)
            self._obey(keys)
            if not self._player.paused or not self._player.ended:
                self._player.paused = False
                self._serve(keys)

    def _end(self, *_: object) -> None:
        self._ending = True

    def _obey(self, keys: int) -> None:
        """Do what the pressed keys say."""
        while select.select([keys], [], [], 0.0)[0]:
            pressed = os.read(keys, 8).decode(errors="replace")
            player = self._player
            if pressed in ("q", "\x03", "\x04", ""):
                self._ending = True
                return
            if pressed == " ":
                player.paused = not player.paused
            elif pressed in ("+", "\x1b[A"):
                player.rate = min(_FASTEST, player.rate * 2.0)
            elif pressed in ("-", "\x1b[B"):
                player.rate = max(_SLOWEST, player.rate / 2.0)
            elif pressed in ("\x1b[C", "\x1b[D"):
                player.seek(player.now + (_STEP_NS if pressed == "\x1b[C" else -_STEP_NS))
            self._report()

    def _words(self) -> str:
        """The present moment, in one line."""
        player = self._player
        at, whole = player.now - self._log.start, self._log.end - self._log.start
        state = "PAUSED" if player.paused else f"x{player.rate:g}"
        return f"RECORDING {_date(player.now)}  {at / 1e9:.1f} of {whole / 1e9:.1f} s  {state}"

    def _report(self) -> None:
        """Report that this is a recording, not a robot."""
        player = self._player
        state = "paused" if player.paused else f"x{player.rate:g}"
        why = f"RECORDING of {_date(player.now)}, {state}: no live view, nothing moves"
        modules = ControlState().modules
        self._client.publish(
            CONTROL_STATE,
            ControlState(
                owner=self._client.number,
                owner_name=PLAYED,
                operator=PLAYED,
                why=why,
                modules=modules,
            ),
        )
        notice = DiagnosticStatus(level=Severity.ERROR, name="recording", message=why)
        status = (notice, *player.problems)[:32]
        stamp = Time.of(player.now / 1e9)
        self._client.publish(DIAGNOSTICS, Diagnostics(header=Header(stamp=stamp), status=status))

    def _refuse(self, definition: MessageDefinition[Any]) -> None:
        """Refuse a command, in words where it is a question."""
        if definition in _QUESTIONS:
            refusal = CommonResult(done=0, text="this is a recording: nothing can be commanded")
            self._client.respond(definition, COMMON_RESULT, lambda _: refusal)
            return

        def refuse(value: Any, info: MessageInfo) -> None:  # noqa: ANN401 - any command
            if is_restricted(definition.name, value):
                self._gate.admits(definition, info)

        self._client.subscribe(definition, refuse)


_QUESTIONS = (CONTROL_REQUEST, MISSION_COMMAND, MAP_COMMAND, RECORD_COMMAND, MODULE_COMMAND)


def _date(stamp: int) -> str:
    date = datetime.datetime.fromtimestamp(stamp / 1e9, datetime.UTC).astimezone()
    return date.strftime("%Y-%m-%d %H:%M:%S")
