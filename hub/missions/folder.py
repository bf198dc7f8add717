"""The missions of one robot on the disk: a folder for each, and which one is running.

ROOT/ROBOT/running is the id of the running mission; ROOT/ROBOT/ID/ has `journal`, `track` and
`sheet-N.grid`.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import time
from pathlib import Path
from typing import Self

from hub import files, paths
from hub.errors import MapFileError, MissionFileError
from hub.missions import journal, journal_file, log_odds
from hub.missions.book import MissionBook
from hub.missions.records import Begun

_ID = re.compile(r"[0-9]{8}-[0-9]{6}(-[0-9]{1,3})?")
_SHEET = re.compile(r"sheet-([0-9]{1,10})\.grid")
_MOST_AT_ONCE = 100
_LONGEST_POINTER = 100


class MissionFolder:
    """The folder of one robot's missions.

    Attributes:
        path: It; made when the first mission is begun.
        robot: The robot's name.
    """

    def __init__(self, root: Path, robot: str) -> None:
        self.path = root / paths.as_file_name(robot)
        self.robot = robot
        self._named = True

    @classmethod
    def of(cls, path: Path) -> Self:
        """The folder of a robot with an unknown name; its journals have the name."""
        made = cls(path.parent, path.name)
        made.path, made._named = path, False
        return made

    def running(self) -> str:
        """Id of the mission that was begun and not ended; empty: none.

        Raises:
            MissionFileError: It cannot be read.
        """
        return self.find_running()[0]

    def find_running(self) -> tuple[str, str]:
        """The same, and what is wrong with the file that says it; empty: nothing.

        Where that file is damaged, it is the newest mission, if that was not ended.

        Raises:
            MissionFileError: It cannot be read.
        """
        pointer = self.path / "running"
        try:
            name = files.read(pointer, _LONGEST_POINTER).decode("ascii", "replace").strip()
        except MapFileError as error:
            if not pointer.exists():
                return "", ""
            if not pointer.is_file() or pointer.stat().st_size <= _LONGEST_POINTER:
                raise MissionFileError(str(error)) from error
            name = ""
        if _ID.fullmatch(name) and (self.path / name / "journal").exists():
            return name, ""
        newest = next(reversed(self.missions()), "")
        if newest and self.reading(newest)[0].running:
            return newest, f"{pointer} is damaged; the newest mission, {newest}, goes on"
        return "", f"{pointer} is damaged, and the newest mission is ended; none goes on"

    def set_running(self, mission: str) -> None:
        """Write the id of the running mission; empty: none.

        Raises:
            MissionFileError: It cannot be written.
        """
        try:
            if mission:
                files.replace(self.path / "running", mission.encode())
            else:
                (self.path / "running").unlink(missing_ok=True)
                files.sync_folder(self.path)
        except OSError as fault:
            text = f"{self.path}/running cannot be written: {fault.strerror or fault}"
            raise MissionFileError(text) from fault

    def missions(self) -> list[str]:
        """Ids of all missions, the oldest first.

        Raises:
            MissionFileError: The folder is there and cannot be read.
        """
        try:
            return sorted(
                entry.name
                for entry in self.path.iterdir()
                if _ID.fullmatch(entry.name) and (entry / "journal").is_file()
            )
        except (FileNotFoundError, NotADirectoryError):
            return []
        except OSError as fault:
            text = f"{self.path} cannot be read: {fault.strerror or fault}"
            raise MissionFileError(text) from fault

    def make(self, stamp: float) -> str:
        """Make the folder of a new mission; returns its id.

        Args:
            stamp: When it begins [s since the epoch]; its id is the time of day here.

        Raises:
            MissionFileError: It cannot be made.
        """
        base = time.strftime("%Y%m%d-%H%M%S", time.localtime(stamp))
        for number in range(1, _MOST_AT_ONCE):
            name = base if number == 1 else f"{base}-{number}"
            try:
                (self.path / name).mkdir(parents=True)
            except FileExistsError:
                continue
            except OSError as fault:
                text = f"{self.path / name} cannot be made: {fault.strerror or fault}"
                raise MissionFileError(text) from fault
            files.sync_folder(self.path)
            return name
        text = f"{self.path} has {_MOST_AT_ONCE} missions of one second; wait a second"
        raise MissionFileError(text)

    def lock(self) -> int:
        """Lock the folder for writing until the returned file is closed.

        Raises:
            MissionFileError: Another process has the lock, or the folder cannot be made.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            file = os.open(self.path / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as fault:
            text = f"{self.path} cannot be written: {fault.strerror or fault}"
            raise MissionFileError(text) from fault
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as fault:
            os.close(file)
            text = f"{self.path} is in use by another hub of a robot named {self.robot}"
            raise MissionFileError(text) from fault
        return file

    def in_use(self) -> bool:
        """Whether a hub writes here now; for programs that only read."""
        try:
            file = os.open(self.path / "lock", os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            return False
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            return False  # this file system has no locks, so no hub has one
        finally:
            os.close(file)
        return False

    def journal_of(self, mission: str) -> Path:
        """The file with the journal of a mission."""
        return self.path / mission / "journal"

    def track_of(self, mission: str) -> Path:
        """The file with the track of a mission."""
        return self.path / mission / "track"

    def read(self, mission: str) -> tuple[MissionBook, int]:
        """A mission, and the number of damaged parts of its journal.

        Raises:
            MissionFileError: There is none of this id, or it is another robot's.
        """
        if not _ID.fullmatch(mission):
            text = f"{mission[:40]!r} is no mission; `rune-hub mission list` shows all"
            raise MissionFileError(text)
        book, reading = self.reading(mission)
        return book, reading.damaged

    def reading(self, mission: str) -> tuple[MissionBook, journal.Reading]:
        """A mission, and the records of its journal; writes nothing.

        Raises:
            MissionFileError: It cannot be read, or it is another robot's.
        """
        book = MissionBook()
        reading = journal_file.read(self.journal_of(mission), book.take)
        return self.checked(book, mission), reading

    def checked(self, book: MissionBook, mission: str) -> MissionBook:
        """The same mission, if it is one of this robot.

        A journal whose first record is damaged lies in this robot's folder, and so is of it.

        Raises:
            MissionFileError: It is another robot's.
        """
        if book.begun is None:
            stamp = max(0.0, min((event.stamp for event in book.events), default=0.0))
            book.begun = Begun(robot=self.robot, name=mission, by="", stamp=stamp)
            book.name = book.name or mission
        if not self._named and paths.as_file_name(book.begun.robot) == self.path.name:
            self.robot, self._named = book.begun.robot, True
        if book.begun.robot != self.robot:
            text = f"mission {mission} in {self.path} is of {book.begun.robot}, not {self.robot}"
            raise MissionFileError(text)
        return book

    def save_grid(self, mission: str, sheet: int, grid: log_odds.LogOdds) -> None:
        """Write a sheet of the map; the old file stays until then.

        Raises:
            MissionFileError: It cannot be written.
        """
        path = self._grid(mission, sheet)
        try:
            files.replace(path, log_odds.encode(grid))
        except OSError as fault:
            text = f"{path} cannot be written: {fault.strerror or fault}"
            raise MissionFileError(text) from fault

    def grid(self, mission: str, sheet: int) -> log_odds.LogOdds | None:
        """A sheet of the map; None if it was never saved.

        Raises:
            MissionFileError: It cannot be read.
        """
        path = self._grid(mission, sheet)
        if not path.exists():
            return None
        try:
            return log_odds.decode(files.read(path, log_odds.MAX_BYTES))
        except MapFileError as error:
            raise MissionFileError(str(error)) from error

    def sheets(self, mission: str) -> set[int]:
        """Numbers of the sheets whose map was saved."""
        with contextlib.suppress(OSError):
            names = (_SHEET.fullmatch(entry.name) for entry in (self.path / mission).iterdir())
            return {int(name[1]) for name in names if name}
        return set()

    def size(self, mission: str) -> int:
        """All files of a mission together [bytes]."""
        with contextlib.suppress(OSError):
            return sum(entry.stat().st_size for entry in (self.path / mission).iterdir())
        return 0

    def free(self) -> int:
        """Free space of the disk [bytes]; infinite if it is not known."""
        folder = self.path
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        try:
            disk = os.statvfs(folder)
        except OSError:
            return 1 << 62
        return disk.f_bavail * disk.f_frsize

    def _grid(self, mission: str, sheet: int) -> Path:
        return self.path / mission / f"sheet-{sheet}.grid"
