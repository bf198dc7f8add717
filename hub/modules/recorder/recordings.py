"""What a robot's recorder writes now: the ring, the recording, and snapshots of both."""

from __future__ import annotations

import logging
import math
import time
from collections import Counter
from pathlib import Path
from typing import Any

from hub.errors import RecordingError
from hub.gcm.recording import RECORD_MARK, RecordMark, RecordState
from hub.ipc.client import Client
from hub.modules.recorder.running_note import note_running, read_running
from hub.modules.recorder.sentences import said_of_end, said_of_mark, said_of_split
from hub.recording.live.bus_recorder import BusRecorder, reported
from hub.recording.live.places import RecordingFolder, demand_folder, numbered
from hub.recording.live.series import (
    DISK_S,
    RETRY_S,
    Attached,
    RecordingSeries,
    SeriesLimits,
    free_room,
)
from hub.recording.live.settings import RING_SPLIT_S
from hub.recording.live.snapshots import MOST, Snapshot, left_snapshots
from hub.recording.writer import WriterLimits
from hub.robots.description import RobotDescription
from hub.values import dataclass

_logger = logging.getLogger(__name__)


@dataclass(slots=True)
class _RunningRecording:
    """The recording that runs.

    Attributes:
        series: Its files.
        by: Its operator.
        begun: Its start [s since the epoch].
        since: Its start on the monotonic clock [s].
    """

    series: RecordingSeries
    by: str
    begun: float
    since: float

    def facts(self) -> dict[str, Any]:
        """Its fields of `RecordState`."""
        state = self.series.state
        return {
            "recording": 1,
            "by": self.by[:64],
            "begun": max(0.0, self.begun),
            "running_s": time.monotonic() - self.since,
            "messages": state.messages,
            "size_mb": state.bytes / 1e6,
            "files": state.files,
        }


class Recordings:
    """The ring and the recording of one robot."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        """Begin what runs always, and resume what ran before a crash."""
        self._client, self._robot = client, robot
        self._settings = robot.recording
        self._folder = RecordingFolder(robot.recording.folder, robot.name)
        self._bus: BusRecorder | None = None
        self._ring: RecordingSeries | None = None
        self._running: _RunningRecording | None = None
        self._snapshots = left_snapshots(self._folder.snapshots, self._source)
        self._fault = ""
        self._lost: Counter[str] = Counter()
        self._rate = _GrowthRate()
        self._begin_at = math.inf
        self._begin_first()

    def start(self, name: str, by: str) -> str:
        """Begin a recording; returns the result, for people.

        Raises:
            RecordingError: One runs, or its file cannot be written.
        """
        if self._running is not None:
            path = self._running.series.state.path
            text = f"a recording runs already: {path}; end it first"
            raise RecordingError(text)
        first = self._folder.recording(name)
        self._begin(first, by, time.time())
        fault = note_running(self._folder.running, first, by)
        return f"records to {first}" + (f"; {fault}" if fault else "")

    def stop(self) -> str:
        """End the recording; returns the result, for people.

        Raises:
            RecordingError: None runs; or one is ended that lacks messages.
        """
        running = self._demand_running()
        bus = self._attach()
        self._running = None
        self._detach(running.series)
        state = running.series.close(DISK_S)
        self._lost = bus.lost(running.series)
        note_running(self._folder.running, None, "")
        return said_of_end(state, self._lost.total())

    def keep_mark(self, mark: RecordMark) -> str:
        """Write a mark into each file that is written; returns the result, for people.

        Raises:
            RecordingError: It is in none of them.
        """
        if self._bus is None:
            text = "no mark is kept: nothing is recorded; begin a recording first"
            raise RecordingError(text)
        self._bus.take_now()
        chosen = self._bus.add(RECORD_MARK, mark, time.monotonic())
        return said_of_mark(self._all() if chosen else (), mark)

    def split(self) -> str:
        """Go on in another file; returns the result, for people.

        Raises:
            RecordingError: Nothing is recorded.
        """
        series = self._running.series if self._running is not None else self._ring
        if series is None:
            text = "there is nothing to split: nothing is recorded"
            raise RecordingError(text)
        series.split()
        return said_of_split(series.state)

    def keep_snapshot(self, name: str, before: float, after: float) -> str:
        """Keep the time around this moment; returns the result, for people.

        Args:
            name: Of its file; empty: date and time.
            before: Length of the span before this moment [s].
            after: Length of the span after it [s].

        Raises:
            RecordingError: Nothing is recorded, or too many snapshots are under way.
        """
        series = self._source()
        if series is None:
            text = (
                "there is no snapshot: nothing is recorded; set 'always' and 'keep' in "
                "[recording] of the robot file, or begin a recording"
            )
            raise RecordingError(text)
        if fault := series.state.fault:
            text = f"there is no snapshot: {fault}"
            raise RecordingError(text)
        if len(self._snapshots) >= MOST:
            text = f"{MOST} snapshots are under way; wait until they are written"
            raise RecordingError(text)
        now = time.monotonic()
        target = self._folder.snapshot(name)
        taken = {each.target for each in self._snapshots}
        while target in taken:
            target = target.with_name(f"{target.stem}+{target.suffix}")
        snapshot = Snapshot(series, target, now - before, now + after)
        snapshot.note(series.state.path.parent)
        self._snapshots.append(snapshot)
        text = f"the time from {before:g} s before to {after:g} s after now comes to {target}"
        reaches = series.state.reaches
        return f"{text}; only {reaches:.1f} s before are recorded" if reaches < before else text

    def look(self) -> None:
        """Do what is due; call it some times a second."""
        now = time.monotonic()
        if now >= self._begin_at:
            self._begin_first()
        if self._bus is not None:
            self._bus.look()
            self._rate.see(now, self._bytes())
        for each in self._snapshots:
            each.look(now)
            if each.fault:
                self._fault = each.fault
        self._snapshots = [each for each in self._snapshots if not each.done]

    def state(self, marks: int, mark: str) -> RecordState:
        """What is recorded, with the marks of this recorder."""
        series = [each.state for each in self._all()]
        lost = self._lost | self._bus.lost() if self._bus is not None else self._lost
        fault = next((each.fault for each in series if each.fault), self._fault)
        facts: dict[str, Any] = {}
        if self._running is not None:
            facts |= self._running.facts()
        if self._ring is not None:
            ring = self._ring.state
            facts |= {"ring": 1, "ring_s": min(ring.reaches, 1e9), "ring_mb": ring.bytes / 1e6}
        path = str(series[-1].path) if series else ""
        free = free_room(_existing(self._folder.path))
        room = free - self._settings.least_free
        return RecordState(
            path=path[:1000],
            free_mb=free / 1e6,
            left_s=self._rate.time_for(room) if self._running is not None else math.nan,
            marks=marks,
            mark=mark,
            lost=min(lost.total(), 0xFFFF_FFFF),
            lost_by_topic=reported(lost),
            fault=fault[:1000],
            **facts,
        )

    def close(self) -> None:
        """Complete all files."""
        bus, self._bus = self._bus, None
        if self._running is not None:
            note_running(self._folder.running, None, "")
        if bus is not None:
            bus.take_now()
            bus.close()
        for each in self._all():
            each.close()

    def _source(self) -> RecordingSeries | None:
        """Where snapshots are taken from; None: nothing is recorded."""
        return self._ring or (self._running.series if self._running is not None else None)

    def _all(self) -> list[RecordingSeries]:
        """The series that are written: the ring first."""
        running = [self._running.series] if self._running is not None else []
        return ([self._ring] if self._ring is not None else []) + running

    def _demand_running(self) -> _RunningRecording:
        if self._running is None:
            ring = "; the ring ends only with the hub" if self._ring is not None else ""
            text = f"no recording runs{ring}"
            raise RecordingError(text)
        return self._running

    def _begin_first(self) -> None:
        """Begin what runs always, and resume; without a folder, try it again later."""
        file = "" if self._settings.rings else self._settings.file
        try:
            if self._settings.always:
                demand_folder(Path(file).parent if file else self._folder.path)
        except RecordingError as error:
            if str(error) != self._fault:
                _logger.error("%s", error)
            self._fault, self._begin_at = str(error), time.monotonic() + RETRY_S
            return
        self._fault, self._begin_at = "", math.inf
        if self._settings.rings:
            self._begin_ring()
        if self._running is None:
            self._resume()

    def _begin_ring(self) -> None:
        split_s, split_bytes = self._settings.split
        limits = SeriesLimits(
            split_s=split_s or RING_SPLIT_S,
            split_bytes=split_bytes,
            keep_s=self._settings.keep,
            keep_bytes=self._settings.most,
            writer=WriterLimits(least_free=self._settings.least_free),
        )
        bus = self._attach()
        self._ring = RecordingSeries(
            self._folder.ring_file,
            self._about,
            limits,
            latched=bus.latched,
            attached=_attachments(self._robot),
        )
        if fault := self._ring.state.fault:
            _logger.error("the ring keeps nothing: %s", fault)
        self._ring.adopt(self._folder.ring)
        bus.series.append(self._ring)

    def _begin(self, first: Path, by: str, begun: float) -> None:
        """Begin a recording.

        Raises:
            RecordingError: Its first file cannot be written.
        """
        split_s, split_bytes = self._settings.split
        limits = SeriesLimits(
            split_s=split_s,
            split_bytes=split_bytes,
            writer=WriterLimits(least_free=self._settings.least_free),
        )
        bus = self._attach()
        series = RecordingSeries(
            numbered(first),
            self._about,
            limits,
            latched=bus.latched,
            attached=_attachments(self._robot),
        )
        if series.state.fault:
            self._detach(series)
            text = f"nothing is recorded: {series.state.fault}"
            raise RecordingError(text)
        bus.take_now()
        self._lost.clear()
        bus.reset_losses()
        bus.series.append(series)
        self._running = _RunningRecording(series, by, begun, time.monotonic())

    def _attach(self) -> BusRecorder:
        """The tap of the hub; it lives while anything is recorded."""
        if self._bus is None:
            client = Client(
                f"{self._client.name}-tap", self._client.endpoint, loop=self._client.loop
            )
            cameras = [camera.name for camera in self._robot.body.cameras] or [""]
            self._bus = BusRecorder(
                client, self._robot.name, self._settings, cameras=cameras, added=(RECORD_MARK.name,)
            )
        return self._bus

    def _detach(self, series: RecordingSeries) -> None:
        """Take a series off the tap, and end the tap if it was the last."""
        bus = self._bus
        if bus is None:
            return
        bus.take_now()
        bus.series[:] = [each for each in bus.series if each is not series]
        if not bus.series:
            self._bus = None
            bus.close()

    @property
    def _about(self) -> dict[str, str]:
        return {"robot": self._robot.name, "kind": self._robot.kind, "recorder": "hub"}

    def _resume(self) -> None:
        """Go on with a recording that ran when the recorder ended; else begin the usual one."""
        note = self._folder.running
        try:
            first, by, begun = read_running(note)
        except (FileNotFoundError, NotADirectoryError):
            if self._settings.always and self._ring is None:
                named = Path(self._settings.file) if self._settings.file else None
                self._try_to_begin(named or self._folder.recording(""), "", time.time())
            return
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            # A recording ran; its name is not known.
            first, by, begun = self._folder.recording(""), "", time.time()
            _logger.error("%s cannot be read (%s); the recording goes on in %s", note, error, first)
            note_running(note, first, by)
        self._try_to_begin(first, by, begun)

    def _try_to_begin(self, first: Path, by: str, begun: float) -> None:
        try:
            self._begin(first, by, begun)
        except RecordingError as error:
            self._fault = str(error)
            _logger.error("%s", error)

    def _bytes(self) -> int:
        return sum(each.state.bytes for each in self._all())


def _existing(folder: Path) -> Path:
    """A folder, or the nearest above it that is there."""
    return next((each for each in (folder, *folder.parents) if each.exists()), Path("/"))


def _attachments(robot: RobotDescription) -> list[Attached]:
    """The robot file."""
    try:
        data = robot.path.read_bytes()
    except OSError:
        return []
    return [Attached(robot.path.name, "application/toml", data)]


class _GrowthRate:
    """How fast files grow, over the last half minute.

    Attributes:
        bytes_per_s: That; 0: not known yet.
    """

    def __init__(self) -> None:
        self.bytes_per_s = 0.0
        self._at, self._bytes = 0.0, 0

    def see(self, now: float, size: int) -> None:
        """Note the size of all files [bytes] at `now` [s]."""
        if not self._at or size < self._bytes:
            self._at, self._bytes = now, size
        elif now - self._at >= 2.0:
            present = (size - self._bytes) / (now - self._at)
            share = min(1.0, (now - self._at) / 30.0) if self.bytes_per_s else 1.0
            self.bytes_per_s += share * (present - self.bytes_per_s)
            self._at, self._bytes = now, size

    def time_for(self, room: int) -> float:
        """Time in which files fill these bytes [s]; NaN: they do not grow, or it is not known."""
        return min(max(0.0, room / self.bytes_per_s), 1e9) if self.bytes_per_s else math.nan
