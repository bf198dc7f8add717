"""The only module that uses Textual's private interface; a test finds changes in new versions."""

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
from textual.message import Message
from textual.strip import Strip

from rune_tui.ui.driver_reports import UrgentReport
from rune_tui.ui.waking import waker

_TRIES: Final = 1000
"""Most tries to enter a terminal; each try stops the process, unless the terminal is lost."""
_LEAVING_S: Final = 1.0
"""Longest time to leave a blocked terminal [s]."""
_TAKING_S: Final = 0.2
"""Time for the terminal to read waiting output before it is discarded [s]."""
_UNDERSTOOD: Final = (
    _xterm_parser._re_mouse_event,
    _xterm_parser._re_terminal_mode_response,
    _xterm_parser._re_in_band_window_resize,
    _xterm_parser._re_extended_key,
)


def driver_of(app: App[Any]) -> Driver | None:
    """The driver, which writes past Textual's compositor; None before it runs."""
    return app._driver


def write_bytes(driver: Driver, data: bytes) -> None:
    """Write bytes in UTF-8."""
    write = getattr(driver, "write_bytes", None)
    if write is None:
        driver.write(data.decode())
    else:
        write(data)


def writes_waiting(driver: Driver | None) -> int:
    """Number of pieces of output in the writer thread's queue; the 31st blocks the console."""
    writer = getattr(driver, "_writer_thread", None)
    return 0 if writer is None else writer._queue.qsize()


def writes_block(driver: Driver) -> bool:
    """Whether the next piece of output would block the console."""
    writer = getattr(driver, "_writer_thread", None)
    return writer is not None and writer._queue.full()


def is_understood(sequence: str) -> bool:
    """Whether Textual understands an escape sequence."""
    known = sequence in ANSI_SEQUENCES_KEYS or sequence in _xterm_parser.SPECIAL_SEQUENCES
    return known or any(pattern.fullmatch(sequence) for pattern in _UNDERSTOOD)


def queue_is_idle(app: App[Any]) -> bool:
    """Whether an app has handled all its messages, and waits for the next one."""
    queue: Any = app._message_queue
    return bool(queue.empty()) and any(not each.done() for each in queue.ready_event._waiters)


class KeyParser(XTermParser):
    """Textual's parser, which can also look up a single sequence."""

    def keys_of(self, sequence: str) -> Iterable[events.Key]:
        """The keys of a sequence."""
        keys = self._sequence_to_key_events(sequence)
        return [key for key in keys if key.key != Keys.Ignore]


class LazyStrip(Strip):
    """A row whose segments are made on request."""

    __slots__ = ["_made"]

    def __init__(self, width: int) -> None:
        """Prepare a row of `width` cells."""
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
        """The last result of `render`."""
        return self._render_cache

    @kept.setter
    def kept(self, rendered: str) -> None:
        self._render_cache = rendered


with contextlib.suppress(ImportError):  # not on Windows
    import termios

    from textual.drivers._writer_thread import WriterThread
    from textual.drivers.linux_driver import LinuxDriver

    class _Sink:
        """Takes text, and bytes in UTF-8: to decode and encode frames takes long."""

        def __init__(self, file: TextIO) -> None:
            self._buffer = file.buffer
            self.flush, self.fileno = self._buffer.flush, self._buffer.fileno

        def write(self, data: str | bytes) -> None:
            self._buffer.write(data if isinstance(data, bytes) else data.encode(errors="replace"))

    def _discard(writer: WriterThread) -> None:
        """Discard the output that waits for the terminal."""
        with contextlib.suppress(queue.Empty):
            while True:
                writer._queue.get_nowait()

    class InsideDriver(LinuxDriver):
        """Takes bytes too, and leaves and enters the terminal once at each stop of the process.

        Textual's own starts second threads after any SIGCONT, and none after `bg`.
        """

        _away: bool = False
        """Whether another program has the terminal, or a change is under way."""
        _called_back: bool = False

        def __init__(self, app: App[Any], **options: Any) -> None:  # noqa: ANN401 - Textual's
            super().__init__(app, **options)
            self._hand_over = waker(self._loop, self._handle)

        def start_application_mode(self) -> None:
            """Enter the terminal."""
            if not isinstance(self._file, _Sink):
                self._file = _Sink(self._file)  # type: ignore[assignment,arg-type]
            super().start_application_mode()  # type: ignore[no-untyped-call]

        def send_message(self, message: Message) -> None:
            """Have the app handle a message, in order; Textual's way there delays each key."""
            self._hand_over(message)

        def write_bytes(self, data: bytes) -> None:
            """Write bytes in UTF-8."""
            self.write(data)  # type: ignore[arg-type] # the writer passes it on unchanged

        def _handle(self, message: Message) -> None:
            """Handle a message in the app's thread: at once, if no earlier one is on its way."""
            app = self._app
            urgent = isinstance(message, UrgentReport) and queue_is_idle(app)
            handler = getattr(app, message.handler_name, None) if urgent else None
            try:
                (handler or app.post_message)(message)
            except Exception as error:  # noqa: BLE001 - ends the app as from Textual's queue
                app._handle_exception(error)

        def discard_output(self) -> None:
            """Discard the output that waits for the terminal."""
            if self._writer_thread is not None:
                _discard(self._writer_thread)

        def suspend_application_mode(self) -> None:
            """Leave the terminal within a time limit, even if it blocks.

            Waiting output is discarded, as the next entry draws all cells. If necessary, the
            system's buffer is discarded too, to make room for the codes that leave the terminal.
            """
            writer = self._writer_thread
            if writer is None:
                return
            _discard(writer)
            self.stop_application_mode()
            writer._queue.put_nowait(None)
            writer.join(_TAKING_S)
            end = time.monotonic() + _LEAVING_S
            while writer.is_alive() and time.monotonic() < end:
                with contextlib.suppress(termios.error):
                    termios.tcflush(self.fileno, termios.TCOFLUSH)
                    # Linux reports room to a waiting writer only when output continues.
                    termios.tcflow(self.fileno, termios.TCOOFF)
                    termios.tcflow(self.fileno, termios.TCOON)
                writer.join(_TAKING_S / 10)
            if writer.is_alive():  # a late writer must not leave the entered terminal
                _discard(writer)
                writer._queue.put_nowait(None)

        def _sigtstp_application(self, *given: object) -> None:
            """Leave the terminal, then stop the process group, and enter again after it resumes.

            The shell must not get the terminal before it was left. After that Ctrl-Z is a signal
            again, and a repeating key must not leave the terminal twice.
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
            """Enter the terminal; in the background this stops the process until `fg`."""
            for _ in range(_TRIES):
                if not self._must_signal_resume:
                    break
                self.resume_application_mode()

        def _sigcont_application(self, *given: object) -> None:
            del given
            self._called_back = True
