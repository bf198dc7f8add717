"""A console that another program conducts, such as a session of a study.

Both ends of a socket write JSON objects, one a line. The console obeys:

| do | what the console does |
| --- | --- |
| `withdraw` | leaves the terminal to the other program, and goes on without a screen |
| `return` | enters the terminal again |
| `withhold` | takes no input but stops, as soon as none was used for `quiet` [s] |
| `allow` | takes inputs again |
| `say` | shows `text` as a notice |
| `listen` | reports the keys of `keys` instead of using them |
| `end` | ends |

It reports `ready`, `withdrawn`, `returned`, `withheld`, and `key` with `name` and `moment`: on the
monotonic clock [s].
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import socket
import time
from collections.abc import Collection
from typing import Any

from textual import events

from hub.gcm.navigation import ASSISTANCE_COMMAND
from rune_tui.app import Console
from rune_tui.controls.keyboard import name_of_key
from rune_tui.model.control import Standing, standing
from rune_tui.model.effects import Notify
from rune_tui.model.operating_limits import OperatingLimits
from rune_tui.model.robot_state import LinkPhase
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.ui.driver_reports import KeyMoved

_logger = logging.getLogger(__name__)
_LONGEST_LINE = 65_536
_LOOK_S = 0.1
_KEEP_S = 0.5
"""Time between two commands that keep assistance; the robot forgets it after 10 s [s]."""


class ConductedConsole(Console, inherit_bindings=True):
    """The console with a line to the program that conducts it."""

    def conduct_by(self, handle: int, limits: OperatingLimits) -> None:
        """Obey the program at the other end of a socket from the start of the console on.

        Args:
            handle: The socket.
            limits: What robots may do by themselves, for all layouts.
        """
        self.current.change(limits=limits)
        self._line = socket.socket(fileno=handle)
        self._line.settimeout(0.0)
        self._unread = b""
        self._keys: Collection[str] = ()
        self._quiet: float | None = None
        self._away = contextlib.ExitStack()

    def on_mount(self) -> None:
        """Begin to listen; the other program gets `ready`."""
        asyncio.get_running_loop().add_reader(self._line.fileno(), self._read)
        self.set_interval(_LOOK_S, self._withhold_when_quiet)
        self.set_interval(_KEEP_S, self._keep_assistance)
        self._report("ready")

    def on_key(self, event: events.Key) -> None:
        """Report a key that the other program wants; the console does not use it."""
        if self._wanted(event.key, event.character):
            event.stop()
            event.prevent_default()

    def on_key_moved(self, event: KeyMoved) -> None:
        """The same on a terminal that reports releases."""
        down, repeat = event.move is not KeyMove.RELEASE, event.move is KeyMove.REPEAT
        if not (down and self._wanted(event.key, event.character, repeat=repeat)):
            super().on_key_moved(event)
        event.prevent_default()  # Textual calls the method of each class

    def _wanted(self, key: str, character: str | None, *, repeat: bool = False) -> bool:
        name = name_of_key(key, character)
        wanted = name in self._keys
        if wanted:
            now = time.monotonic()
            self.inputs.note_taken(name, now, repeat=repeat)
            self._report("key", name=name, moment=now)
        return wanted

    def _read(self) -> None:
        """Obey all whole lines; without the other program the console ends."""
        try:
            received = self._line.recv(_LONGEST_LINE)
        except BlockingIOError:
            return
        except OSError:
            received = b""
        if not received or len(self._unread) > _LONGEST_LINE:
            asyncio.get_running_loop().remove_reader(self._line.fileno())
            self._end()
            return
        *lines, self._unread = (self._unread + received).split(b"\n")
        for line in lines:
            with self.effects.guard(line):
                order = json.loads(line)
                self._obey(str(order["do"]), order)

    def _obey(self, do: str, order: dict[str, Any]) -> None:
        match do:
            case "withdraw":
                self._withdraw()
            case "return":
                self._away.close()
                self.inputs.forget_use()
                self._report("returned")
            case "withhold":
                self._quiet = float(order["quiet"])
            case "allow":
                self._quiet = None
                self.inputs.release_all()
                self.inputs.withheld = False
            case "say":
                self._execute((Notify.now(self.state, str(order["text"])),))
            case "listen":
                self._keys = frozenset(map(str, order["keys"]))
            case "end":
                self._end()
            case _:
                _logger.warning("unknown order of the conducting program: %.40s", do)

    def _withhold_when_quiet(self) -> None:
        """Withhold control once the operator has left the robots alone."""
        if self._quiet is not None and self.inputs.unused_for(time.monotonic()) >= self._quiet:
            self._quiet = None
            self.inputs.withheld = True
            self._report("withheld")

    def _keep_assistance(self) -> None:
        """Switch assistance as the condition wants it; the robot forgets that it is off."""
        wanted = self.current.console.limits.kept
        if wanted is None:
            return
        for name, robot in self.state.robots.items():
            there = robot.link.phase is LinkPhase.CONNECTED
            if there and standing(robot) is not Standing.OTHERS:
                self._links[name].send(ASSISTANCE_COMMAND, wanted)

    def _withdraw(self) -> None:
        self.inputs.release_all()
        self._away.enter_context(self.suspend())
        self._away.enter_context(self._painter.rest())
        self._report("withdrawn")

    def _end(self) -> None:
        self._away.close()
        self._leave()

    def _report(self, event: str, **data: object) -> None:
        with contextlib.suppress(OSError):
            self._line.send(json.dumps({"event": event, **data}).encode() + b"\n")
