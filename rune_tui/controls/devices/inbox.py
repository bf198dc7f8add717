"""The queue of a device's values: the newest of each axis, every edge of each button."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence

from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.layout.spec import ControlKind

MOST_EDGES = 256
"""More than hands do in seconds; of more, the oldest are dropped and counted."""


class Inbox:
    """The queue between the thread that reads a device and the one that uses it.

    Attributes:
        dropped: Number of edges dropped because the queue was full; the final states are kept.
        reports: Number of reports.
    """

    def __init__(self, controls: Sequence[PhysicalControl]) -> None:
        self.dropped = 0
        self.reports = 0
        self._kinds = [control.kind for control in controls]
        self._turns = any(kind is ControlKind.BALL for kind in self._kinds)
        self._last: tuple[tuple[int, int | None], ...] = ()
        self._lock = threading.Lock()
        self._known: dict[int, int | None] = {}
        self._changed: dict[int, int | None] = {}
        self._counts: dict[int, int] = {}
        self._edges: deque[tuple[int, int | None]] = deque(maxlen=MOST_EDGES)

    def put(self, values: tuple[tuple[int, int | None], ...]) -> bool:
        """Add a report; returns whether it changes anything."""
        self.reports += 1
        if values == self._last and not self._turns:
            return False
        self._last = values
        with self._lock:
            known, kinds = self._known, self._kinds
            news = [
                self._put(position, raw, kinds[position])
                for position, raw in values
                if position not in known or known[position] != raw
            ]
        return True in news

    def take(self) -> list[tuple[int, int | None]]:
        """Take the new values: edges in their order, then the newest of every control."""
        with self._lock:
            taken = [*self._edges, *self._changed.items(), *self._counts.items()]
            self._edges.clear()
            self._changed.clear()
            self._counts.clear()
        return taken

    def everything(self) -> list[tuple[int, int | None]]:
        """The newest values of all controls, taken or not."""
        with self._lock:
            return list(self._known.items())

    def _put(self, position: int, raw: int | None, kind: ControlKind) -> bool:
        """Note a value that is new; of a ball, any value is."""
        if kind is ControlKind.BALL:
            self._counts[position] = self._counts.get(position, 0) + (raw or 0)
            return bool(raw)
        self._known[position] = self._changed[position] = raw
        if kind is not ControlKind.AXIS:
            self.dropped += len(self._edges) == MOST_EDGES
            self._edges.append((position, raw))
        return True
