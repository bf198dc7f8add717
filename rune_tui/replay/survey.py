"""What happened in a recording, for its timeline."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from hub.gcm.mapping import INTEREST_POINTS, InterestPoints
from hub.gcm.navigation import ROBOT_STATE, RobotState
from hub.gcm.recording import RECORD_MARK, RecordMark
from hub.recording.anchor import TimeAnchor
from hub.recording.recording_set import RecordingSet
from rune_tui.model.held_inputs import HeldInputs
from rune_tui.model.own_records import (
    RUNE_INPUT,
    RUNE_SELECT,
    InputOutcome,
    InputRecord,
    Selection,
    SelectRecord,
)
from rune_tui.model.study_records import (
    RUNE_PROBE,
    RUNE_SECONDARY,
    RUNE_STUDY,
    ProbeRecord,
    SecondaryRecord,
    StudyRecord,
)
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent, TeamEventKind
from rune_tui.replay.logged_values import Decoder
from rune_tui.replay.source import EventKind, Overview, ReplayEvent, Span

SECOND: Final = 1_000_000_000
PAUSE_NS: Final = 2 * SECOND
"""Time without an input of a robot that ends an episode of interaction [ns]."""
LEAST_NS: Final = SECOND // 2
"""Length of an episode of one input [ns]."""
GAP_NS: Final = 2 * SECOND
"""Time without any message that is a gap [ns]."""
AGAIN_NS: Final = SECOND
"""Time after a bump in which contact is the same bump [ns]."""
_READ = tuple(
    each.name
    for each in (
        RUNE_INPUT,
        RUNE_SELECT,
        RUNE_TEAM,
        INTEREST_POINTS,
        ROBOT_STATE,
        RECORD_MARK,
        RUNE_STUDY,
        RUNE_PROBE,
        RUNE_SECONDARY,
    )
)
_STUDY_EVENTS = {
    "trial-begin": EventKind.TRIAL,
    "trial-end": EventKind.TRIAL,
    "frozen": EventKind.FREEZE,
    "unfrozen": EventKind.FREEZE,
    "withheld": EventKind.NOTE,
    "allowed": EventKind.NOTE,
    "order": EventKind.NOTE,
}
"""Records of a study's session that the timeline shows."""


def survey(recording: RecordingSet) -> Overview:
    """Read a whole recording."""
    decoder = Decoder(recording.channels, TimeAnchor(0, 0.0), [])
    found = _Survey()
    channels = {channel for channel, topic in recording.channels.items() if topic.message in _READ}
    busiest = max(recording.channels, key=lambda each: recording.counts.get(each, 0), default=None)
    if busiest is not None:
        channels.add(busiest)
    before = recording.start
    gaps = []
    for message in recording.messages(channels=channels):
        topic = recording.channels[message.channel]
        if message.stamp - before > GAP_NS:
            gaps.append(Span(start=before, end=message.stamp))
        before = max(before, message.stamp)
        if topic.message in _READ:
            found.take(message.stamp, topic.robot, decoder.value(message))
    events = sorted(found.events, key=lambda event: event.stamp)
    return Overview(events=events, episodes=tuple(found.episodes(before)), gaps=gaps)


class _Survey:
    """What was found until now."""

    def __init__(self) -> None:
        self.events: list[ReplayEvent] = []
        self._inputs: dict[str, list[Span]] = {}
        self._held = HeldInputs()
        self._points: dict[str, set[int]] = {}
        self._pressed: dict[str, int] = {}
        self._bumped: dict[str, int] = {}
        self._begun: set[str] = set()  # robots whose states have begun

    def take(self, stamp: int, robot: str, value: Any) -> None:  # noqa: ANN401 - any message
        match value:
            case InputRecord() | SelectRecord():
                self._input(stamp, value)
            case TeamEvent(kind=TeamEventKind.RAISED, cause="state") if self._begins(value.robot):
                pass  # the console waits for the first state
            case TeamEvent(kind=TeamEventKind.RAISED):
                self._note(stamp, EventKind.ALARM, value.cause, value.robot)
            case RecordMark():
                self._note(stamp, EventKind.NOTE, value.text, robot)
            case InterestPoints():
                self._marks(stamp, robot, value)
            case StudyRecord():
                self._study(stamp, value)
            case ProbeRecord():
                said = "right" if value.correct else "wrong"
                self._note(stamp, EventKind.NOTE, f"{value.id}: {said}", "")
            case SecondaryRecord() if value.counts:
                said = "right" if value.correct else "wrong" if value.answer else "missed"
                self._note(stamp, EventKind.NOTE, f"{value.text}: {said}", "")
            case RobotState():
                self._bump(stamp, robot, value.bumpers)

    def episodes(self, end: int) -> Iterator[Span]:
        """When the operator interacted with each robot; inputs may be down up to `end` [ns]."""
        for held in self._held.until(end):
            self._worked(Span(start=int(held.begin), end=int(held.end), robot=held.robot))
        for robot, parts in self._inputs.items():
            first, *others = sorted(parts, key=lambda part: part.start)
            begin, last = first.start, first.end
            for part in others:
                if part.start - last > PAUSE_NS:
                    yield Span(start=begin, end=max(last, begin + LEAST_NS), robot=robot)
                    begin = part.start
                last = max(last, part.end)
            yield Span(start=begin, end=max(last, begin + LEAST_NS), robot=robot)

    def _input(self, stamp: int, record: InputRecord | SelectRecord) -> None:
        if isinstance(record, SelectRecord):
            if record.what is Selection.FOCUS and not record.on:
                self._held.focus_lost(stamp)
            return
        self._held.take(stamp, record)
        if record.robot and record.outcome is not InputOutcome.NONE:
            self._worked(Span(start=stamp, end=stamp, robot=record.robot))

    def _worked(self, part: Span) -> None:
        self._inputs.setdefault(part.robot, []).append(part)

    def _study(self, stamp: int, record: StudyRecord) -> None:
        kind = _STUDY_EVENTS.get(record.what)
        if kind is not None:
            words = f"{record.step} {record.what.replace('-', ' ')}"
            self._note(stamp, kind, words, "")

    def _marks(self, stamp: int, robot: str, value: InterestPoints) -> None:
        known = self._points.get(robot)
        numbers = {point.number for point in value.points}
        self._points[robot] = numbers | (known or set())
        for point in value.points:
            if known is not None and point.number not in known:
                text = f"{point.kind.name.lower()} {point.number} marked"
                self._note(stamp, EventKind.VICTIM, text, robot)

    def _begins(self, robot: str) -> bool:
        """Whether a robot has no state yet; true once for each robot."""
        begins = robot not in self._begun
        self._begun.add(robot)
        return begins

    def _bump(self, stamp: int, robot: str, bumpers: int) -> None:
        self._begun.add(robot)
        rose = bumpers and not self._pressed.get(robot, 0)
        self._pressed[robot] = bumpers
        if rose and stamp - self._bumped.get(robot, -AGAIN_NS) >= AGAIN_NS:
            self._note(stamp, EventKind.BUMP, "the robot touches something", robot)
        if bumpers:
            self._bumped[robot] = stamp

    def _note(self, stamp: int, kind: EventKind, text: str, robot: str) -> None:
        self.events.append(ReplayEvent(stamp=stamp, kind=kind, text=text, robot=robot))
