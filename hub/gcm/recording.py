"""Messages of recordings: orders to the robot's recorder, its marks and its state."""

from __future__ import annotations

import enum
from typing import Annotated, TypeAlias

from hub.gcm.fields import Count, Flag, Name, Number, Seconds, SecondsIfKnown, Sentence, Stamp
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.ranges import Most, Range, Text
from hub.ipc.formats.wire_types import FLOAT32, Counted, Uint64, Wire
from hub.values import dataclass

MOST_TOPICS = 100
"""Most topics whose losses are reported; the ones with the most come first."""

Megabytes: TypeAlias = Annotated[float, Range(0.0, 1e12, unit="MB", nearest=True), FLOAT32]
Around: TypeAlias = Annotated[float, Range(0.0, 86_400.0, unit="s")]
FileCount: TypeAlias = Annotated[Count, Wire("uint")]
MessageCount: TypeAlias = Annotated[Uint64, Range(0, 0xFFFF_FFFF_FFFF_FFFF)]


class RecordAction(enum.IntEnum):
    """The order in a `RecordCommand`.

    Attributes:
        START: Begin a recording; refused while one runs.
        STOP: End the recording that runs; its files stay.
        SPLIT: Go on in a new file.
        MARK: Note a moment, in words.
        SNAPSHOT: Keep the time around this moment as a file of its own.
    """

    START = 0
    STOP = 1
    SPLIT = 2
    MARK = 3
    SNAPSHOT = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordCommand:
    """An order to the robot's recorder; answered by `CommonResult`.

    Attributes:
        action: The order.
        name: Name of the recording or the snapshot; empty: date and time.
        text: What a mark or a snapshot is about.
        before_s: Time before this moment that a snapshot has [s].
        after_s: Time after this moment that a snapshot has [s].
        by: The sender's operator, for others to read.
    """

    action: RecordAction = RecordAction.START
    name: Name = ""
    text: Sentence = ""
    before_s: Around = 30.0
    after_s: Around = 10.0
    by: Name = ""


RECORD_COMMAND = MessageDefinition(
    name="GCM_Record_Command",
    type=RecordCommand,
    plane=Plane.COMMAND,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordMark:
    """A moment that an operator marked; it is in the recording like any message.

    Attributes:
        number: Counts the marks of the recorder, from 1.
        text: What it is about; empty: nothing was said.
        by: The operator who marked it.
        stamp: The moment [s since the epoch].
    """

    number: Number = 0
    text: Sentence = ""
    by: Name = ""
    stamp: Stamp = 0.0


RECORD_MARK = MessageDefinition(
    name="GCM_Record_Mark",
    type=RecordMark,
    keep=Keep.ALL,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LostMessages:
    """Messages of one topic that are not in the recording.

    Attributes:
        topic: The topic.
        count: How many since the start of the recorder.
    """

    topic: Annotated[str, Text(128)] = ""
    count: Number = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordState:
    """What the robot's recorder does; sent at each change, on request and once a second.

    Attributes:
        recording: 1: a recording runs; 0: none.
        ring: 1: the last part of all time is kept, without an order; 0: it is not.
        path: The file that is written now, on the robot; empty: none.
        by: The operator who started the recording.
        begun: Start of the recording [s since the epoch]; 0: none.
        running_s: Time since its start [s].
        messages: Messages in its files.
        size_mb: Size of its files [MB].
        files: Number of its files.
        ring_s: How far back the ring reaches [s].
        ring_mb: Size of the ring [MB].
        free_mb: Free space on the disk [MB].
        left_s: Time until the disk is too full, at the present rate [s]; NaN: not known.
        marks: Marks since the start of the recorder.
        mark: Text of the last mark; empty: none, or without words.
        lost: Messages that are in no file: of this or the last recording; before the first one,
            since the start of the recorder.
        lost_by_topic: The same by topic, those with the most first.
        fault: What is not recorded, and the reason; empty: everything is.
    """

    recording: Flag = 0
    ring: Flag = 0
    path: Sentence = ""
    by: Name = ""
    begun: Stamp = 0.0
    running_s: Seconds = 0.0
    messages: MessageCount = 0
    size_mb: Megabytes = 0.0
    files: FileCount = 0
    ring_s: Seconds = 0.0
    ring_mb: Megabytes = 0.0
    free_mb: Megabytes = 0.0
    left_s: SecondsIfKnown = float("nan")
    marks: Number = 0
    mark: Sentence = ""
    lost: Number = 0
    lost_by_topic: Annotated[tuple[LostMessages, ...], Counted(), Most(MOST_TOPICS)] = ()
    fault: Sentence = ""


RECORD_STATE = MessageDefinition(
    name="GCM_Record_State",
    type=RecordState,
    rate_hz=1.0,
)

MESSAGES = (RECORD_COMMAND, RECORD_MARK, RECORD_STATE)
