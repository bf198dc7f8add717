"""All that the console uses of Textual beyond its public interface.

Nothing of it is used elsewhere, and a test says what is missing or different in another version.
"""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import time
from abc import abstractmethod
from collections.abc import Iterable
from typing import Any, Final, TextIO

from rich.segment import Segment
from textual import _xterm_parser, events
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual._xterm_parser import XTermParser
from textual.app import App
from textual.driver import Driver
from textual.keys import Keys
from textual.strip import Strip

_TRIES: Final = 1000
"""How often a terminal is entered that cannot be; each time stops, unless it has gone."""
_LEAVING_S: Final = 1.0
"""How long it may take to leave a terminal that takes nothing [s]."""
_TAKING_S: Final = 0.2
"""How long it is given to take what is on its way, before that is thrown away [s]."""
_UNDERSTOOD: Final = (
    _xterm_parser._re_mouse_event,
    _xterm_parser._re_terminal_mode_response,
    _xterm_parser._re_in_band_window_resize,
    _xterm_parser._re_extended_key,
)


def driver_of(app: App[Any]) -> Driver | None:
    """What writes to the terminal past Textual's compositor; None before it runs."""
    return app._driver


def write_bytes(driver: Driver, data: bytes) -> None:
    """Write what is UTF-8 already."""
    write = getattr(driver, "write_bytes", None)
    if write is None:
        driver.write(data.decode())
    else:
        write(data)


def writes_waiting(driver: Driver | None) -> int:
    """How many pieces of output wait for the terminal.

    Textual writes in a thread, from a queue that holds 30 pieces and then blocks the whole console.
    """
    writer = getattr(driver, "_writer_thread", None)
    return 0 if writer is None else writer._queue.qsize()


def writes_block(driver: Driver) -> bool:
    """Whether the next piece of output would hold up the console."""
    writer = getattr(driver, "_writer_thread", None)
    return writer is not None and writer._queue.full()


def is_understood(sequence: str) -> bool:
    """Whether Textual knows what an escape sequence means."""
    known = sequence in ANSI_SEQUENCES_KEYS or sequence in _xterm_parser.SPECIAL_SEQUENCES
    return known or any(pattern.fullmatch(sequence) for pattern in _UNDERSTOOD)


class KeyParser(XTermParser):
    """Textual's parser, which also tells what a single sequence is without being fed it."""

    def keys_of(self, sequence: str) -> Iterable[events.Key]:
        """The keys that a sequence stands for."""
        keys = self._sequence_to_key_events(sequence)
        return [key for key in keys if key.key != Keys.Ignore]


class LazyStrip(Strip):
    """A row whose segments are made when something asks for them."""

    __slots__ = ["_made"]

    def __init__(self, width: int) -> None:
        """Prepare a row of so many cells."""
        self._made: list[Segment] | None = None
        super().__init__((), width)
        self._cell_count = width

    @abstractmethod
    def segments(self) -> list[Segment]:
        """The row's segments."""

    # Shadows the slot of Strip.
    @property
    def _segments(self) -> list[Segment]:
        if self._made is None:
            self._made = self.segments()
        return self._made

    @_segments.setter
    def _segments(self, value: list[Segment]) -> None:
        del value  # Strip's constructor sets none

    @property
    def kept(self) -> str | None:
        """What `render` gave the last time."""
        return self._render_cache

    @kept.setter
    def kept(self, rendered: str) -> None:
        self._render_cache = rendered


with contextlib.suppress(ImportError):  # Windows has no such terminals
    import termios

    from textual.drivers._writer_thread import WriterThread
    from textual.drivers.linux_driver import LinuxDriver

    class _Sink:
        """Takes text, and bytes that are UTF-8 already: decoding and encoding frames takes long."""

        def __init__(self, file: TextIO) -> None:
            self._buffer = file.buffer
            self.flush, self.fileno = self._buffer.flush, self._buffer.fileno

        def write(self, data: str | bytes) -> None:
            self._buffer.write(data if isinstance(data, bytes) else data.encode(errors="replace"))

    def _throw_away(writer: WriterThread) -> None:
        """Have what waits for the terminal not be written."""
        with contextlib.suppress(queue.Empty):
            while True:
                writer._queue.get_nowait()

    class InsideDriver(LinuxDriver):
        """Takes bytes too, and leaves and enters the terminal once for each time it is stopped.

        Textual's own would read and write in two threads after any SIGCONT, and in none after `bg`.
        """

        _away: bool = False
        """Whether the terminal is left or entered, or somebody else's."""
        _called_back: bool = False

        def start_application_mode(self) -> None:
            """Enter the terminal."""
            if not isinstance(self._file, _Sink):
                self._file = _Sink(self._file)  # type: ignore[assignment,arg-type]
            super().start_application_mode()  # type: ignore[no-untyped-call]

        def write_bytes(self, data: bytes) -> None:
            """Write what is UTF-8 already."""
            self.write(data)  # type: ignore[arg-type] # the writer hands it on as it is

        def suspend_application_mode(self) -> None:
            """Leave the terminal soon, even if it takes nothing.

            What waits for it is drawn anew when it is entered again. So it is thrown away, and if
            need be also what the system keeps for the terminal, so that there is room for what
            leaves it.
            """
            writer = self._writer_thread
            if writer is None:
                return
            _throw_away(writer)
            self.stop_application_mode()
            writer._queue.put_nowait(None)
            writer.join(_TAKING_S)
            end = time.monotonic() + _LEAVING_S
            while writer.is_alive() and time.monotonic() < end:
                with contextlib.suppress(termios.error):
                    termios.tcflush(self.fileno, termios.TCOFLUSH)
                    # Linux tells whoever waits for room of it only when output goes on.
                    termios.tcflow(self.fileno, termios.TCOOFF)
                    termios.tcflow(self.fileno, termios.TCOON)
                writer.join(_TAKING_S / 10)
            if writer.is_alive():  # it must not leave the terminal once that is entered again
                _throw_away(writer)
                writer._queue.put_nowait(None)

        def _sigtstp_application(self, *given: object) -> None:
            """Leave the terminal, only then stop with all that the shell started, and come back.

            Else the shell would have the terminal before it was left. As soon as that is left,
            Ctrl-Z is a signal again: a key that repeats must not have it left twice.
            """
            del given
            if self._away:
                return
            self._away, self._called_back = True, False
            if self._auto_restart:
                self.suspend_application_mode()
                self._must_signal_resume = True
            if not self._called_back:
                alone = os.getpgrp() == os.getsid(0)
                os.kill(os.getpid() if alone else -os.getpgrp(), signal.SIGSTOP)
            self._enter_again()
            self._away = False

        def _enter_again(self) -> None:
            """Enter the terminal; in the background that stops the console until it is in front."""
            for _ in range(_TRIES):
                if not self._must_signal_resume:
                    break
                self.resume_application_mode()

        def _sigcont_application(self, *given: object) -> None:
            del given
            self._called_back = True
