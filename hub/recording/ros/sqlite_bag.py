"""Reads the .db3 files of rosbag2, databases of SQLite, as `Recording` reads MCAP files."""

from __future__ import annotations

import contextlib
import sqlite3
import threading
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Final, NamedTuple, Self

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.chunks import LoggedMessage
from hub.recording.open_recording import OpenRecording
from hub.recording.ros.sqlite_rows import MessageRows, RowPlace
from hub.recording.ros_quality import QOS
from hub.recording.topics import RecordedTopic

MAGIC: Final = b"SQLite format 3\0"
_LONGEST: Final = 1 << 29
"""Longest value that is read [bytes]."""
_MOST_TOPICS: Final = 65_536
_MOST_FAULTS: Final = 20


class _Way(NamedTuple):
    """How a file is opened.

    Attributes:
        fixed: As a file that nothing changes, without its journal.
        cut: Also when it is shorter than its head says.
    """

    fixed: bool
    cut: bool


class SqliteBag(OpenRecording):
    """A .db3 file that is read; the attributes are those of `Recording`."""

    def __init__(self, path: Path, database: sqlite3.Connection) -> None:
        """Use `open`."""
        self.path = path
        self.faults: list[str] = []
        self.about: Mapping[str, Mapping[str, str]] = {}
        self.finished = True
        self.attachments: tuple[()] = ()
        self.anchor: TimeAnchor | None = None
        self._database = database
        self._lock = threading.Lock()
        self._check_tables()
        self.channels: Mapping[int, RecordedTopic] = dict(self._topics())
        self._rows = MessageRows(database, self._lock, self._note)
        self.start, self.end = self._rows.start, self._rows.end
        self.counts: Mapping[int, int] = self._rows.counts()

    @classmethod
    def open(cls, path: Path) -> Self:
        """Open a file.

        Raises:
            RecordingError: It cannot be read, or is no bag.
        """
        journal = Path(f"{path}-wal")
        # Without a journal beside it nothing changes it, so no lock is needed. With one, the
        # system may forbid to write what readers share.
        ways = [_Way(fixed=False, cut=False)] if journal.is_file() else []
        ways += [_Way(fixed=True, cut=False), _Way(fixed=True, cut=True)]
        reason: object = ""
        for way in ways:
            try:
                made = cls._connected(path, way)
            except (sqlite3.Error, OverflowError, RecordingError) as error:
                reason = reason or error
            else:
                if way.cut:
                    made.faults.append("it is cut, or its head is damaged")
                if way.fixed and journal.is_file():
                    made.faults.append(f"{journal.name} cannot be read; its messages are missing")
                return made
        text = f"{path} cannot be read: {reason}"
        raise RecordingError(text)

    @classmethod
    def _connected(cls, path: Path, way: _Way) -> Self:
        """Open a file in a way.

        Raises:
            RecordingError: It is no bag.
            sqlite3.Error: It cannot be read.
            OverflowError: Its numbers are too large.
        """
        location = f"{path.absolute().as_uri()}?mode=ro{'&immutable=1' * way.fixed}"
        database = sqlite3.connect(location, uri=True, check_same_thread=False)
        try:
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST)
            if way.cut:
                # Else SQLite refuses each file that is shorter than its head says.
                database.execute("PRAGMA writable_schema=ON")
            database.execute("PRAGMA trusted_schema=OFF")
            database.execute("PRAGMA cell_size_check=ON")
            return cls(path, database)
        except BaseException:
            database.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time [ns]; see `Recording.newest`."""
        found: dict[int, LoggedMessage] = {}
        left = set(self.channels) if channels is None else channels & self.channels.keys()
        for place in self._rows.recent(_signed(stamp), left):
            if place.channel in left and (message := self._message(place)) is not None:
                found[place.channel] = message
                left = left - {place.channel}
                if not left:
                    return found
        self._rows.learn(left)
        for channel in left:
            places = self._rows.places(0, _signed(stamp), {channel}, reverse=True)
            message = next(filter(None, map(self._message, places)), None)
            if message is not None:
                found[channel] = message
        return found

    def messages(
        self,
        start: int | None = None,
        end: int | None = None,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[LoggedMessage]:
        """All messages by stamp; see `Recording.messages`."""
        first = self.start if start is None else _signed(start)
        last = self.end if end is None else _signed(end)
        places = self._rows.places(first, last, channels, reverse=reverse)
        return filter(None, map(self._message, places))

    def _message(self, place: RowPlace) -> LoggedMessage | None:
        """The message at a place; None: it cannot be read."""
        try:
            with self._lock:
                query = self._database.execute(
                    "SELECT data FROM messages WHERE id = ?", (place.row,)
                )
                found = query.fetchone()
        except (sqlite3.Error, MemoryError) as error:
            self._note(f"a part of it cannot be read: {error}")
            return None
        if found is None or not isinstance(found[0], bytes):
            self._note("it has messages without bytes")
            return None
        return LoggedMessage(place.channel, place.stamp, place.stamp, 0, found[0])

    def _note(self, fault: str) -> None:
        if len(self.faults) < _MOST_FAULTS and fault not in self.faults:
            self.faults.append(fault)

    def _check_tables(self) -> None:
        """Refuse a database whose tables compute their rows: they can compute anything."""
        tables = dict(
            self._database.execute("SELECT name, sql FROM sqlite_master WHERE type='table'")
        )
        for name in ("topics", "messages"):
            spelt = tables.get(name)
            if not isinstance(spelt, str) or not spelt.upper().lstrip().startswith("CREATE TABLE"):
                text = f"it is no bag of rosbag2: it has no table {name!r}"
                raise RecordingError(text)
            columns = self._database.execute(f"PRAGMA table_xinfo({name})")
            if any(row[6] for row in columns):  # generated, or hidden
                text = f"it is no bag of rosbag2: its table {name!r} computes values"
                raise RecordingError(text)

    def _topics(self) -> Iterator[tuple[int, RecordedTopic]]:
        definitions: dict[str, tuple[str, bytes]] = {}
        with contextlib.suppress(sqlite3.Error):  # before ROS 2 Iron there are none
            for kind, encoding, text in self._database.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions "
                f"LIMIT {_MOST_TOPICS}"
            ):
                definitions[str(kind)] = str(encoding), str(text).encode()
        columns = {str(row[1]) for row in self._database.execute("PRAGMA table_info(topics)")}
        qos = QOS if QOS in columns else "''"
        for number, name, kind, encoding, offered in self._database.execute(
            f"SELECT id, name, type, serialization_format, {qos} FROM topics LIMIT {_MOST_TOPICS}"
        ):
            language, text = definitions.get(str(kind), ("", b""))
            yield (
                int(number),
                RecordedTopic(
                    str(name),
                    str(kind),
                    language if language in ("ros2msg", "ros2idl") else "",
                    text if language in ("ros2msg", "ros2idl") else b"",
                    str(encoding),
                    {QOS: str(offered)} if offered else {},
                ),
            )


def _signed(stamp: int) -> int:
    """A stamp that SQLite can compare [ns]."""
    return max(-(1 << 63), min((1 << 63) - 1, stamp))
