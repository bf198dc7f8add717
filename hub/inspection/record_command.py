"""`rune-hub record`: records a hub from here, or orders the robot's own recorder."""

from __future__ import annotations

import argparse
import math
import os
import select
import signal
import sys
import time
from pathlib import Path

from hub.command_line import ExitCode, login_name
from hub.command_output import print_error, put, stdin_ended
from hub.errors import HubError, NoHandlerError, QueryError, RecordingError
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.capability import Capability
from hub.gcm.common import COMMON_RESULT
from hub.gcm.recording import RECORD_COMMAND, RECORD_MARK, RecordAction, RecordCommand, RecordMark
from hub.gcm.supervision import CAPABILITY_WANTS, MODULE_REPORTS, CapabilityWants
from hub.gcm.vision import ImageCoding
from hub.inspection.keys_of_terminal import read_keys
from hub.inspection.output import report, span
from hub.ipc.client import Client
from hub.recording.live.bus_recorder import BusRecorder
from hub.recording.live.places import SUFFIX, date_name, numbered
from hub.recording.live.series import (
    DISK_S,
    RecordingSeries,
    SeriesLimits,
    SeriesState,
    free_room,
)
from hub.recording.live.settings import PictureSettings, RecordingTable
from hub.recording.topics import topic_of
from hub.recording.writer import WriterLimits
from hub.table_text import json_text

_ANSWER_S = 5.0
_START_S = 15.0
"""Longest wait for the robot's recorder to start [s]."""
_LISTEN_S = 0.1
_LOOK_S = 0.1
"""Time between two looks at files and keys [s]."""
_ENDS = (signal.SIGINT, signal.SIGTERM)
_SHOW_S = 0.5
"""Time between two lines of progress [s]."""
_LONG_S = 30 * 86_400.0
"""Room on the disk for this time is no news [s]."""


def record(client: Client, options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code."""
    order = _order(options)
    if order is not None:
        return _send(client, order)
    return _Foreground(client, options).run()


def _order(options: argparse.Namespace) -> RecordCommand | None:
    """The order to the robot's recorder; None: this command records itself."""
    by = login_name()
    if options.start is not None:
        return RecordCommand(action=RecordAction.START, name=options.start, by=by)
    if options.stop:
        return RecordCommand(action=RecordAction.STOP, by=by)
    if options.split:
        return RecordCommand(action=RecordAction.SPLIT, by=by)
    if options.mark is not None:
        return RecordCommand(action=RecordAction.MARK, text=options.mark, by=by)
    if options.snapshot is not None:
        return RecordCommand(
            action=RecordAction.SNAPSHOT,
            text=options.snapshot,
            before_s=options.before,
            after_s=options.after,
            by=by,
        )
    return None


def _send(client: Client, order: RecordCommand) -> int:
    """Give the robot's recorder an order, and start it for that."""
    client.define(CAPABILITY_WANTS)
    deadline = time.monotonic() + _START_S
    while True:
        if order.action is RecordAction.START:
            wants = CapabilityWants(holder=client.name, capabilities=Capability.REC_LOG)
            client.publish(CAPABILITY_WANTS, wants)
        try:
            result = client.query_response(RECORD_COMMAND, order, COMMON_RESULT, timeout=_ANSWER_S)
        except NoHandlerError as error:
            if order.action is not RecordAction.START:
                text = (
                    "the robot's recorder does not run, so nothing is recorded there; "
                    "`rune-hub record --start` starts it"
                )
                raise QueryError(text) from error
            if time.monotonic() > deadline:
                text = (
                    "the robot has no recorder that starts; `rune-hub modules` shows its modules, "
                    "and [modules.recorder] of the robot file adds one"
                )
                raise QueryError(text) from error
            _listen(client, 0.3)
        else:
            return report(result)


def _listen(client: Client, seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        client.listen(min(left, _LISTEN_S))


class _Foreground:
    """Records a hub in this process."""

    def __init__(self, client: Client, options: argparse.Namespace) -> None:
        self._client, self._options = client, options
        self._ending = False
        self._paused = False
        self._marks = 0
        self._shown = False
        self._said = ""
        robot, cameras = _robot_of(client)
        self._robot = robot
        settings = RecordingTable(
            pictures=PictureSettings(
                rate=options.pictures, size=options.size, format=ImageCoding[options.format]
            ),
            maps=options.maps,
            topics=tuple(options.topics),
            exclude=tuple(options.exclude),
            ros_names=options.ros_names,
            wake=options.wake,
        )
        self._bus = BusRecorder(client, robot, settings, cameras=cameras)
        first = options.output or Path(f"{robot}_{date_name()}{SUFFIX}")
        if first.exists():
            text = f"{first} exists already; give another name"
            raise RecordingError(text)
        if not first.absolute().parent.is_dir():
            text = f"{first.absolute().parent} is no folder; make it first"
            raise RecordingError(text)
        split_s, split_bytes = options.split_every
        self._series = RecordingSeries(
            numbered(first.absolute()),
            {"robot": robot, "recorder": "rune-hub record", "hub": client.endpoint},
            SeriesLimits(
                split_s=split_s,
                split_bytes=split_bytes,
                writer=WriterLimits(least_free=options.least_free),
            ),
            latched=self._bus.latched,
            say=self._say,
        )
        if self._series.state.fault:
            text = f"nothing is recorded: {self._series.state.fault}"
            raise RecordingError(text)
        self._bus.series.append(self._series)

    def run(self) -> int:
        """Record until the end; returns the exit code."""
        before = {each: signal.signal(each, self._stop) for each in _ENDS}
        try:
            self._bus.subscribe()
            self._client.wait_subscribed(_ANSWER_S)
            state = self._series.state
            self._report("ready", state, f"records {self._robot} to {state.path}; Ctrl-C ends it")
            with read_keys() as keys:
                self._serve(keys)
        finally:
            self._bus.take_now()
            state = self._series.close(DISK_S)
            lost = self._bus.lost()
            for each, handler in before.items():
                signal.signal(each, handler)
        return self._conclude(state, lost.total())

    def _serve(self, keys: int | None) -> None:
        begun = shown = looked = time.monotonic()
        while not self._ending:
            self._client.listen(_LISTEN_S)
            if time.monotonic() - looked < _LOOK_S:
                continue
            looked = time.monotonic()
            if keys is not None:
                self._obey(keys)
            self._bus.look()
            now, state = time.monotonic(), self._series.state
            self._said = state.fault or self._said
            most = self._options.max_bytes
            over = 0.0 < self._options.duration <= now - begun or 0 < most <= state.bytes
            if over or (self._options.stop_with_stdin and stdin_ended()):
                self._ending = True
            if keys is not None and now - shown >= _SHOW_S:
                shown = now
                self._show(state, now - begun)

    def _stop(self, *_: object) -> None:
        self._ending = True

    def _obey(self, keys: int) -> None:
        """Do what the pressed keys say."""
        while select.select([keys], [], [], 0.0)[0]:
            pressed = os.read(keys, 1).decode(errors="replace")
            if pressed in ("q", "\x03", "\x04", ""):
                self._ending = True
                return
            self._bus.take_now()
            if pressed == " ":
                self._paused = not self._paused
                self._bus.series[:] = [] if self._paused else [self._series]
            elif pressed == "s":
                self._series.split()
            elif pressed == "m":
                self._note_moment()

    def _note_moment(self) -> None:
        self._marks += 1
        mark = RecordMark(number=self._marks, by=login_name(), stamp=time.time())
        now = time.monotonic()
        topic = topic_of(self._robot, RECORD_MARK)
        self._series.add(topic, b"".join(RECORD_MARK.encode(mark)), now, now, self._marks)

    def _say(self, text: str) -> None:
        """Write a sentence in place of the line of progress, which follows below."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
        print_error(text)

    def _show(self, state: SeriesState, seconds: float) -> None:
        """Write the line of progress over the one before."""
        self._shown = True
        minutes, rest = divmod(int(seconds), 60)
        free = free_room(state.path.parent) - self._options.least_free
        left = free / (state.bytes / seconds) if state.bytes and not state.fault else math.inf
        words = (
            "NOT RECORDING" if state.fault else "PAUSED" if self._paused else "REC",
            f"{minutes // 60}:{minutes % 60:02}:{rest:02}",
            f"{state.messages} messages of {self._bus.topics} topics",
            f"{state.bytes / 1e6:.1f} MB",
            f"{self._marks} marks" if self._marks else "",
            f"LOST {self._bus.lost().total()}" if self._bus.lost() else "",
            f"{span(left)} left" if left < _LONG_S else "",
        )
        sys.stderr.write("\r" + "  ".join(filter(None, words))[:100] + "\x1b[K")
        sys.stderr.flush()

    def _report(self, event: str, state: SeriesState, text: str) -> None:
        if self._options.json:
            facts = {
                "event": event, "path": str(state.path), "files": state.files,
                "messages": state.messages, "bytes": state.bytes, "robot": self._robot,
                "lost": dict(self._bus.lost()), "fault": state.fault,
            }  # fmt: skip
            text = json_text(facts)
        put(text)

    def _conclude(self, state: SeriesState, lost: int) -> int:
        files = f" and {state.files - 1} files before it" if state.files > 1 else ""
        missing = f", {lost} are lost" if lost else ""
        text = f"{state.messages} messages ({state.bytes / 1e6:.1f} MB) are in {state.path}{files}"
        self._report("end", state, text + missing)
        for topic, count in self._bus.lost().most_common(5):
            print_error(f"{count} messages of {topic} are not recorded")
        if state.fault or self._said:
            print_error(f"the recording has a gap or an early end: {state.fault or self._said}")
            return ExitCode.FAULT
        return ExitCode.OK if not lost else ExitCode.FAULT


def _robot_of(client: Client) -> tuple[str, list[str]]:
    """Name of a hub's robot, and of its cameras."""
    try:
        body = client.last_value(ROBOT_DESCRIPTION, timeout=_ANSWER_S)
    except HubError:
        pass
    else:
        return body.name, [camera.name for camera in body.cameras] or [""]
    try:
        return client.last_value(MODULE_REPORTS, timeout=_ANSWER_S).robot or "robot", [""]
    except HubError:  # a hub without a daemon
        return "robot", [""]
