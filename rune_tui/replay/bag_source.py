"""A recording of ROS 2 as frames: what Rune knows shown as its own, and all topics as a tree.

Frames are `STEP_NS` apart, where messages came shortly before them. A pause in the recording, as
after a jump of its clock, has none.
"""

from __future__ import annotations

import dataclasses
import datetime
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from hub.gcm.vision import CAMERA_STATE
from hub.plain_text import plain
from hub.recording.chunks import LoggedMessage
from hub.recording.recording_set import RecordingSet
from hub.recording.ros.fields import FieldSeries, field_rows, first_field
from hub.recording.ros.robot import RosPicture, RosRobot, RosScene
from hub.recording.ros.topic_roles import RosRole
from hub.recording.ros.topic_values import ShownMessage
from rune_tui.errors import LayoutError, LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.model.topics import TOPICS, NumberSeries, TopicEntry, TopicField, Topics
from rune_tui.replay.bag_layout import bag_layout
from rune_tui.replay.bag_pictures import BagPicture
from rune_tui.replay.bag_survey import bag_survey
from rune_tui.replay.source import Overview, ReplayFrame
from rune_tui.replay.topic_choice import TopicChoice
from rune_tui.startup.opening import open_layout

STEP_NS: Final = 100_000_000
"""Time from a frame to the next [ns]."""
_AFTER: Final = 50
"""Frames after the last message, which show that it grows old."""
_FIRST_S: Final = 1000.0
"""The console's clock at the first message [s]."""
_SECOND: Final = 1_000_000_000


class BagSource:
    """A recording; see `ReplaySource`."""

    def __init__(
        self,
        recording: RecordingSet,
        layout: LayoutSpec | None = None,
        choice: TopicChoice | None = None,
    ) -> None:
        """Look at what is in a recording.

        Args:
            recording: The recording, which `close` closes.
            layout: A layout that shows it; None: one that is made from what is in it.
            choice: The topic that is looked at; None: the first one with numbers.

        Raises:
            LogError: It has no messages, or no layout can be made.
        """
        path = recording.path
        self.title = path.name or str(path)
        self._bag = bag = recording
        self._choice = choice or TopicChoice()
        if not bag.end:
            reason = f"{path} has no messages"
            raise LogError(reason)
        self._robot = RosRobot(bag, path.stem or "robot")
        self.start, self.end = bag.start, self._after(bag.end)
        self.holes = bag.holes
        self._pictures: dict[str, tuple[LoggedMessage, Received[Picture]]] = {}
        self._picture_faults: list[str] = []
        self._series: tuple[tuple[int, str, float], FieldSeries] | None = None
        self._names = {topic.name: channel for channel, topic in bag.channels.items()}
        self._first_fields: dict[str, str] = {}
        self._entries = tuple(self._topic_entries())
        self._layout = layout or self._made_layout()
        self._at = -1

    @property
    def faults(self) -> list[str]:
        """What cannot be shown, and why, in sentences."""
        return [*self._bag.faults, *self._robot.values.faults, *self._picture_faults]

    def frames(self, after: int, until: int, apart: int = 0) -> Iterator[ReplayFrame]:
        """Some or all frames, in the order of time; see `ReplaySource`."""
        free = after + apart
        for stamp in self._taken(after, until):
            if stamp >= free:
                free = stamp + apart
                yield self._frame(stamp)
        self._at = until

    def _taken(self, after: int, until: int) -> Iterator[int]:
        """The times of frames; at each, the messages before it are taken."""
        if self._at != after:
            self._robot.seek(after)
        self._at = -1
        begin = self._newest_before(after)
        due = self._after(after + 1)
        last = due - STEP_NS if begin is None else self._after(begin)
        for message in self._bag.messages(after + 1, until):
            frame = self._after(message.stamp)
            yield from range(due, min(frame, last + (_AFTER + 1) * STEP_NS), STEP_NS)
            due, last = max(due, frame), frame
            self._robot.take(message)
        yield from range(due, min(until, last + _AFTER * STEP_NS, self.end) + 1, STEP_NS)

    def frame_before(self, stamp: int) -> int | None:
        """Stamp of the newest frame at or before a time; None: there is none."""
        newest = self._newest_before(stamp)
        if newest is None or stamp < self.start:
            return None
        here = self._after(stamp) if self._after(stamp) == stamp else self._after(stamp) - STEP_NS
        if here < newest:  # its frame is later than the time
            earlier = self._newest_before(here)
            if earlier is None:
                return None
            return min(here, self._after(earlier) + _AFTER * STEP_NS)
        return min(here, self._after(newest) + _AFTER * STEP_NS, self.end)

    def frame_after(self, stamp: int) -> int | None:
        """Stamp of the first frame later than a time; None: there is none."""
        due = self._after(stamp + 1)
        if due > self.end:
            return None
        newest = self._newest_before(due)
        if newest is not None and due <= self._after(newest) + _AFTER * STEP_NS:
            return due
        later = next(self._bag.messages(due), None)
        return self._after(later.stamp) if later is not None else None

    def check(self, seconds: float) -> None:
        """Look for damage for a time [s]; `faults` has it."""
        self._bag.check(seconds)

    def overview(self) -> Overview:
        """What happened; reads the whole recording."""
        return bag_survey(self._bag)

    def press(self, key: str, stamp: int) -> bool:
        """Handle a key at a time of the recording; returns whether it means something."""
        fields = [
            each.path for each in self._read_fields(self._chosen_message(stamp)) if each.numeric
        ]
        choice = self._choice
        choice.topic = choice.topic if choice.topic in self._names else self._first_topic()
        choice.field = choice.field or self._first_field(choice.topic)
        return choice.press(key, [each.name for each in self._entries], fields)

    def close(self) -> None:
        """Close the files."""
        self._bag.close()

    def _newest_before(self, stamp: int) -> int | None:
        """Stamp of the newest message at or before a time."""
        found = next(self._bag.messages(end=stamp, reverse=True), None)
        return found.stamp if found is not None else None

    def _after(self, stamp: int) -> int:
        """The first moment of frames at or after a time."""
        return stamp + (self._bag.start - stamp) % STEP_NS

    def _seconds(self, stamp: int) -> float:
        """A time on the console's clock [s]."""
        return _FIRST_S + (stamp - self._bag.start) / _SECOND

    def _number(self, stamp: int) -> int:
        """The number of a message: equal after any jump."""
        return stamp - self._bag.start + 1

    def _received(self, shown: ShownMessage) -> Received[Any]:
        measured = self._seconds(shown.stamp)
        return Received(value=shown.value, measured=measured, number=self._number(shown.stamp))

    def _frame(self, stamp: int) -> ReplayFrame:
        scene = self._robot.scene()
        name = self._layout.robots[0].name
        state = ConsoleState.at_start(self._layout, self._seconds(stamp))
        state = dataclasses.replace(
            state, clock=_clock_text(stamp), robots={name: self._state_of(name, scene, stamp)}
        )
        return ReplayFrame(stamp=stamp, state=state, layout=self._layout, slow={})

    def _state_of(self, name: str, scene: RosScene, stamp: int) -> RobotState:
        link = LinkState(phase=LinkPhase.CONNECTED, since=_FIRST_S, endpoint=self.title)
        messages = {key: self._received(shown) for key, shown in scene.messages.items()}
        pictures = {key: self._picture(each) for key, each in scene.pictures.items()}
        main = self._robot.cameras[0].name if self._robot.cameras else ""
        picture = pictures.pop(main, None)
        if picture is not None:
            messages[CAMERA_STATE.name] = Received(
                value=picture.value.camera, measured=picture.measured, number=picture.number
            )
        messages[TOPICS] = Received(
            value=self._topics(stamp), measured=self._seconds(stamp), number=self._number(stamp)
        )
        return RobotState(
            name=name,
            link=link,
            picture=picture,
            pictures=pictures,
            map=self._received(scene.map) if scene.map is not None else None,
            messages=messages,
            diagnostics={key: self._received(each) for key, each in scene.problems.items()},
        )

    def _picture(self, source: RosPicture) -> Received[Picture]:
        """A picture; the same one for the same message, so that it is decoded once."""
        known = self._pictures.get(source.camera)
        if known is not None and known[0] is source.message:
            return known[1]
        stamp = source.message.stamp
        made: Received[Picture] = Received(
            value=BagPicture(source, min(1e10, stamp / _SECOND), self._picture_faults),
            measured=self._seconds(stamp),
            number=self._number(stamp),
        )
        self._pictures[source.camera] = source.message, made
        return made

    def _topic_entries(self) -> Iterator[TopicEntry]:
        seconds = (self._bag.end - self._bag.start) / _SECOND
        faults = self._robot.values.unreadable
        for channel, topic in sorted(self._bag.channels.items(), key=lambda each: each[1].name):
            count = self._bag.counts.get(channel, -1)
            yield TopicEntry(
                name=plain(topic.name),
                kind=plain(topic.schema_name or topic.encoding),
                count=count,
                rate_hz=(count - 1) / seconds if count > 1 and seconds > 0.0 else math.nan,
                trouble=faults.get(channel, ""),
            )

    def _first_topic(self) -> str:
        """The first topic with numbers; else the first one."""
        names = (name for name in sorted(self._names) if self._first_field(name))
        return next(names, min(self._names, default=""))

    def _first_field(self, topic: str) -> str:
        if topic not in self._first_fields:
            channel = self._names.get(topic, -1)
            decoder = self._robot.values.decoders.get(channel)
            self._first_fields[topic] = first_field(self._bag, channel, decoder)
        return self._first_fields[topic]

    def _chosen_message(self, stamp: int) -> LoggedMessage | None:
        """The newest message of the chosen topic at a time."""
        channel = self._names.get(self._choice.topic or self._first_topic(), -1)
        return self._bag.newest(stamp, {channel}).get(channel)

    def _topics(self, stamp: int) -> Topics:
        choice, values = self._choice, self._robot.values
        topic = choice.topic if choice.topic in self._names else self._first_topic()
        channel = self._names.get(topic, -1)
        path = choice.field or self._first_field(topic)
        newest = values.newest.get(channel)
        seconds = choice.seconds
        return Topics(
            entries=self._entries,
            chosen=topic,
            newest=self._number(newest.stamp) if newest is not None else 0,
            age_s=(stamp - newest.stamp) / _SECOND if newest is not None else math.nan,
            field=path,
            seconds=seconds,
            read_fields=lambda: self._read_fields(newest),
            read_series=lambda: self._read_series(channel, path, seconds, stamp),
        )

    def _read_fields(self, message: LoggedMessage | None) -> tuple[TopicField, ...]:
        value = self._robot.values.decoded(message) if message is not None else None
        if value is None:
            return ()
        return tuple(
            TopicField(path=row.path, text=row.text, numeric=math.isfinite(row.number))
            for row in field_rows(value)
        )

    def _read_series(self, channel: int, path: str, seconds: float, stamp: int) -> NumberSeries:
        decoder = self._robot.values.decoders.get(channel)
        if decoder is None or not path:
            return NumberSeries(times=np.empty(0), values=np.empty(0))
        key = channel, path, seconds
        if self._series is None or self._series[0] != key:
            span = round(seconds * _SECOND)
            self._series = key, FieldSeries(self._bag, channel, decoder, path, span)
        found = self._series[1].until(stamp)
        times = np.array([self._seconds(each) for each, _ in found])
        return NumberSeries(times=times, values=np.array([value for _, value in found]))

    def _made_layout(self) -> LayoutSpec:
        values = self._robot.values
        roles = frozenset(each.role for each in values.of_role(*RosRole))
        text = bag_layout(self._robot.cameras, roles)
        with tempfile.TemporaryDirectory(prefix="rune-replay-") as folder:
            path = Path(folder) / "recording.xml"
            path.write_text(text, "utf-8")
            try:
                layout = open_layout(path)
            except LayoutError as error:
                reason = f"no layout can be made for {self.title}; name one by --layout: {error}"
                raise LogError(reason) from error
        return dataclasses.replace(layout, path=f"made for {self.title}", files=())


def _clock_text(stamp: int) -> str:
    """The time of day here."""
    try:
        moment = datetime.datetime.fromtimestamp(stamp / _SECOND, datetime.UTC).astimezone()
    except (OverflowError, ValueError, OSError):
        return ""
    return f"{moment:%H:%M:%S}"
