"""A pseudo-terminal for a scripted operator: it types, and answers what a program asks it."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
import threading
from collections.abc import Sequence
from types import TracebackType
from typing import Final, Self

from rune_study.errors import StudyError

ARROW_UP: Final = "A"
ARROW_LEFT: Final = "D"
"""Arrows, by the letters that end their sequences."""
_ARROWS: Final = {ARROW_UP, ARROW_LEFT}
_AS_ITS_TERMINAL: Final = (
    "import fcntl, os, sys, termios; fcntl.ioctl(0, termios.TIOCSCTTY, 0); "
    "os.execvp(sys.argv[1], sys.argv[1:])"
)
"""Makes its input the terminal of its session, so that a hang-up ends the command."""
_COLUMNS: Final = 120
_ROWS: Final = 36
_RELEASES: Final = b"\x1b[?27u"
"""Kitty keyboard protocol: this terminal reports presses and releases of all keys."""
_ATTRIBUTES: Final = b"\x1b[?6c"
_SEEN: Final = re.compile(
    rb"\x1b\[(?:(?P<row>\d+);(?P<column>\d+)H\x1b\[6n|(?P<keys>\?u)|(?P<what>c)"
    rb"|(?P<enter>\?1049h)|(?P<leave>\?1049l))"
)
_LONGEST: Final = 24
"""No sequence of interest is longer."""
_READ_S: Final = 0.1
_END_S: Final = 15.0


class StudyTerminal:
    """A command on a pseudo-terminal; what it draws is not kept.

    A thread answers where the cursor is: without answers a console rests.

    Attributes:
        screens: Number of full screens that were opened.
        showing: Whether one is open.
    """

    def __init__(self, command: Sequence[str]) -> None:
        """Start the command.

        Raises:
            StudyError: It cannot be started.
        """
        self.screens = 0
        self.showing = False
        try:
            self._ours, theirs = pty.openpty()
        except OSError as fault:
            text = f"there is no pseudo-terminal: {fault.strerror or fault}"
            raise StudyError(text) from fault
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", _ROWS, _COLUMNS, 0, 0))
        environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor"}
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-c", _AS_ITS_TERMINAL, *command],
                stdin=theirs,
                stdout=theirs,
                stderr=theirs,
                env=environment,
                start_new_session=True,
            )
        except OSError as fault:
            os.close(self._ours)
            text = f"{command[0]} cannot be started: {fault.strerror or fault}"
            raise StudyError(text) from fault
        finally:
            os.close(theirs)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def exit_code(self) -> int | None:
        """Its exit code; None: it runs."""
        return self._process.poll()

    def type(self, keys: str) -> None:
        """Type keys; a terminal whose program has ended takes none."""
        self._write(keys.encode())

    def press(self, key: str) -> None:
        """Press a key that types a small letter, or an arrow, and hold it."""
        self.type(f"\x1b[1;1:1{key}" if key in _ARROWS else f"\x1b[{ord(key)};;{ord(key)}u")

    def release(self, key: str) -> None:
        """Release a key."""
        self.type(f"\x1b[1;1:3{key}" if key in _ARROWS else f"\x1b[{ord(key)};1:3u")

    def close(self) -> None:
        """End the command, by force if it must be."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(_END_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self._process.wait()
        self._thread.join()
        os.close(self._ours)

    def _write(self, data: bytes) -> None:
        try:
            os.write(self._ours, data)
        except OSError:
            return

    def _read(self) -> None:
        rest = b""
        while True:
            if not select.select([self._ours], [], [], _READ_S)[0]:
                if self._process.poll() is not None:
                    return
                continue
            try:
                data = rest + os.read(self._ours, 1 << 16)
            except OSError:  # the command has ended
                return
            end = 0
            for found in _SEEN.finditer(data):
                end = found.end()
                self._see(found)
            rest = data[max(end, len(data) - _LONGEST) :]

    def _see(self, found: re.Match[bytes]) -> None:
        match found.lastgroup:
            case "column":
                self._write(b"\x1b[%s;%sR" % (found["row"], found["column"]))
            case "keys":
                self._write(_RELEASES)
            case "what":
                self._write(_ATTRIBUTES)
            case "enter":
                self.screens += 1
                self.showing = True
            case _:
                self.showing = False
