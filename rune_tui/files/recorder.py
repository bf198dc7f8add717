"""Records messages from and to robots, and the console itself: inputs, frames, layouts."""

from __future__ import annotations

import contextlib
import datetime
import functools
import hashlib
import os
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from hub.gcm import mapping, vision
from hub.gcm.catalog import BY_NAME
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.ipc.definition import MessageDefinition
from rune_tui.files import user_files
from rune_tui.files.frame_log import CONSOLE, DrawnFrame, FrameLog
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_link import RobotLink
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.display_state import RUNE_DISPLAY, DisplayState
from rune_tui.model.own_records import (
    RUNE_INPUT,
    RUNE_LAYOUT,
    RUNE_SELECT,
    GivenVariable,
    InputRecord,
    LayoutRecord,
    Selection,
    SelectRecord,
    TerminalRecord,
)
from rune_tui.model.robot_state import Picture, Received, RobotState, titles
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent

if TYPE_CHECKING:
    from rune_tui.files.console_recording import ConsoleRecording

_DISPLAY_S = 1.0
"""Period of the records of the display's state [s]."""
_LARGEST_FILE = 16 << 20
"""Longest file of a layout that is recorded [bytes]."""


class Recorder:
    """Begins and ends recordings; for the console's own thread only.

    Attributes:
        terminal: The terminal; its size comes with the frames.
        folder: Folder of new recordings; None: in the user's documents.
    """

    def __init__(self, links: RobotLinks) -> None:
        self.terminal = TerminalRecord()
        self.folder: Path | None = None
        self._links = links
        self._recording: ConsoleRecording | None = None
        self._frames: FrameLog | None = None
        self._topics: dict[str, str] = {}
        self._attached: set[str] = set()
        self._noted = 0.0

    @property
    def path(self) -> str:
        """The file of the running recording; else empty."""
        return str(self._recording.path) if self._recording is not None else ""

    @property
    def fault(self) -> str:
        """Why nothing more of the running recording is kept; empty: all is, or none runs."""
        return self._recording.state.fault if self._recording is not None else ""

    def begin(self, layout: LayoutSpec, operator: str) -> user_files.Outcome:
        """Begin a recording; returns the outcome."""
        now = datetime.datetime.now().astimezone()
        self._recording, outcome = user_files.begin_recording(layout, operator, now, self.folder)
        if self._recording is None:
            return outcome
        self._topics, self._attached = {}, set()
        self._frames = FrameLog(self._recording, self._topics, self.terminal)
        self.follow(layout)
        for link in self._links.values():
            # The next frames refer to messages that came before.
            for definition, value, received in _present(link.state):
                self._recording.add(
                    self._topics[link.state.name],
                    definition,
                    value,
                    received.measured,
                    received.number,
                )
        return outcome

    def follow(self, layout: LayoutSpec) -> None:
        """Record another layout and all present links, with the time of the change."""
        self._tap()
        if self._recording is None:
            return
        record_layout(self._recording, layout, self._attached)

    def end(self) -> Callable[[], user_files.Outcome]:
        """Stop to record; returns the slow rest of the work."""
        recording, self._recording, self._frames = self._recording, None, None
        self._tap()
        if recording is None:
            return lambda: user_files.Outcome(text="nothing was being recorded")
        return lambda: user_files.end_recording(recording)

    def _tap(self) -> None:
        """Connect all links, also new ones, to the recording."""
        called = _names(self._links.values())
        for link, name in zip(self._links.values(), called, strict=True):
            if self._recording is None:
                link.tap(None)
                continue
            # A robot keeps its name in topics as long as the recording runs.
            topic = self._topics.setdefault(link.state.name, name)
            link.tap(functools.partial(self._recording.add, topic))

    def add(self, definition: MessageDefinition[Any], value: object, now: float) -> None:
        """Record a message of the console itself."""
        if self._recording is not None:
            self._recording.add(CONSOLE, definition, value, now)

    def note_team(self, now: float, event: TeamEvent) -> None:
        """Record what the operator did with the robots."""
        self.add(RUNE_TEAM, event, now)

    def note(self, now: float, display: DisplayState) -> None:
        """Record the display's state once a second."""
        if self._recording is not None and now - self._noted >= _DISPLAY_S:
            self._noted = now
            self.add(RUNE_DISPLAY, display, now)

    def note_input(self, record: InputRecord) -> None:
        """Record an input and what became of it."""
        self.add(RUNE_INPUT, record, record.t_read)

    def note_focus(self, now: float, *, on: bool) -> None:
        """Record that the terminal got the focus or lost it."""
        self.add(RUNE_SELECT, SelectRecord(what=Selection.FOCUS, on=on), now)

    def note_frame(self, state: ConsoleState, drawn: DrawnFrame) -> None:
        """Record a frame and all that it was drawn from."""
        if self._frames is not None:
            self._frames.frame(state, drawn)

    def note_handed(self, sent: float, *, answers: bool) -> None:
        """Record that the newest frame went to the terminal; see `FrameLog.handed`."""
        if self._frames is not None:
            self._frames.handed(sent, time.monotonic(), answers=answers)

    def note_answered(self, sent: float, now: float) -> None:
        """Record that the terminal shows the frame that was sent at a time [s]."""
        if self._frames is not None:
            self._frames.answered(sent, now)


def record_layout(recording: ConsoleRecording, layout: LayoutSpec, attached: set[str]) -> None:
    """Record that a layout is shown from now on, with its files.

    Args:
        recording: The recording.
        layout: The layout.
        attached: Checksums of the layouts whose files it has.
    """
    files = dict(_files(layout))
    whole = hashlib.sha256()
    for name, content in files.items():
        whole.update(f"{name} {len(content)}\n".encode())
        whole.update(content)
    digest = whole.hexdigest()
    if digest not in attached:
        attached.add(digest)
        for name, content in files.items():
            recording.attach(f"{digest[:16]}/{name}", content)
    record = LayoutRecord(
        layout=layout.path,
        run=layout.run_number,
        sha256=digest,
        variables=tuple(GivenVariable(name=name, value=value) for name, value in layout.variables),
        files=tuple(f"{digest[:16]}/{name}" for name in files),
    )
    recording.add(CONSOLE, RUNE_LAYOUT, record, time.monotonic())


def _names(links: Iterable[RobotLink]) -> list[str]:
    """Names of robots in a recording: as on the screen, without `/`."""
    called = titles(link.state for link in links)
    return [name if "/" not in name else role for role, name in called.items()]


def _files(layout: LayoutSpec) -> Iterator[tuple[str, bytes]]:
    """The files of a layout by their places relative to each other; the layout comes first."""
    paths = [path.absolute() for path in layout.files]
    folder = Path(os.path.commonpath([path.parent for path in paths])) if paths else Path()
    for path in dict.fromkeys(paths):
        with contextlib.suppress(OSError), path.open("rb") as file:
            content = file.read(_LARGEST_FILE + 1)
            if len(content) <= _LARGEST_FILE:
                yield str(PurePosixPath(path.relative_to(folder))), content


def _present(
    robot: RobotState,
) -> Iterator[tuple[MessageDefinition[Any], object, Received[Any]]]:
    """The messages that a state is made of, as if they came now."""
    for name, received in robot.messages.items():
        yield BY_NAME[name], received.value, received
    newest = robot.messages.values()
    for received in robot.diagnostics.values():
        if all(received.number != each.number for each in newest):
            yield DIAGNOSTICS, received.value, received
    for received in robot.all_pictures.values():
        yield vision.IMAGE, _image(received.value), received
    if robot.map is not None:
        yield mapping.MAP, robot.map.value.message(0.0), robot.map


def _image(picture: Picture) -> vision.Image:
    """The message of a decoded picture."""
    height, width, channels = picture.pixels.shape
    return vision.Image(
        camera=picture.camera,
        coding=vision.ImageCoding.RAW,
        width_px=width,
        height_px=height,
        channels=channels,
        data=picture.pixels.reshape(-1),
    )
