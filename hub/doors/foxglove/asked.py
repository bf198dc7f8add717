"""What programs with panels have asked for; the newest counts, so that a flood fills no memory."""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final

from hub.doors.foxglove.panel_wire import PanelChannel
from hub.doors.panels.wishes import (
    CMD_VEL,
    LARGEST_COMMAND,
    MOST_PANELS,
    Panel,
    PanelCommand,
    Wishes,
)
from hub.ipc.transport.fault_counter import FaultCounter

_WAITING: Final = 8
"""Commands of a panel that wait for the door; the oldest is dropped."""
_MOST_OF_PROGRAM: Final = 4
"""Most panels of one program that may send commands at a time."""


class Asked:
    """The thread of the server notes, the thread of the door takes."""

    def __init__(self, changed: Callable[[], None], faults: FaultCounter, *, drive: bool) -> None:
        """Nothing yet.

        Args:
            changed: Called when there is something new to take.
            faults: Counts what is refused.
            drive: Whether panels may drive.
        """
        self._changed, self._faults, self._drive = changed, faults, drive
        self._lock = threading.Lock()
        self._watched: set[tuple[int, int]] = set()  # program, channel
        self._fresh: set[int] = set()
        self._panels: dict[Panel, tuple[str, str]] = {}
        self._commands: dict[Panel, deque[PanelCommand]] = {}
        self._noted = False

    def take(self) -> Wishes:
        """All that was asked until now."""
        with self._lock:
            self._noted = False
            wishes = Wishes(
                watched=frozenset(channel for _, channel in self._watched),
                fresh=frozenset(self._fresh),
                commands=tuple(itertools.chain.from_iterable(self._commands.values())),
                panels=frozenset(self._panels),
            )
            self._fresh.clear()
            self._commands.clear()
        return wishes

    def watch(self, program: int, channel: int) -> None:
        """A program shows a channel."""
        with self._lock:
            self._watched.add((program, channel))
            self._fresh.add(channel)
        self._note()

    def unwatch(self, program: int, channel: int) -> None:
        """It shows it no more."""
        with self._lock:
            self._watched.discard((program, channel))
        self._note()

    def panel(self, program: int, channel: PanelChannel) -> None:
        """A program has a panel that sends commands."""
        if not self._drive or channel.topic != CMD_VEL:
            why = f"{channel.topic[:80]!r} is none on which panels drive"
            self._faults.count("refused channel", why if self._drive else "panels do not drive")
            return
        with self._lock:
            of_program = sum(each == program for each, _ in self._panels)
            room = len(self._panels) < MOST_PANELS and of_program < _MOST_OF_PROGRAM
            if room:
                kind = channel.encoding[:64], channel.schema_name[:64]
                self._panels[program, channel.number] = kind
        if not room:
            most = f"at most {_MOST_OF_PROGRAM} of a program and {MOST_PANELS} in all may drive"
            self._faults.count("refused channel", most)
        self._note()

    def panel_gone(self, panel: Panel) -> None:
        """A panel sends no commands any more."""
        with self._lock:
            self._panels.pop(panel, None)
            self._commands.pop(panel, None)
        self._note()

    def command(self, panel: Panel, data: bytes) -> None:
        """A panel has sent a command."""
        kind = self._panels.get(panel)
        if kind is None or len(data) > LARGEST_COMMAND:
            why = "its channel is not open" if kind is None else "it is too long"
            self._faults.count("refused command", f"{len(data)} bytes of a panel: {why}")
            return
        encoding, schema_name = kind
        command = PanelCommand(
            panel=panel, encoding=encoding, schema_name=schema_name, data=data,
            came=time.monotonic(),
        )  # fmt: skip
        with self._lock:
            self._commands.setdefault(panel, deque(maxlen=_WAITING)).append(command)
        self._note()

    def leave(self, program: int) -> None:
        """A program is gone, with all its panels."""
        with self._lock:
            self._watched = {each for each in self._watched if each[0] != program}
            for panel in [each for each in self._panels if each[0] == program]:
                self._panels.pop(panel)
                self._commands.pop(panel, None)
        self._note()

    def _note(self) -> None:
        with self._lock:
            noted, self._noted = self._noted, True
        if not noted:
            self._changed()
