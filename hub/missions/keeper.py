"""Keeps the running mission, in memory and on the disk."""

from __future__ import annotations

import dataclasses
import math
import os
import time
from collections.abc import Callable
from pathlib import Path

from hub.bucket import Bucket
from hub.errors import MissionError, MissionFileError
from hub.gcm.mapping import InterestPoint, InterestPoints
from hub.gcm.mission import MissionState
from hub.missions.book import MissionBook, checked_mission_name
from hub.missions.folder import MissionFolder
from hub.missions.journal_file import JournalFile
from hub.missions.log_odds import LogOdds
from hub.missions.mark_rates import MarkRates
from hub.missions.pending import Pending, marks_text
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
    to_json,
)
from hub.missions.track import Track
from hub.values import dataclass

NOTES_PER_S, NOTES_AT_ONCE = 0.2, 50.0
"""Largest rate of notes, and their largest burst [1/s]."""
_MB = 1e6


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionLimits:
    """How much of the disk a mission may use.

    Attributes:
        largest_mb: Of one mission [MB]; beyond, map and track are not written.
        least_free_mb: The same if the disk has less free space [MB]; marks are still written.
    """

    largest_mb: float = 500.0
    least_free_mb: float = 50.0


class MissionKeeper:
    """The mission of one robot; calls wait for the disk.

    Attributes:
        book: The state of the mission.
        folder: The folder of the missions.
        id: Name of its folder; empty: none yet.
        opened: Whether the running mission is known; if not, call `open` again.
    """

    def __init__(
        self,
        folder: MissionFolder,
        limits: MissionLimits,
        *,
        clock: Callable[[], float] = time.monotonic,
        calendar: Callable[[], float] = time.time,
    ) -> None:
        """Start; nothing is read yet.

        Args:
            folder: The folder of the missions.
            limits: How much may be written.
            clock: Monotonic time [s].
            calendar: Time since the epoch [s].
        """
        self.book = MissionBook()
        self.id = ""
        self.opened = False
        self.folder = folder
        self._limits = limits
        self._clock, self._calendar = clock, calendar
        self.lock: int | None = None
        self._journal: JournalFile | None = None
        self._track: Track | None = None
        self._pending = Pending()
        self._lost: frozenset[int] = frozenset()
        self._rates = MarkRates()
        self._notes = Bucket(NOTES_PER_S, NOTES_AT_ONCE)
        self._pointer_due = False
        self._faults: dict[str, str] = {}
        self._map_saved = math.nan
        self._size = self._free = 0

    def open(self) -> LogOdds | None:
        """Resume the running mission, if there is one; returns its map if that was saved."""
        self._faults.pop("open", None)
        try:
            self._take_lock()
            mission, damage = self.folder.find_running()
            if damage:
                self._faults["pointer"] = damage
                self.folder.set_running(mission)
            if not mission:
                return None
            book, reading = self.folder.reading(mission)
            if not book.running:
                self.folder.set_running("")
                return None
            journal = JournalFile(self.folder.journal_of(mission), reading)
        except MissionFileError as error:
            self._faults["open"] = str(error)
            return None
        finally:
            self.opened = "open" not in self._faults
        self.book, self.id, self._journal = book, mission, journal
        lost = reading.damaged + book.unreadable
        if lost:
            self._faults["damage"] = f"{lost} records of the journal are damaged and left out"
        return self._open_map()

    def _open_map(self) -> LogOdds | None:
        self._track = Track(self.folder.track_of(self.id))
        self.look()
        try:
            grid = self.folder.grid(self.id, self.book.sheet)
        except MissionFileError as error:
            self._faults["damage"] = str(error)
            return None
        if grid is not None:
            self._map_saved = self._clock()
        return grid

    def close(self) -> None:
        """Close the files."""
        if self._journal is not None:
            self._journal.close()
        if self._track is not None:
            self._track.close()
        if self.lock is not None:
            os.close(self.lock)
        self._journal = self._track = self.lock = None

    def begin(self, name: str, by: str) -> None:
        """Begin a mission. After an ended mission it begins without marks.

        Raises:
            MissionError: One runs already, or the name is not valid.
        """
        if self.book.running:
            text = f"mission {self.book.name} runs already; end it first"
            raise MissionError(text)
        stamp = self._calendar()
        usual = time.strftime("%Y-%m-%d %H:%M", time.localtime(stamp))
        name = checked_mission_name(name or usual)
        frame = self.book.frame
        self._close_mission()
        self.book, self._lost = MissionBook(), frozenset()
        self._record(
            Begun(robot=self.folder.robot, name=name, by=_who(by), stamp=stamp),
            SheetBegun(number=1, frame=frame, carries=False, why="the mission begins", stamp=stamp),
        )

    def name(self, name: str, by: str) -> None:
        """Give the mission another name.

        Raises:
            MissionError: None runs, the name is not valid, or there is no room for it.
        """
        self._demand_running()
        name = checked_mission_name(name)
        self._record(Named(name=name, by=_who(by), stamp=self._calendar()))

    def end(self, by: str) -> str:
        """End the mission, even if the disk fails; marks stay in memory until the next one begins.

        Returns:
            Losses at its end, and the reason; empty: none.

        Raises:
            MissionError: None runs.
        """
        self._demand_running()
        self.flush()
        problems = [self._loss()] if self.unkept else []
        ended = Ended(by=_who(by), stamp=self._calendar())
        try:
            if self._journal is not None:
                self._journal.append([to_json(ended)])
        except MissionFileError as error:
            problems.append(f"the journal does not say that the mission is ended: {error}")
        try:
            self.folder.set_running("")
        except MissionFileError as error:
            problems.append(f"a restart of mapping takes the mission up again: {error}")
        self.book.apply(ended)
        self._close_mission()
        return "; ".join(problems)

    def _loss(self) -> str:
        """Note the losses of an end now; returns them in words."""
        self._lost = self._pending.marks
        which = marks_text(self._lost)
        return f"{self.unkept} changes{which} are not on the disk and lost: {self.fault}"

    def mark(self, point: InterestPoint, by: str, sender: int | None = None) -> InterestPoint:
        """Add a point or change it; a new point begins a mission if none runs.

        A new point that equals a known one is that one, sent again.

        Args:
            point: The point; new if its number is 0.
            by: The operator who marked it, if the point does not have that.
            sender: Number of the client, for the limit of rates; None: no limit.

        Returns:
            The point as stored.

        Raises:
            MissionError: It is refused; the text says why.
        """
        known = self.book.points.same(point, by)
        if known is not None:
            return known
        begins = not self.book.running and not point.number
        if not begins:
            self._demand_not_ended()
        stamp = self._calendar()
        points = PointBook() if begins else self.book.points
        checked = points.checked(point, by, stamp)
        if sender is not None:
            self._rates.check(point.number, sender, self._clock())
        if begins:
            self.begin("", point.by or by)
        same = self.book.points.has_thumbnail(checked)
        self._record(Marked(point=checked, stamp=stamp, same_thumbnail=same))
        return checked

    def remove(self, number: int, version: int, by: str, sender: int | None = None) -> None:
        """Remove a point; version 0 is any.

        Args:
            number: Its number.
            version: The version that the sender has.
            by: The operator who removes it.
            sender: See `mark`.

        Raises:
            MissionError: It is refused; the text says why.
        """
        self._demand_not_ended()
        self.book.points.check_removal(number, version)
        if sender is not None:
            self._rates.check(0, sender, self._clock())
        self._record(Removed(number=number, by=_who(by), stamp=self._calendar()))

    def note(self, text: str) -> None:
        """Note an event, while a mission runs; too many notes are left out."""
        record = Noted(text=text[:500].replace("\0", ""), stamp=self._calendar())
        if self.book.running and not self._refusal(record) and self._notes.take(1.0, self._clock()):
            self._record(record)

    def in_frame(self, frame: int, grid: Callable[[], LogOdds]) -> bool:
        """Take the frame of the robot's poses.

        | frame of the sheet | frame now | then |
        | --- | --- | --- |
        | any | 0 (not reported) | nothing |
        | 0 (not known yet) | any | it is the sheet's |
        | the same | the same | nothing |
        | another | any | a new sheet begins; the old one is saved before |

        Args:
            frame: Its number.
            grid: Gives the present map.

        Returns:
            Whether a new sheet was begun, because the old map does not fit the new frame.
        """
        before = self.book.frame
        if frame in (0, before):
            return False
        if before == 0:
            self._record(FrameKnown(frame=frame))
            return False
        self.save_map(grid())
        self.begin_sheet("the robot has lost its place, its wheels count anew", frame=frame)
        return True

    def begin_sheet(self, why: str, *, frame: int | None = None, carries: bool = False) -> None:
        """Begin a new sheet of the map; the one before stays in the folder.

        Args:
            why: For people.
            frame: Its frame; None: that of the sheet before.
            carries: Whether marks are valid on it too.
        """
        self._record(
            SheetBegun(
                number=self.book.sheet + 1,
                frame=self.book.frame if frame is None else frame,
                carries=carries,
                why=why,
                stamp=self._calendar(),
            )
        )
        self._map_saved = math.nan

    def save_map(self, grid: LogOdds) -> None:
        """Write the newest sheet of the map, and the track so far."""
        if not self.book.running or not self.id:
            return
        if not self._may_write():
            return
        try:
            self.folder.save_grid(self.id, self.book.sheet, grid)
            self._map_saved = self._clock()
            if self._track is not None:
                self._track.save()
            self._faults.pop("map", None)
        except MissionFileError as error:
            self._faults["map"] = str(error)

    def trace(self, x: float, y: float, theta: float) -> None:
        """Note where the robot is now [m, m, rad]; it is written with the map."""
        if self._track is not None and self.book.running:
            self._track.at(x, y, theta, self.book.sheet, self._calendar())

    def flush(self) -> None:
        """Try to write the pending records."""
        if not self._pending and not self._pointer_due:
            return
        try:
            self._take_lock()
            if self._journal is None:
                self._make()
            if self._journal is not None:
                self._pending.write(self._journal)
            if self._pointer_due:
                self.folder.set_running(self.id)
                self._pointer_due = False
            self._faults.pop("journal", None)
        except MissionFileError as error:
            self._faults["journal"] = str(error)

    def look(self) -> None:
        """Check the free space, and retry failed writes; call it regularly."""
        self.flush()
        full = self.book.running and self._refusal(Noted(text="", stamp=0.0))
        if full and not self._pending:
            self._faults["full"] = full
        self._size = self.folder.size(self.id) if self.id else 0
        self._free = self.folder.free()
        self._may_write()

    @property
    def path(self) -> Path:
        """The folder of the mission, or of all missions while it has none."""
        return self.folder.path / self.id

    @property
    def unkept(self) -> int:
        """Number of records in memory only."""
        return len(self._pending) + int(self._pointer_due)

    @property
    def fault(self) -> str:
        """The unstored part, and the reason; empty: all is stored."""
        return "; ".join(self._faults.values())

    @property
    def points(self) -> InterestPoints:
        """The marks of the newest sheet, and which of them are on the disk."""
        waiting = self._pending.marks | self._lost
        safe = self.book.begun is not None and not self._pointer_due
        points = tuple(
            dataclasses.replace(point, kept=int(safe and point.number not in waiting))
            for point in self.book.points.points
        )
        return InterestPoints(points=points)

    @property
    def state(self) -> MissionState:
        """The mission as a message."""
        book, begun = self.book, self.book.begun
        return MissionState(
            id=self.id,
            name=book.name,
            by=begun.by if begun else "",
            running=int(book.running),
            begun=begun.stamp if begun else 0.0,
            running_s=max(0.0, self._calendar() - begun.stamp) if begun else 0.0,
            sheet=book.sheet,
            marks=len(book.points.points),
            earlier=len(book.points.earlier),
            unkept=self.unkept,
            map_age_s=self._clock() - self._map_saved,
            size_mb=self._size / _MB,
            free_mb=min(self._free / _MB, 1e9),
            fault=self.fault,
            folder=str(self.folder.path.absolute()),
        )

    def _record(self, *records: Record) -> None:
        """Apply records, and write them if there is a mission.

        After a fault of the disk, only `look` retries, so a flood of commands costs no more.

        Raises:
            MissionError: There is no room for it; nothing has changed.
        """
        if self.book.running:
            for record in records:
                if why := self._refusal(record):
                    raise MissionError(why)
        for record in records:
            self.book.apply(record)
        if self.book.running:
            self._pending.add(records)
            if "journal" not in self._faults:
                self.flush()

    def _refusal(self, record: Record) -> str:
        """Why a record is refused; empty: it is not."""
        return self._pending.refusal(record, self._journal, self.fault)

    def _demand_running(self) -> None:
        if not self.book.running:
            text = "no mission runs"
            raise MissionError(text)

    def _demand_not_ended(self) -> None:
        """Refuse changes after the end of the mission."""
        if self.book.ended is not None:
            text = f"mission {self.book.name} is ended: its marks stay as they are"
            raise MissionError(text)

    def _make(self) -> None:
        """Make the folder of the mission."""
        begun = self.book.begun
        if begun is None:
            return
        if not self.id:
            self.id = self.folder.make(begun.stamp)
        self._journal = JournalFile(self.folder.journal_of(self.id))
        self._track = Track(self.folder.track_of(self.id))
        self._pointer_due = True

    def _take_lock(self) -> None:
        if self.lock is None:
            self.lock = self.folder.lock()

    def _close_mission(self) -> None:
        if self._journal is not None:
            self._journal.close()
        if self._track is not None:
            self._track.close()
        self._journal = self._track = None
        self.id, self._map_saved = "", math.nan
        self._pending.clear()
        self._pointer_due = False
        self._faults.clear()

    def _may_write(self) -> bool:
        """Whether there is room for map and track."""
        limits, why = self._limits, ""
        if self._free < limits.least_free_mb * _MB:
            why = (
                f"the disk has only {self._free / _MB:.0f} MB left: marks are kept, the map is not"
            )
        elif self._size > limits.largest_mb * _MB:
            why = f"the mission has {self._size / _MB:.0f} MB: marks are kept, the map is not"
        if why and self.book.running:
            self._faults["room"] = why
        else:
            self._faults.pop("room", None)
        return not why


def _who(by: str) -> str:
    return " ".join(by.replace("\0", "").split())[:MAX_NAME] or "somebody"
