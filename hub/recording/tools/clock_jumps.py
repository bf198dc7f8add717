"""Where the clock of a recording jumps back: a date that was set, a simulation that began again.

Within a topic messages are written as they come. Topics may be written one after the other, so each
is looked at by itself.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from hub.recording.chunks import MessageFacts

JUMP_S: Final = 1.0
"""Smallest jump that is found [s]; messages of a busy recorder are less out of order."""
_JUMP: Final = int(JUMP_S * 1e9)
_MOST_JUMPS = 100
_MOST_TOPICS = 1000
"""Most topics whose jumps are kept."""


class ClockJump(NamedTuple):
    """A jump back.

    Attributes:
        stamp: Stamp of the last message before it [ns].
        back: How far it goes back [ns].
    """

    stamp: int
    back: int


class ClockJumps:
    """Finds jumps, part after part in the order of the file."""

    def __init__(self) -> None:
        self._last: dict[int, np.uint64] = {}
        self._found: dict[int, list[ClockJump]] = {}
        self._known = True

    def add(self, facts: MessageFacts) -> None:
        """Take the messages of the next part."""
        if facts.places.size < facts.stamps.size:
            self._known = False
            return
        order = np.lexsort((facts.places, facts.channels))
        channels, stamps = facts.channels[order], facts.stamps[order]
        found, begins = np.unique(channels, return_index=True)
        for channel, ours in zip(found.tolist(), np.split(stamps, begins[1:]), strict=True):
            before = np.concatenate(([self._last.get(channel, ours[0])], ours[:-1]))
            self._last[channel] = ours[-1]
            back = np.where(before > ours, before - ours, np.uint64(0))
            for at in np.flatnonzero(back > _JUMP).tolist():
                self._keep(channel, ClockJump(int(before[at]), int(back[at])))

    def _keep(self, channel: int, jump: ClockJump) -> None:
        if channel in self._found or len(self._found) < _MOST_TOPICS:
            jumps = self._found.setdefault(channel, [])
            if len(jumps) < _MOST_JUMPS:
                jumps.append(jump)

    def found(self) -> list[ClockJump] | None:
        """The jumps of the topic that has most of them, in the order of the file.

        None: not known, as the file has messages in the order of their stamps.
        """
        return max(self._found.values(), key=len, default=[]) if self._known else None
