"""The recording of a console as frames: each has the state that the console drew then."""

from __future__ import annotations

import dataclasses
import functools
import typing
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hub.recording.reader import LoggedMessage
from hub.recording.recording_set import RecordingSet
from rune_tui.errors import DamagedLogError, LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.own_records import (
    RUNE_FRAME,
    RUNE_LINK,
    FrameRecord,
    FrameRobot,
    LayoutRecord,
    LinkRecord,
    StateRecord,
    TerminalRecord,
)
from rune_tui.model.plain_values import from_json
from rune_tui.model.robot_state import (
    Lack,
    LackKind,
    LinkPhase,
    LinkState,
    Received,
    RobotState,
)
from rune_tui.model.theme import THEMES
from rune_tui.replay.logged_layouts import LoggedLayouts
from rune_tui.replay.logged_values import Decoder
from rune_tui.replay.source import Overview, ReplayFrame
from rune_tui.replay.survey import survey

_SEARCHED_NS = 30_000_000_000
"""How far back a message is searched that is not the newest of its topic [ns]."""
_SAME = tuple(
    {each.name for each in dataclasses.fields(LinkState)}
    & {each.name for each in dataclasses.fields(LinkRecord)}
    - {"phase", "number", "lacking", "unfit"}
)


def has_frames(recording: RecordingSet) -> bool:
    """Whether a console wrote a recording with its frames."""
    return any(topic.message == RUNE_FRAME.name for topic in recording.channels.values())


class ConsoleLog:
    """Frames of one console, exactly as it drew them; see `ReplaySource`."""

    def __init__(self, path: Path, others: Sequence[Path] = (), *, unpacked: int = 0) -> None:
        """Open a recording.

        Args:
            path: The file.
            others: Recordings of the same mission, for the timeline.
            unpacked: Most bytes that are unpacked of each; 0: by its size.

        Raises:
            RecordingError: It cannot be read.
            LogError: It has no frames, or its layout cannot be opened.
        """
        self.title = path.name
        self._paths, self._unpacked = (path, *others), unpacked
        self._recording = recording = RecordingSet.open([path], unpacked=unpacked)
        anchor = recording.anchor
        if anchor is None or not has_frames(recording):
            recording.close()
            reason = f"{path} has no frames of a console"
            raise LogError(reason)
        self._decoder = Decoder(recording.channels, anchor, [])
        self._frames = {
            number
            for number, topic in recording.channels.items()
            if topic.message == RUNE_FRAME.name
        }
        self._moment = _Moment(recording, self._decoder)
        self._at = -1
        first = next(recording.messages(channels=self._frames), None)
        last = next(recording.messages(channels=self._frames, reverse=True), None)
        if first is None or last is None:
            faults = recording.faults
            recording.close()
            reason = "; ".join((f"{path} has no frames of a console that can be read", *faults[:3]))
            raise DamagedLogError(reason)
        self.start, self.end = first.stamp, last.stamp
        self.holes: Sequence[tuple[int, int]] = ()

    @property
    def faults(self) -> list[str]:
        """What cannot be shown, and why."""
        return [*self._recording.faults, *self._decoder.faults]

    def frames(self, after: int, until: int, apart: int = 0) -> Iterator[ReplayFrame]:
        """Some or all frames, in the order of time; see `ReplaySource`."""
        if self._at != after:
            self._moment.begin(after)
        due = after + apart
        for message in self._recording.messages(after + 1, until):
            frame = self._moment.frame(message, build=message.stamp >= due)
            if frame is not None:
                self._at, due = frame.stamp, frame.stamp + apart
                yield frame
        self._at = until

    def frame_before(self, stamp: int) -> int | None:
        """Stamp of the newest frame at or before a time; None: there is none."""
        found = self._recording.newest(stamp, self._frames).values()
        return max((message.stamp for message in found), default=None)

    def frame_after(self, stamp: int) -> int | None:
        """Stamp of the first frame later than a time; None: there is none."""
        found = next(self._recording.messages(stamp + 1, channels=self._frames), None)
        return found.stamp if found is not None else None

    def press(self, _key: str, _stamp: int) -> bool:
        """No key means anything."""
        return False

    def check(self, seconds: float) -> None:
        """Look for damage for a time [s]; `faults` has it."""
        self._recording.check(seconds)

    def overview(self) -> Overview:
        """What happened."""
        with RecordingSet.open(self._paths, unpacked=self._unpacked) as recording:
            return survey(recording)

    def close(self) -> None:
        """Close the file."""
        self._recording.close()


class _Moment:
    """All that is known at a moment of a recording; it goes on message by message."""

    def __init__(self, recording: RecordingSet, decoder: Decoder) -> None:
        self._recording = recording
        self._decoder = decoder
        self._layouts = LoggedLayouts(recording)
        self._started: tuple[LayoutSpec, ConsoleState] | None = None
        self._forget()

    def _forget(self) -> None:
        self._layout: LayoutSpec | None = None
        self._opened = 0
        self._terminal = TerminalRecord()
        self._fields: dict[str, Any] = {}
        self._links: dict[tuple[str, int], LinkState] = {}
        self._topics: dict[str, str] = {}
        self._messages: defaultdict[str, dict[int, LoggedMessage]] = defaultdict(dict)
        self._absent: dict[str, set[int]] = {}
        self._known: dict[tuple[str, int], tuple[str, Received[Any]]] = {}

    def begin(self, stamp: int) -> None:
        """Go to a moment: take the newest message of each topic at or before it."""
        self._forget()
        newest = self._recording.newest(stamp)
        for message in sorted(newest.values(), key=lambda each: each.stamp):
            self.frame(message, build=False)

    def frame(self, message: LoggedMessage, *, build: bool = True) -> ReplayFrame | None:
        """Take a message; returns the frame that it is."""
        topic = self._recording.channels[message.channel]
        parts = topic.name.split("/")
        if len(parts) < 3 or parts[1] != "console":
            if message.number and topic.robot:
                self._messages[topic.robot][message.number] = message
            return None
        if not build and topic.message == RUNE_FRAME.name:
            return None
        value = self._decoder.value(message)
        if isinstance(value, FrameRecord):
            return self._frame(message.stamp, value)
        if isinstance(value, StateRecord):
            self._take_field(value)
        elif isinstance(value, LinkRecord):
            self._links[value.robot, value.number] = link_state(value)
            self._topics[value.robot] = value.topic
        elif isinstance(value, LayoutRecord):
            self._opened = message.stamp
            self._layout = self._layouts.open(value)
        elif isinstance(value, TerminalRecord):
            self._terminal = value
        return None

    def _take_field(self, record: StateRecord) -> None:
        hints = _state_hints()
        if record.field not in hints:
            return
        try:
            value = from_json(hints[record.field], record.value)
        except LogError as error:
            self._note(f"the state's {record.field} is left out: {error}")
            return
        if record.field == "theme":
            value = THEMES.get(value.name, value)
        self._fields[record.field] = value

    def _frame(self, stamp: int, record: FrameRecord) -> ReplayFrame | None:
        if self._layout is None:
            self._note("the recorded layout cannot be read; name a layout by --layout")
            return None
        robots = {each.robot: self._robot(stamp, each) for each in record.robots}
        if self._started is None or self._started[0] is not self._layout:
            self._started = self._layout, ConsoleState.at_start(self._layout, record.now)
        state = dataclasses.replace(
            self._started[1],
            now=record.now,
            clock=record.clock,
            display=record.display,
            robots=robots,
            **self._fields,
        )
        across, down = self._terminal.pixels_across, self._terminal.pixels_down
        return ReplayFrame(
            stamp=stamp,
            state=state,
            layout=self._layout,
            opened=self._opened,
            pixels_per_cell=(max(1, across), max(2, down)),
            size=(record.columns, record.rows),
            arranged=record.arranged,
            slow={each.viewport: each.took_s for each in record.slow},
            checksum=record.crc32 if record.drawn else None,
        )

    def _robot(self, stamp: int, record: FrameRobot) -> RobotState:
        topic = self._topics.get(record.robot, record.robot)
        messages, wanted = self._messages[topic], _numbers_of(record)
        missing = wanted - messages.keys() - self._absent.get(topic, set())
        if missing or (record.robot, record.link) not in self._links:
            self._search(stamp, record, topic, missing)
        newest = max(wanted, default=0)
        for number in [each for each in messages if each not in wanted and each < newest]:
            del messages[number]
            self._known.pop((topic, number), None)
        pictures = {
            each.camera: self._received(topic, each.number, each.interval_s)
            for each in record.pictures
        }
        return RobotState(
            name=record.robot,
            link=self._links.get((record.robot, record.link), _UNKNOWN_LINK),
            picture=_value(pictures.pop("", None)),
            pictures={name: each[1] for name, each in pictures.items() if each is not None},
            map=_value(self._received(topic, record.map)),
            messages=dict(
                found
                for number in record.messages.tolist()
                if (found := self._received(topic, number)) is not None
            ),
            diagnostics={
                publisher: found[1]
                for number, publisher in zip(
                    record.diagnostics.tolist(), record.publishers.tolist(), strict=False
                )
                if (found := self._received(topic, number)) is not None
            },
        )

    def _received(
        self, topic: str, number: int, interval_s: float = 0.0
    ) -> tuple[str, Received[Any]] | None:
        """A message of a robot with its name; None: the recording lacks it."""
        known = self._known.get((topic, number))
        if known is not None:
            return known
        message = self._messages[topic].get(number)
        if message is None:
            return None
        received = self._decoder.received(message, number, interval_s)
        if received is None:
            return None
        found = self._recording.channels[message.channel].message, received
        self._known[topic, number] = found
        return found

    def _search(self, stamp: int, record: FrameRobot, topic: str, missing: set[int]) -> None:
        """Find messages that are not the newest of their topic."""
        channels = {
            number
            for number, each in self._recording.channels.items()
            if each.robot == topic or each.message == RUNE_LINK.name
        }
        start = max(0, stamp - _SEARCHED_NS)
        for message in self._recording.messages(start, stamp, channels, reverse=True):
            if (
                message.number in missing
                and self._recording.channels[message.channel].robot == topic
            ):
                self._messages[topic].setdefault(message.number, message)
                missing.discard(message.number)
            elif self._recording.channels[message.channel].message == RUNE_LINK.name:
                value = self._decoder.value(message)
                if isinstance(value, LinkRecord):
                    self._links.setdefault((value.robot, value.number), link_state(value))
                    self._topics.setdefault(value.robot, value.topic)
            if not missing and (record.robot, record.link) in self._links:
                return
        if missing:
            self._absent.setdefault(topic, set()).update(missing)
            self._note(f"{record.robot}: some messages of frames are not in the recording")

    def _note(self, fault: str) -> None:
        if fault not in self._decoder.faults:
            self._decoder.faults.append(fault)


def link_state(record: LinkRecord) -> LinkState:
    """The state of a link in a record."""
    try:
        phase = LinkPhase[record.phase]
        lacking = {
            each.capability: Lack(kind=LackKind[each.kind], why=each.why) for each in record.lacking
        }
    except KeyError:
        phase, lacking = LinkPhase.LOST, {}
    return LinkState(
        phase=phase,
        number=record.console,
        lacking=lacking,
        unfit={each.message: each.why for each in record.unfit},
        **{name: getattr(record, name) for name in _SAME},
    )


_UNKNOWN_LINK = LinkState(phase=LinkPhase.CONNECTING, since=0.0, endpoint="")


def _value(found: tuple[str, Received[Any]] | None) -> Received[Any] | None:
    return found[1] if found is not None else None


def _numbers_of(record: FrameRobot) -> set[int]:
    """The received numbers of all messages of a robot in a frame."""
    numbers = {*record.messages.tolist(), *record.diagnostics.tolist(), record.map}
    return (numbers | {each.number for each in record.pictures}) - {0}


@functools.cache
def _state_hints() -> Mapping[str, Any]:
    return typing.get_type_hints(ConsoleState)
