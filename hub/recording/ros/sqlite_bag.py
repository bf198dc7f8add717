"""Reads the .db3 files of rosbag2, databases of SQLite, as `Recording` reads MCAP files."""

from __future__ import annotations

import contextlib
import sqlite3
import threading
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
import numpy.typing as npt

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.chunks import LoggedMessage
from hub.recording.open_recording import OpenRecording
from hub.recording.topics import RecordedTopic

MAGIC: Final = b"SQLite format 3\0"
_LONGEST: Final = 1 << 29
"""Longest value that is read [bytes]."""
_MOST_TOPICS: Final = 65_536
_MOST_FAULTS: Final = 20
_MOST_MESSAGES: Final = 20_000_000
_BLOCK: Final = 10_000
_INDEX: Final = np.dtype([("channel", np.int64), ("stamp", np.int64), ("row", np.int64)])


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
        self._rows = rows = self._read_index()
        self.start, self.end = (int(rows[at]["stamp"]) if len(rows) else 0 for at in (0, -1))
        order = np.argsort(rows["channel"], kind="stable")
        channels, begins, counts = np.unique(
            rows["channel"][order], return_index=True, return_counts=True
        )
        self.counts: Mapping[int, int] = dict(zip(channels.tolist(), counts.tolist(), strict=True))
        parts = np.split(order, begins[1:])
        self._places = dict(zip(channels.tolist(), parts, strict=False))

    @classmethod
    def open(cls, path: Path) -> Self:
        """Open a file.

        Raises:
            RecordingError: It cannot be read, or is no bag.
        """
        # Without a journal beside it nothing changes it, so no lock is needed.
        fixed = not Path(f"{path}-wal").exists()
        location = f"{path.absolute().as_uri()}?mode=ro{'&immutable=1' * fixed}"
        database = None
        try:
            database = sqlite3.connect(location, uri=True, check_same_thread=False)
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST)
            database.execute("PRAGMA trusted_schema=OFF")
            database.execute("PRAGMA cell_size_check=ON")
            return cls(path, database)
        except (sqlite3.Error, OverflowError, RecordingError) as error:
            if database is not None:
                database.close()
            text = f"{path} cannot be read: {error}"
            raise RecordingError(text) from error

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def newest(
        self, stamp: int, channels: AbstractSet[int] | None = None
    ) -> dict[int, LoggedMessage]:
        """The last message of each channel at or before a time [ns]; see `Recording.newest`."""
        found = {}
        for channel in self.channels.keys() if channels is None else channels:
            places = self._places.get(channel)
            if places is None:
                continue
            at = int(np.searchsorted(self._rows["stamp"][places], _signed(stamp), "right"))
            while at > 0 and channel not in found:
                at -= 1
                message = self._message(int(places[at]))
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
        stamps = self._rows["stamp"]
        first = 0 if start is None else int(np.searchsorted(stamps, _signed(start), "left"))
        last = len(stamps) if end is None else int(np.searchsorted(stamps, _signed(end), "right"))
        places = np.arange(first, last)
        if channels is not None:
            places = places[np.isin(self._rows["channel"][first:last], sorted(channels))]
        for place in places[::-1] if reverse else places:
            message = self._message(int(place))
            if message is not None:
                yield message

    def _message(self, place: int) -> LoggedMessage | None:
        """The message at a place of the index; None: it cannot be read."""
        channel, stamp, row = self._rows[place].tolist()
        try:
            with self._lock:
                query = self._database.execute("SELECT data FROM messages WHERE id = ?", (row,))
                found = query.fetchone()
        except (sqlite3.Error, MemoryError) as error:
            self._note(f"a part of it cannot be read: {error}")
            return None
        if found is None or not isinstance(found[0], bytes):
            self._note("it has messages without bytes")
            return None
        return LoggedMessage(channel, stamp, stamp, 0, found[0])

    def _read_index(self) -> npt.NDArray[np.void]:
        """Channel, stamp and row of all messages, by stamp; as far as they can be read."""
        blocks: list[npt.NDArray[np.void]] = []
        try:
            query = self._database.execute("SELECT topic_id, timestamp, id FROM messages")
            while rows := query.fetchmany(_BLOCK):
                if sum(len(block) for block in blocks) > _MOST_MESSAGES:
                    self._note(f"only its first {_MOST_MESSAGES} messages are read")
                    break
                whole = [row for row in rows if _is_index(row)]
                blocks.append(np.array(whole, _INDEX))
        except sqlite3.Error as error:
            self._note(f"a part of it cannot be read: {error}")
        rows_of_all = np.concatenate(blocks) if blocks else np.zeros(0, _INDEX)
        return rows_of_all[np.lexsort((rows_of_all["row"], rows_of_all["stamp"]))]

    def _note(self, fault: str) -> None:
        if len(self.faults) < _MOST_FAULTS and fault not in self.faults:
            self.faults.append(fault)

    def _check_tables(self) -> None:
        """Refuse a database whose tables are views: they can compute anything."""
        tables = dict(
            self._database.execute("SELECT name, sql FROM sqlite_master WHERE type='table'")
        )
        for name in ("topics", "messages"):
            spelt = tables.get(name)
            if not isinstance(spelt, str) or not spelt.upper().lstrip().startswith("CREATE TABLE"):
                text = f"it is no bag of rosbag2: it has no table {name!r}"
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
        qos = "offered_qos_profiles" if "offered_qos_profiles" in columns else "''"
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
                    {"offered_qos_profiles": str(offered)} if offered else {},
                ),
            )


def _is_index(row: tuple[Any, ...]) -> bool:
    """Whether a row has the numbers of a message; SQLite checks no types."""
    return all(isinstance(each, int) for each in row) and row[1] >= 0 and 0 <= row[0] < 1 << 32


def _signed(stamp: int) -> int:
    """A stamp that SQLite can compare [ns]."""
    return max(-(1 << 63), min((1 << 63) - 1, stamp))
