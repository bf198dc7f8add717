"""Keeps the bytes of a link while they are wanted."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from hub.gcm.autopilot import MavlinkFrames

_MOST: Final = 1000
"""Most pieces that are kept until they are taken; later ones are left out."""


class LinkTap:
    """The bytes since they were last taken."""

    def __init__(self, clock: Callable[[], float] = time.time) -> None:
        """Keep nothing yet.

        Args:
            clock: The date [s since the epoch].
        """
        self._clock = clock
        self._wanted = False
        self._kept: list[MavlinkFrames] = []

    def came(self, pieces: Sequence[bytes]) -> None:
        """Keep what one read returned."""
        if self._wanted and pieces:
            self._keep(b"".join(pieces), sent=0)

    def sent(self, frame: bytes) -> None:
        """Keep a frame that left."""
        if self._wanted:
            self._keep(frame, sent=1)

    def take(self, *, wanted: bool) -> tuple[MavlinkFrames, ...]:
        """What was kept since the last call; `wanted`: keep further ones too."""
        self._wanted = wanted
        taken = tuple(self._kept)
        self._kept.clear()
        return taken

    def _keep(self, data: bytes, sent: int) -> None:
        if len(self._kept) < _MOST:
            octets = np.frombuffer(data, np.uint8)
            self._kept.append(MavlinkFrames(stamp=self._clock(), sent=sent, data=octets))
