"""Order in recordings: which parts have a channel, and messages of parts that overlap in time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hub.recording.chunks import ChunkPlace, LoadedChunk

_MAP = np.dtype([("channel", "<u2"), ("offset", "<u8")])
_Ints = npt.NDArray[np.int64]
_AT_ONCE = 1024
"""Messages that become numbers of Python at once."""


class ChannelChunks(NamedTuple):
    """The parts of a file that have messages of one channel, by their first stamp.

    Attributes:
        numbers: Their numbers (n,).
        starts: Their first stamps (n,) [ns].
        ends_before: The last stamp of each part and those before it (n,) [ns].
    """

    numbers: _Ints
    starts: npt.NDArray[np.uint64]
    ends_before: npt.NDArray[np.uint64]


def by_channel(
    places: Sequence[ChunkPlace], channels_in: Callable[[int], npt.NDArray[np.uint16]]
) -> dict[int, ChannelChunks]:
    """Which parts have messages of a channel.

    Args:
        places: All parts by their first stamp.
        channels_in: Finds the channels of a part that has no indexes, by its number.
    """
    if not places:
        return {}
    lists = [
        np.frombuffer(place.channels, _MAP)["channel"] if place.channels else channels_in(number)
        for number, place in enumerate(places)
    ]
    channels = np.concatenate(lists)
    if not channels.size:
        return {}
    numbers = np.repeat(np.arange(len(places)), [len(each) for each in lists])
    order = np.argsort(channels, kind="stable")
    found, begins = np.unique(channels[order], return_index=True)
    starts = np.array([place.start for place in places], np.uint64)
    ends = np.array([place.end for place in places], np.uint64)
    return {
        int(channel): ChannelChunks(ours, starts[ours], np.maximum.accumulate(ends[ours]))
        for channel, ours in zip(found, np.split(numbers[order], begins[1:]), strict=True)
    }


class WaitingMessages:
    """Messages of loaded parts, until no part can have an earlier one."""

    def __init__(self, *, reverse: bool) -> None:
        self._reverse = reverse
        self._stamps = np.zeros(0, np.uint64)
        self._places = np.zeros((0, 4), np.int64)  # number, index, places of part and in it

    def add(self, number: int, offset: int, chunk: LoadedChunk, indexes: _Ints) -> None:
        """Take these messages of a part at this place in the file."""
        places = np.empty((len(indexes), 4), np.int64)
        places[:, 0] = number
        places[:, 1] = indexes
        places[:, 2] = offset
        places[:, 3] = chunk.offsets[indexes]  # in the unpacked part, which may be longer
        stamps = np.concatenate([self._stamps, chunk.stamps[indexes]])
        places = np.concatenate([self._places, places])
        order = np.lexsort((places[:, 3], places[:, 2], stamps))
        if self._reverse:
            order = order[::-1]
        self._stamps, self._places = stamps[order], places[order]

    def before(self, stamp: int) -> Iterator[tuple[int, int]]:
        """Remove messages before a stamp (or after, when reversed): part and index of each."""
        if self._reverse:
            count = int(np.count_nonzero(self._stamps > np.uint64(stamp)))
        else:
            count = int(np.count_nonzero(self._stamps < np.uint64(stamp)))
        return self._remove(count)

    def rest(self) -> Iterator[tuple[int, int]]:
        """Remove all messages: part and index of each."""
        return self._remove(len(self._stamps))

    def _remove(self, count: int) -> Iterator[tuple[int, int]]:
        gone = self._places[:count, :2]
        self._stamps, self._places = self._stamps[count:], self._places[count:]
        parts = (gone[at : at + _AT_ONCE].tolist() for at in range(0, count, _AT_ONCE))
        return ((number, index) for part in parts for number, index in part)
