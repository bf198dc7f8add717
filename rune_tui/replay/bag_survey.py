"""What happened in a recording of another robot, for its timeline.

| mark | when |
| --- | --- |
| `!` | a part becomes faulty by its diagnostics, a log has an error, the battery becomes low |
| `B` | a bumper is pressed |
| hatched | no topic has a message for `GAP_NS` |
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from hub.gcm.diagnostics import Severity
from hub.plain_text import plain
from hub.recording.chunks import LoggedMessage
from hub.recording.ros.batteries import battery_readers
from hub.recording.ros.topic_roles import RosRole
from hub.recording.ros.topic_values import TopicMessages, TopicValues
from hub.ros import messages
from hub.ros.values import RosValue
from rune_tui.replay.source import EventKind, Overview, ReplayEvent, Span
from rune_tui.replay.survey import AGAIN_NS, GAP_NS, SECOND
from rune_tui.visualizers.words.status_words import LOW_BATTERY

MOST_EVENTS: Final = 2_000
_CHARGED: Final = LOW_BATTERY + 0.05
"""A battery that is charged up to here may become low again."""
_QUIET_NS: Final = 10 * SECOND
"""Time without a sentence of a log after which it is a new event [ns]."""
_LONGEST: Final = 200
_ERRORS: Final = {"rosgraph_msgs": 8}
"""The least level of an error in a log, by package; in others it is 40."""


def bag_survey(bag: TopicMessages) -> Overview:
    """Read a whole recording."""
    found = _BagEvents(bag)
    busiest = max(bag.channels, key=lambda each: bag.counts.get(each, 0), default=None)
    channels = found.channels | ({busiest} if busiest is not None else set())
    gaps: list[Span] = []
    before = bag.start
    for message in bag.messages(channels=channels):
        if message.stamp - before > GAP_NS:
            gaps += _gaps(bag, before, message.stamp)
        before = max(before, message.stamp)
        found.take(message)
    if bag.end - before > GAP_NS:
        gaps += _gaps(bag, before, bag.end)
    return Overview(events=found.events, gaps=gaps)


def _gaps(bag: TopicMessages, start: int, end: int) -> Iterator[Span]:
    """Where no topic at all has a message."""
    before = start
    for message in bag.messages(start + 1, end):
        if message.stamp - before > GAP_NS:
            yield Span(start=before, end=message.stamp)
        before = message.stamp


class _BagEvents:
    """What was found until now.

    Attributes:
        channels: The topics that say something of events.
        events: In the order of time.
    """

    def __init__(self, bag: TopicMessages) -> None:
        self.events: list[ReplayEvent] = []
        self._values = values = TopicValues(bag)
        readers: Mapping[RosRole, Callable[[LoggedMessage, RosValue], None]] = {
            RosRole.PROBLEMS: self._problems,
            RosRole.LOG: self._log,
            RosRole.BATTERY: self._battery,
            RosRole.BUMPER: self._bumper,
        }
        self._readers = {
            each.channel: reader
            for role, reader in readers.items()
            for each in values.of_role(role)
        }
        self.channels = self._readers.keys()
        self._batteries = battery_readers(bag, values)
        self._faulty: set[tuple[int, str]] = set()
        self._written: dict[str, int] = {}
        self._low: set[int] = set()
        self._pressed: dict[int, int] = {}

    def take(self, message: LoggedMessage) -> None:
        """Take the next message."""
        reader = self._readers.get(message.channel)
        if reader is not None:
            self._values.converted(message, lambda value: reader(message, value))

    def _problems(self, message: LoggedMessage, value: RosValue) -> None:
        for each in value.get("status"):
            name = str(each.get("name"))
            key = message.channel, name[:_LONGEST]
            if int(each.get("level")) & 0xFF < Severity.ERROR:
                self._faulty.discard(key)
            elif key not in self._faulty and len(self._faulty) < MOST_EVENTS:
                self._faulty.add(key)
                self._note(message.stamp, EventKind.ALARM, f"{name}: {each.get('message')}")

    def _log(self, message: LoggedMessage, value: RosValue) -> None:
        package = value.name.partition("/")[0]
        if int(value.get("level")) < _ERRORS.get(package, 40):
            return
        text = f"{value.get('name')}: {value.get('msg')}"[:_LONGEST]
        known = self._written.get(text)
        if known is None and len(self._written) >= MOST_EVENTS:
            return
        self._written[text] = message.stamp
        if known is None or message.stamp - known > _QUIET_NS:
            self._note(message.stamp, EventKind.ALARM, text)

    def _battery(self, message: LoggedMessage, value: RosValue) -> None:
        reader = self._batteries[message.channel]
        doubted, share = bool(reader.doubt), reader.read(value).percentage
        if reader.doubt and not doubted:
            self._note(message.stamp, EventKind.ALARM, f"battery: {reader.doubt}")
        if share >= _CHARGED:
            self._low.discard(message.channel)
        elif share < LOW_BATTERY and message.channel not in self._low:
            self._low.add(message.channel)
            text = f"the battery is low: {round(100 * share)} %"
            self._note(message.stamp, EventKind.ALARM, text)

    def _bumper(self, message: LoggedMessage, value: RosValue) -> None:
        if messages.is_touched(value):
            last = self._pressed.get(message.channel, -AGAIN_NS)
            self._pressed[message.channel] = message.stamp
            if message.stamp - last >= AGAIN_NS:
                self._note(message.stamp, EventKind.BUMP, "the robot touches something")

    def _note(self, stamp: int, kind: EventKind, text: str) -> None:
        if len(self.events) < MOST_EVENTS:
            self.events.append(ReplayEvent(stamp=stamp, kind=kind, text=plain(text[:_LONGEST])))
