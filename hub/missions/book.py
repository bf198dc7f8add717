"""The state of a mission, from the records of its journal; pure."""

from __future__ import annotations

from typing import Any

from hub.errors import MissionError
from hub.missions.points import PointBook
from hub.missions.records import (
    MAX_NAME,
    Begun,
    Ended,
    FrameKnown,
    Marked,
    Named,
    Noted,
    Record,
    Removed,
    SheetBegun,
    from_json,
)
from hub.values import dataclass

MAX_EVENTS = 10_000
"""Number of events kept in memory; the journal has all of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """An event.

    Attributes:
        stamp: Its time [s since the epoch].
        text: One sentence.
    """

    stamp: float
    text: str


class MissionBook:
    """The state of one mission; without a `Begun` record, there is no mission.

    Attributes:
        begun: The record of its begin; None: there is no mission, only marks and a sheet.
        name: The operator's name for it.
        ended: The record of its end; None: it runs.
        points: Its marks.
        sheet: Number of the newest sheet of the map.
        frame: Frame of that sheet; 0: not known yet.
        events: Its events, the oldest first.
        unreadable: Number of records that this version of Rune cannot read.
    """

    def __init__(self) -> None:
        self.begun: Begun | None = None
        self.name = ""
        self.ended: Ended | None = None
        self.points = PointBook()
        self.sheet = 1
        self.frame = 0
        self.events: list[Event] = []
        self.unreadable = 0

    def take(self, values: dict[str, Any]) -> None:
        """Apply a record of a journal; a record that is not valid is counted and left out."""
        try:
            self.apply(from_json(values))
        except MissionError:
            self.unreadable += 1

    @property
    def running(self) -> bool:
        """Whether there is a mission without an end."""
        return self.begun is not None and self.ended is None

    def apply(self, record: Record) -> None:
        """Apply a record."""
        match record:
            case Begun():
                self.begun, self.name = record, record.name
                self._note(record.stamp, f"{record.by} began the mission")
            case Named():
                self.name = record.name
                self._note(record.stamp, f"{record.by} named the mission {record.name}")
            case SheetBegun():
                self._begin_sheet(record)
            case FrameKnown():
                self.frame = record.frame
            case Marked():
                point = record.point
                if record.same_thumbnail:
                    point = self.points.with_thumbnail(point)
                self.points.put(point)
                what = f"{point.kind.name.lower()} {point.number}"
                how = f"{point.by} marked {what}" if point.version <= 1 else f"{what} was changed"
                self._note(record.stamp, how)
            case Removed():
                self.points.drop(record.number)
                self._note(record.stamp, f"{record.by} removed point {record.number}")
            case Noted():
                self._note(record.stamp, record.text)
            case Ended():
                self.ended = record
                self._note(record.stamp, f"{record.by} ended the mission")

    def _begin_sheet(self, record: SheetBegun) -> None:
        kept = self.points.points
        self.points.begin_sheet(self.sheet)
        self.sheet, self.frame = record.number, record.frame
        if record.carries:
            for point in kept:
                del self.points.earlier[point.number]
                self.points.put(point)
        self._note(record.stamp, f"sheet {record.number} begins: {record.why}")

    def _note(self, stamp: float, text: str) -> None:
        if len(self.events) < MAX_EVENTS:
            self.events.append(Event(stamp=stamp, text=text))


def checked_mission_name(name: str) -> str:
    """A mission's name as it is kept: one line.

    Raises:
        MissionError: It is empty, or too long.
    """
    line = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    if not 1 <= len(line) <= MAX_NAME:
        text = f"a mission's name has 1 to {MAX_NAME} characters"
        raise MissionError(text)
    return line
