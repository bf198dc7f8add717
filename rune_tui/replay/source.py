"""What can be replayed: frames by time. Every kind of recording is read into this form."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from hub.values import dataclass
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayFrame:
    """A frame of a recording: what to draw.

    Attributes:
        stamp: Its time [ns since 1970].
        state: The state; the view adds `places`, `attention` and `rows`.
        layout: The layout that shows it.
        opened: Counts the layouts that were opened before; each has memories of its own.
        pixels_per_cell: Pixels of a picture across and down a cell.
        size: Columns and rows of the console that drew it [cells]; None: it was never drawn.
        arranged: How often that console had placed the viewports.
        slow: Processor time of its slow drawings [s], by viewport.
        checksum: Checksum of its cells; None: it was never drawn, or nothing changed.
    """

    stamp: int
    state: ConsoleState
    layout: LayoutSpec
    opened: int = 0
    pixels_per_cell: tuple[int, int] = (1, 2)
    size: tuple[int, int] | None = None
    arranged: int = 0
    slow: Mapping[str, float]
    checksum: int | None = None


class EventKind(enum.Enum):
    """What a timeline shows; the value is its letter.

    Attributes:
        FREEZE: A probe stopped the trial.
        ALARM: A problem that the operator must answer.
        VICTIM: A mark on the map.
        BUMP: The robot touched something.
        TRIAL: A step of a study begins or ends.
        NOTE: A mark of a person.
    """

    FREEZE = "F"
    ALARM = "!"
    VICTIM = "V"
    BUMP = "B"
    TRIAL = "|"
    NOTE = "·"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayEvent:
    """Something at a moment of a recording.

    Attributes:
        stamp: When [ns since 1970].
        kind: What.
        text: One sentence.
        robot: Whose; empty: of no robot.
    """

    stamp: int
    kind: EventKind
    text: str = ""
    robot: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """A part of a recording.

    Attributes:
        start: Its begin [ns since 1970].
        end: Its end [ns since 1970].
        robot: Whose; empty: of no robot.
    """

    start: int
    end: int
    robot: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Overview:
    """What a timeline shows of a recording.

    Attributes:
        events: In the order of time.
        episodes: When the operator interacted with each robot.
        gaps: Where the recording has nothing.
    """

    events: Sequence[ReplayEvent] = ()
    episodes: Sequence[Span] = ()
    gaps: Sequence[Span] = ()


def with_notes(overview: Overview, notes: Sequence[ReplayEvent]) -> Overview:
    """An overview with further events."""
    events = sorted([*overview.events, *notes], key=lambda event: event.stamp)
    return dataclasses.replace(overview, events=events)


class ReplaySource(Protocol):
    """A recording, or several on one time line, as frames.

    Attributes:
        title: Its name for people.
        start: Stamp of the first frame [ns since 1970].
        end: Stamp of the last frame [ns since 1970].
        holes: Long times without frames, which videos and playing skip: begin and end [ns].
    """

    title: str
    start: int
    end: int
    holes: Sequence[tuple[int, int]]

    @property
    def faults(self) -> Sequence[str]:
        """What cannot be shown, and why, in sentences; it grows while frames are read."""

    def check(self, seconds: float) -> None:
        """Look for damage for a time [s]; `faults` has it."""

    def frames(self, after: int, until: int, apart: int = 0) -> Iterator[ReplayFrame]:
        """Some or all frames, in the order of time.

        Args:
            after: They are later than this [ns].
            until: They are not later than this [ns].
            apart: Least time from `after` to the first, and between two [ns]; 0: all frames.
        """

    def frame_before(self, stamp: int) -> int | None:
        """Stamp of the newest frame at or before a time; None: there is none."""

    def frame_after(self, stamp: int) -> int | None:
        """Stamp of the first frame later than a time; None: there is none."""

    def press(self, key: str, stamp: int) -> bool:
        """Handle a key at a time; returns whether frames are other ones now."""

    def overview(self) -> Overview:
        """What happened; reads the whole recording, in another thread if wanted."""

    def close(self) -> None:
        """Close its files."""
