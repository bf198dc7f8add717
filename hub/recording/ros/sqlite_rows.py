"""Finds the messages of a database of rosbag2 by time, as the database itself has them in order.

| the database | the order is of |
| --- | --- |
| has an index of its stamps, as rosbag2 makes it | this index: nothing is read too early |
| has none, or a damaged one | a list of all messages, which is read once |

A topic that is silent for long would be looked for in the whole index again and again, so its
places are read once.
"""

from __future__ import annotations

import itertools
import sqlite3
import threading
from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from hub.plain_text import counted

_MOST_MESSAGES: Final = 20_000_000
MOST_COUNTED: Final = 100_000
"""Messages whose topics are counted when a file is opened."""
_BLOCK: Final = 10_000
_AHEAD: Final = 100
"""Places that are read at once."""
MOST_BACK: Final = 2_000
"""How many messages back the newest of each topic is looked for in the index."""
_SAMPLES: Final = 8
"""Messages that are looked for in the index before it counts."""
_FARTHEST: Final = 1 << 32
"""How far behind a damaged row others are looked for."""
_LAST: Final = (1 << 63) - 1
_PLACE: Final = np.dtype([("stamp", np.int64), ("row", np.int64), ("channel", np.int64)])
_SOUND: Final = (
    "timestamp >= 0 AND typeof(timestamp) = 'integer' AND typeof(id) = 'integer' "
    "AND topic_id BETWEEN 0 AND 4294967295 AND typeof(topic_id) = 'integer'"
)
"""What a row of a message has; SQLite checks no types."""

Places = npt.NDArray[np.void]


class RowPlace(NamedTuple):
    """Where a message is.

    Attributes:
        stamp: When it was logged [ns].
        row: Number of its row.
        channel: Number of its topic.
    """

    stamp: int
    row: int
    channel: int


class MessageRows:
    """The places of the messages of a database.

    Attributes:
        start: Stamp of the first message [ns]; 0 without messages.
        end: Stamp of the last message [ns]; 0 without messages.
    """

    def __init__(
        self, database: sqlite3.Connection, lock: threading.Lock, note: Callable[[str], None]
    ) -> None:
        """Find the first and the last message.

        Args:
            database: The open database.
            lock: Held while the database is read.
            note: Takes what is wrong, a sentence.
        """
        self._database, self._lock, self._note = database, lock, note
        self._all: Places | None = None
        self._of_channel: dict[int, Places] = {}
        self.start = self.end = 0
        if not self._has_index() or not self._index_is_whole():
            self._read_all()
        first = next(self.places(0, _LAST), None)
        last = next(self.places(0, _LAST, reverse=True), None)
        if first is not None and last is not None:
            self.start, self.end = first.stamp, last.stamp

    def counts(self) -> dict[int, int]:
        """Number of messages by channel; empty: they are too many to count, or damaged."""
        if self._all is not None:
            channels, counts = np.unique(self._all["channel"], return_counts=True)
            return dict(zip(channels.tolist(), counts.tolist(), strict=True))
        try:
            with self._lock:
                (count,) = self._database.execute("SELECT COUNT(*) FROM messages").fetchone()
                if count > MOST_COUNTED:
                    return {}
                query = f"SELECT topic_id, COUNT(*) FROM messages WHERE {_SOUND} GROUP BY topic_id"
                found = dict(self._database.execute(query).fetchall())
        except sqlite3.Error:
            return {}
        if odd := count - sum(found.values()):
            said = "before 1970, or with a time or topic that is no number, are left out"
            self._note(f"{counted(odd, 'message')} {said}")
        return found

    def places(
        self,
        first: int,
        last: int,
        channels: AbstractSet[int] | None = None,
        *,
        reverse: bool = False,
    ) -> Iterator[RowPlace]:
        """The places of messages by stamp; equal stamps by row.

        Args:
            first: The first stamp [ns].
            last: The last stamp [ns].
            channels: Which channels; default all.
            reverse: The last message first.
        """
        first, last = max(0, first), min(_LAST, last)
        if channels is not None and first <= self.start and last >= self.end and self.end:
            self.learn(channels)
        before: RowPlace | None = None
        if self._all is None and (channels is None or not channels <= self._of_channel.keys()):
            try:
                for place in self._in_index(first, last, channels, reverse=reverse):
                    yield (before := place)
                return
            except sqlite3.Error:  # its index is damaged, which loses nothing
                self._read_all()
        found = self._known(channels)
        low = int(np.searchsorted(found["stamp"], first, "left"))
        high = int(np.searchsorted(found["stamp"], last, "right"))
        for at in range(high - 1, low - 1, -1) if reverse else range(low, high):
            place = RowPlace(*found[at].tolist())
            ahead = before is None or (place < before if reverse else place > before)
            if ahead:
                yield place

    def recent(self, stamp: int, channels: AbstractSet[int]) -> Iterator[RowPlace]:
        """The last messages at or before a time [ns], the newest first.

        There are none where the places of all the channels are known.
        """
        if self._all is not None or channels <= self._of_channel.keys():
            return iter(())
        return itertools.islice(self.places(0, stamp, reverse=True), MOST_BACK)

    def learn(self, channels: AbstractSet[int]) -> None:
        """Keep the places of all messages of some channels."""
        new = channels - self._of_channel.keys()
        if self._all is None and new:
            found = self._read(f"topic_id IN ({_listed(new)}) AND")
            self._of_channel |= {each: found[found["channel"] == each] for each in new}

    def _has_index(self) -> bool:
        """Whether the database has an index of the stamps of all messages."""
        try:
            with self._lock:
                indexes = self._database.execute("PRAGMA index_list(messages)").fetchall()
                names = [str(name) for _, name, _, _, partial in indexes if not partial]
                return any(
                    [
                        row[2]
                        for row in self._database.execute(
                            "SELECT * FROM pragma_index_info(?)", (name,)
                        )
                    ]
                    == ["timestamp"]
                    for name in names
                )
        except sqlite3.Error:
            return False

    def _index_is_whole(self) -> bool:
        """Whether some messages, from the first to the last, are in the index."""
        columns, rows = "SELECT timestamp, id, topic_id FROM messages", list[tuple[int, ...]]()
        try:
            with self._lock:
                for way in ("ASC", "DESC"):
                    query = f"{columns} NOT INDEXED WHERE id IS NOT NULL ORDER BY id {way} LIMIT 1"
                    rows += self._database.execute(query).fetchall()
                if not rows:
                    return True
                first, last = (row[1] for row in rows)
                for at in range(1, _SAMPLES):
                    near = f"{columns} NOT INDEXED WHERE id >= ? ORDER BY id LIMIT 1"
                    row = first + (last - first) * at // _SAMPLES
                    rows += self._database.execute(near, (row,)).fetchall()
            return all(
                stamp < 0 or any(place.row == row for place in self._in_index(stamp, stamp, None))
                for stamp, row, _ in rows
            )
        except (sqlite3.Error, TypeError, ValueError):
            return False

    def _in_index(
        self, first: int, last: int, channels: AbstractSet[int] | None, *, reverse: bool = False
    ) -> Iterator[RowPlace]:
        """Places in the order of the index of the database.

        Raises:
            sqlite3.Error: The index is damaged.
        """
        way = "DESC" if reverse else "ASC"
        some = f" AND topic_id IN ({_listed(channels)})" if channels is not None else ""
        query = (
            f"SELECT timestamp, id, topic_id FROM messages WHERE {_SOUND} "
            f"AND timestamp BETWEEN ? AND ?{some} ORDER BY timestamp {way}, id {way}"
        )
        with self._lock:
            cursor = self._database.execute(query, (first, last))
        before = (last + 1, 0) if reverse else (first - 1, 0)
        while True:
            with self._lock:
                rows = cursor.fetchmany(_AHEAD)
            if not rows:
                return
            for place in itertools.starmap(RowPlace, rows):
                if (place[:2] > before) is reverse:
                    text = "it is not in the order of time"
                    raise sqlite3.DatabaseError(text)
                before = place[:2]
                yield place

    def _known(self, channels: AbstractSet[int] | None) -> Places:
        """Places that are in memory, by stamp."""
        if channels is None:
            return self._all if self._all is not None else np.zeros(0, _PLACE)
        parts = [self._of_channel[each] for each in channels if each in self._of_channel]
        if len(parts) == 1:
            return parts[0]
        return _in_order(np.concatenate(parts)) if parts else np.zeros(0, _PLACE)

    def _read_all(self) -> None:
        self._all = found = self._read("")
        order = np.argsort(found["channel"], kind="stable")
        channels, begins = np.unique(found["channel"][order], return_index=True)
        parts = np.split(found[order], begins[1:])
        self._of_channel = dict(zip(channels.tolist(), parts, strict=False))

    def _read(self, condition: str) -> Places:
        """Places of messages by stamp, without any index; as far as they can be read."""
        blocks: list[Places] = []
        query = (
            f"SELECT timestamp, id, topic_id FROM messages NOT INDEXED WHERE {condition} {_SOUND} "
            f"AND id > ? ORDER BY id LIMIT {_BLOCK}"
        )
        after, skip = -_LAST, 0
        for _ in range(_MOST_MESSAGES // _BLOCK):
            rows: list[tuple[int, int, int]] = []
            try:
                with self._lock:
                    rows.extend(self._database.execute(query, (after + skip,)))
                ends = len(rows) < _BLOCK
            except sqlite3.Error as error:
                self._note(f"a part of it cannot be read: {error}")
                # Rows behind the damage are looked for, farther and farther.
                ends = skip > _FARTHEST
                after, skip = (rows[-1][1], 0) if rows else (max(after, 0), 2 * skip or 1)
            else:
                after, skip = (rows[-1][1] if rows else after), 0
            blocks.append(np.array(rows, np.int64).reshape(-1, 3).view(_PLACE)[:, 0])
            if ends:
                break
        else:
            self._note(f"only its first {_MOST_MESSAGES} messages are read")
        return _in_order(np.concatenate(blocks))


def _in_order(places: Places) -> Places:
    return places[np.lexsort((places["row"], places["stamp"]))]


def _listed(channels: AbstractSet[int]) -> str:
    return ",".join(str(int(each)) for each in sorted(channels))
