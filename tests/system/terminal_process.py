"""A command on a pseudo-terminal, as a person sees and drives it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import re
import select
import selectors
import signal
import struct
import termios
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any

import pyte

from tests.support import warm_start
from tests.support.waiting import Limit, until

_TERMINAL = {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
_CLOSED = -1


DELAY_S = 0.25
"""From a press to its first repeat, as short as on most keyboards [s]."""

_ASKED = re.compile(rb"\x1b\[(\d+);(\d+)H\x1b\[6n")
_QUESTION_BYTES = 16
"""A question is no longer, and may come in two pieces."""
_QUIET_S = 0.5
"""Time without a key after which the console takes keys again, and some more [s]."""
_IGNORED = "ignores keys typed"
"""What the console says of a key that may be old; then how often, on this line or the next two."""
_TIMES = re.compile(r"\((\d+) times\)")
_FULL_S = 0.1
"""A terminal that takes nothing for this time is full [s]."""
_ONE_KEY = re.compile(r"[^\x1b]|\x1b\[\d+~|\x1bO.|\x1b\[[A-Z]")


def write_keys(terminal: int, keys: bytes) -> None:
    """Write to a terminal which another thread may write to at the same time.

    The kernel refuses one of two such writes as if the terminal were full, but not for long.
    """
    while True:
        try:
            os.write(terminal, keys)
        except BlockingIOError:
            if not select.select([], [terminal], [], _FULL_S)[1]:
                raise
        else:
            return


class _Answering(pyte.Screen):
    """A terminal that answers what it is asked, as real ones do."""

    def __init__(self, columns: int, rows: int, terminal: int) -> None:
        super().__init__(columns, rows)
        self._terminal = terminal

    def write_process_input(self, data: str) -> None:
        with contextlib.suppress(OSError):  # nobody reads, or it has ended
            write_keys(self._terminal, data.encode())


_COMMON = re.compile(r"\x1b\[([\d;]*)([mHC])|([^\x00-\x1f\x7f-\x9f]+)")
_BEGUN = re.compile(r"\x1b(?:\[[0-?]*)?\Z")


class _QuickStream(pyte.ByteStream):
    """Reads what frames are made of by itself, all else as pyte does; that takes a third."""

    _rest = ""

    def feed(self, data: bytes) -> None:  # type: ignore[override]  # as in pyte itself
        """Take bytes cut anywhere."""
        text = self._rest + self.utf8_decoder.decode(data)
        begun = _BEGUN.search(text)
        end = begun.start() if begun else len(text)
        self._rest, at = text[end:], 0
        screen = self.listener
        does = {
            "m": screen.select_graphic_rendition,
            "H": screen.cursor_position,
            "C": screen.cursor_forward,
        }
        while at < end:
            found = _COMMON.match(text, at, end)
            if found is None:
                escape = text.find("\x1b", at + 1, end)
                before, at = at, escape if escape >= 0 else end
                pyte.Stream.feed(self, text[before:at])
                continue
            numbers, final, written = found.groups()
            if written is not None:
                screen.draw(written)
            else:
                does[final](*(int(each or 0) for each in numbers.split(";")) if numbers else ())
            at = found.end()


class TerminalProcess:
    """A command on a pseudo-terminal, with a terminal emulator that eats what it writes."""

    first_repeat = DELAY_S
    """From a press to its first repeat [s]."""

    def __init__(
        self,
        command: Sequence[str],
        *,
        columns: int = 100,
        rows: int = 30,
        environment: dict[str, str] | None = None,
    ) -> None:
        """Start it.

        Args:
            command: With its arguments.
            columns: Width of the terminal [cells].
            rows: Height of the terminal [cells].
            environment: Variables besides this process's own.
        """
        self.started = time.monotonic()
        self.terminal, inner = pty.openpty()
        self.screen = _Answering(columns, rows, self.terminal)
        self._stream = _QuickStream(self.screen)
        self.output_bytes = 0
        self._unread = b""
        self._typed = ""
        self._ignored: int | None = 0
        fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.process = warm_start.start(
            command,
            environment={**os.environ, **_TERMINAL, **(environment or {})},
            stdin=inner,
            stdout=inner,
            stderr=inner,
            terminal=True,
        )
        os.close(inner)
        os.set_blocking(self.terminal, False)

    def hang_up(self) -> None:
        """Close the terminal, as who closes its window."""
        os.close(self.terminal)
        self.terminal = _CLOSED

    def type(self, keys: str) -> None:
        """Press keys."""
        self._send(keys)
        # Counted when the screen changes next: to read it takes longer than a key to the wheels.
        self._typed, self._ignored = keys, None

    def _send(self, keys: str) -> None:
        write_keys(self.terminal, keys.encode())

    def _press_again(self) -> None:
        """Press the last key again where the console asks for that, as a person does.

        On a busy machine the console blocks at times, and ignores a key that may be old.
        """
        before = self._ignored
        if before is not None and _ONE_KEY.fullmatch(self._typed) and self._said_ignored() > before:
            again = time.monotonic() + _QUIET_S
            while time.monotonic() < again:
                self.pump()
            self.type(self._typed)

    def _said_ignored(self) -> int:
        """How often the console says on the screen that it ignored a key."""
        lines, times = self.screen.display, 0
        for row, line in enumerate(lines):
            if (column := line.find(_IGNORED)) >= 0:
                begin = max(0, column - len("00:00:00 the console "))
                notice = " ".join(each[begin:] for each in lines[row : row + 3])
                more = _TIMES.search(notice)
                times += int(more[1]) if more else 1
        return times

    def pump(self, seconds: float = 0.02) -> None:
        """Read what the console writes for a while."""
        if self.terminal == _CLOSED:
            time.sleep(seconds)
            return
        end = time.monotonic() + seconds
        with selectors.DefaultSelector() as selector:
            selector.register(self.terminal, selectors.EVENT_READ)
            while (left := end - time.monotonic()) > 0:
                if not selector.select(left):
                    return
                try:
                    data = os.read(self.terminal, 1 << 16)
                except OSError:  # the console closed its end
                    time.sleep(left)
                    return
                if self._ignored is None:
                    self._ignored = self._said_ignored()
                self.output_bytes += len(data)
                self._stream.feed(data)

    def drain(self, seconds: float) -> None:
        """Read for a while what it writes and make nothing of it, but answer what it asks."""
        end = time.monotonic() + seconds
        with selectors.DefaultSelector() as selector:
            selector.register(self.terminal, selectors.EVENT_READ)
            while (left := end - time.monotonic()) > 0:
                if not selector.select(left):
                    return
                data = os.read(self.terminal, 1 << 16)
                self.output_bytes += len(data)
                for row, column in _ASKED.findall(self._unread + data):
                    write_keys(self.terminal, b"\x1b[%s;%sR" % (row, column))
                if b"\x1b[c" in data:
                    write_keys(self.terminal, b"\x1b[?6c")
                self._unread = data[-_QUESTION_BYTES:] if not _ASKED.search(data[-32:]) else b""

    @contextlib.contextmanager
    def holding(self, keys: str, *, every: float = 0.033) -> Iterator[None]:
        """Keep a key down as a terminal shows it: a press and repeats.

        They come in time however long the emulator takes for what the console writes; a gap would
        be a release.
        """
        let_go = threading.Event()

        def repeat() -> None:
            pause = self.first_repeat
            self._send(keys)
            while not let_go.wait(pause):
                self._send(keys)
                pause = every

        self._typed = ""
        hand = threading.Thread(target=repeat)
        hand.start()
        try:
            yield
        finally:
            let_go.set()
            hand.join()

    def hold(self, keys: str, seconds: float, *, every: float = 0.033) -> None:
        """Keep a key down for a while."""
        end = time.monotonic() + seconds
        with self.holding(keys, every=every):
            while (left := end - time.monotonic()) > 0:
                self.pump(left)

    def hold_until(self, keys: str, condition: Any, timeout: float = 30.0) -> None:
        """Keep a key down until the robot does what it should.

        Where it does not, let go for a moment and press again, as a person does: on a machine that
        is busy, commands can fall silent for long enough that the robot wants neutral first.
        """
        limit = Limit(timeout)
        while True:
            let_go = time.monotonic() + 2.5
            with self.holding(keys):
                while time.monotonic() < let_go:
                    self.pump(0.1)
                    if condition():
                        return
            assert not limit.over, f"holding {keys!r} does nothing\n{self.text}"
            self.pump(1.0)

    @property
    def text(self) -> str:
        """What is written on the screen."""
        return "\n".join(self.screen.display)

    def colours(self) -> dict[tuple[int, int], tuple[str, str]]:
        """Foreground and background of every cell."""
        return {
            (row, column): (cell.fg, cell.bg)
            for row, line in self.screen.buffer.items()
            for column, cell in line.items()
        }

    def wait(self, condition: Any, timeout: float, why: str = "") -> None:
        """Wait for a condition while the console runs; press an ignored key again."""

        def meanwhile() -> None:
            self.pump(0.03)
            self._press_again()

        until(condition, timeout, lambda: f"{why}\n{self.text}", meanwhile=meanwhile)

    def wait_for_picture(self, timeout: float = 20.0) -> None:
        """Until the camera image is on the screen: many colours."""
        self.wait(lambda: self.has_picture, timeout, "no picture came")

    @property
    def has_picture(self) -> bool:
        return len(set(self.colours().values())) > 100

    def quit(self) -> int:
        """Press its quit key until it ends; it ignores keys typed while it was blocked."""
        limit = Limit(30.0)
        while self.process.poll() is None:
            assert not limit.over, f"it did not end\n{self.text}"
            with contextlib.suppress(OSError):  # it has just closed its end
                self.type("q")
            again = time.monotonic() + 1.0
            while self.process.poll() is None and time.monotonic() < again:
                self.pump(0.03)
        return self.process.wait()

    def wait_ended(self, timeout: float = 15.0) -> int:
        """Until it ended and all that it wrote is read; its exit code."""
        self.wait(lambda: self.process.poll() is not None, timeout, "it did not end")
        self.pump()
        return self.process.wait()

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            try:
                self.wait_ended(10.0)
            except AssertionError:
                self.process.kill()
                self.process.wait()
        if self.terminal != _CLOSED:
            self.hang_up()
