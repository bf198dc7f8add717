"""Real processes for system tests and benchmarks: a hub, and a console on a pseudo-terminal."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import pty
import re
import selectors
import signal
import struct
import subprocess
import sys
import termios
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, ClassVar

import psutil
import pyte
import pytest

from hub.gcm import navigation
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from tests.support import warm_start
from tests.support.waiting import until

ROBOT_FILE = """
name = "magellan"
kind = "{kind}"
[hub]
port = {port}
{gateway}
[simulation]
arena = "{arena}"
seed = 7
[mapping]
folder = "maps"
[mission]
folder = "missions"
{modules}
"""
MODULES = ("driver", "navigation", "vision")


def robot_file(
    arena: str = "empty",
    port: int = 0,
    gateway: str = "",
    modules: Sequence[str] = MODULES,
    tables: str = "",
    kind: str = "simulated-magellan",
) -> str:
    """A robot file; `gateway` is lines of its table of the hub, `tables` are more tables."""
    lines = "\n".join(f'[modules.{name}]\nrun = "hub.modules.{name}"' for name in modules)
    said = {"arena": arena, "port": port, "gateway": gateway, "kind": kind}
    return ROBOT_FILE.format(**said, modules=lines) + tables


def in_soak(*values: Any) -> list[Any]:
    """Parameters of a test that are tried in `make soak` only."""
    return [pytest.param(value, marks=pytest.mark.soak) for value in values]


_TERMINAL = {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
_CLOSED = -1
_FRESH_S = 0.08
"""Ground truth comes every 20 ms; what is older than this may be queued [s]."""


DELAY_S = 0.25
"""From a press to its first repeat, as short as on most keyboards [s]."""


class HubProcess:
    """`rune-hub run`, from start to end.

    Attributes:
        running: All that are not closed; the report of a failed test shows their logs.
    """

    running: ClassVar[list[HubProcess]] = []

    def __init__(
        self,
        folder: Path,
        *,
        options: Sequence[str] = (),
        environment: dict[str, str] | None = None,
        **robot_keys: Any,
    ) -> None:
        """Start it with a `robot_file` of these keys, and variables besides this process's own."""
        robot = folder / "robot.toml"
        robot.write_text(robot_file(**robot_keys))
        self.log = folder / "hub.log"
        command = [sys.executable, "-m", "hub", "run", str(robot), "--json", "--stop-with-stdin"]
        with self.log.open("wb") as log:
            self.process = warm_start.start(
                [*command, *options],
                environment={**os.environ, **(environment or {})},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log.fileno(),
            )
        self.running.append(self)
        try:
            self.listening = self._said("listening")
            self.endpoint = self.listening["hub"]
            self.pids: dict[str, int] = self._said("ready")["pids"]
        except BaseException:
            self.close()
            raise

    def _said(self, event: str) -> dict[str, Any]:
        pipe = self.process.stdout
        assert pipe is not None
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while selector.select(20.0):
                line = pipe.readline()
                assert line, f"the hub ended: {self.log.read_text()}"
                said: dict[str, Any] = json.loads(line)
                if said["event"] == event:
                    return said
        text = f"the hub never said {event}: {self.log.read_text()}"
        raise AssertionError(text)

    def close(self) -> None:
        """Stop it as the demo does."""
        if self in self.running:
            self.running.remove(self)
        if self.process.stdin is not None:
            self.process.stdin.close()
        self.process.wait(15.0)
        if self.process.stdout is not None:
            self.process.stdout.close()


class Observer:
    """A client that remembers messages with the time they came."""

    def __init__(self, endpoint: str, *definitions: MessageDefinition[Any]) -> None:
        self.client = Client(f"observer-{os.getpid()}-{id(self)}", endpoint)
        self.seen: dict[str, deque[tuple[float, Any]]] = {}
        self.client.wait_connected(5.0)
        for definition in definitions or (navigation.GROUND_TRUTH,):
            history: deque[tuple[float, Any]] = deque(maxlen=100_000)
            self.seen[definition.name] = history

            def remember(
                value: Any, reception: MessageInfo, history: deque[tuple[float, Any]] = history
            ) -> None:
                history.append((reception.measured, value))

            self.client.subscribe(definition, remember)
        self.wait(lambda: all(self.seen.values()), 10.0)

    @property
    def truth(self) -> navigation.GroundTruth:
        """Where the robot really is now."""
        self.wait(lambda: time.monotonic() - self.history[-1][0] < _FRESH_S, 10.0, "no truth comes")
        newest: navigation.GroundTruth = self.history[-1][1]
        return newest

    @property
    def history(self) -> deque[tuple[float, Any]]:
        """Ground truth with times on this process's monotonic clock."""
        return self.seen[navigation.GROUND_TRUTH.name]

    def wait(
        self,
        condition: Any,
        timeout: float,
        why: str | Callable[[], str] = "it did not happen",
    ) -> None:
        until(condition, timeout, why, meanwhile=lambda: self.client.listen(0.01))

    def close(self) -> None:
        self.client.close()


_ASKED = re.compile(rb"\x1b\[(\d+);(\d+)H\x1b\[6n")
_QUESTION_BYTES = 16
"""A question is no longer, and may come in two pieces."""
_IGNORED = "ignores keys typed"
"""What the console says of a key that may be old."""
_ONE_KEY = re.compile(r"[^\x1b]|\x1b\[\d+~|\x1bO.|\x1b\[[A-Z]")


class _Answering(pyte.Screen):
    """A terminal that answers what it is asked, as real ones do."""

    def __init__(self, columns: int, rows: int, terminal: int) -> None:
        super().__init__(columns, rows)
        self._terminal = terminal

    def write_process_input(self, data: str) -> None:
        with contextlib.suppress(OSError):  # nobody reads, or it has ended
            os.write(self._terminal, data.encode())


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
        self._ignored = 0
        fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.process = warm_start.start(
            command,
            environment={**_surroundings(), **_TERMINAL, **(environment or {})},
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
        self._typed, self._ignored = keys, self.text.count(_IGNORED)
        self._send(keys)

    def _send(self, keys: str) -> None:
        os.write(self.terminal, keys.encode())

    def _press_again(self) -> None:
        """Press the last key again where the console asks for that, as a person does.

        On a busy machine the console blocks at times, and ignores a key that may be old.
        """
        if _ONE_KEY.fullmatch(self._typed) and self.text.count(_IGNORED) > self._ignored:
            self.type(self._typed)

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
                    os.write(self.terminal, b"\x1b[%s;%sR" % (row, column))
                if b"\x1b[c" in data:
                    os.write(self.terminal, b"\x1b[?6c")
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
        end = time.monotonic() + timeout
        while True:
            let_go = time.monotonic() + 2.5
            with self.holding(keys):
                while time.monotonic() < let_go:
                    self.pump(0.1)
                    if condition():
                        return
            assert time.monotonic() < end, f"holding {keys!r} does nothing\n{self.text}"
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
        end = time.monotonic() + 30.0
        while self.process.poll() is None:
            assert time.monotonic() < end, f"it did not end\n{self.text}"
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


class ConsoleProcess(TerminalProcess):
    """`rune ...` on a pseudo-terminal."""

    def __init__(
        self, arguments: Sequence[str], *, within: Sequence[str] = (), **terminal: Any
    ) -> None:
        """Start it.

        Args:
            arguments: What follows `rune`.
            within: A command that runs it, such as a terminal multiplexer.
            **terminal: As of `TerminalProcess`.
        """
        super().__init__([*within, sys.executable, "-m", "rune_tui", *arguments], **terminal)


def _surroundings() -> dict[str, str]:
    """This process's environment, but for what it says of its own terminal."""
    own = ("NO_COLOR", "COLUMNS", "LINES")
    return {name: value for name, value in os.environ.items() if name not in own}


RELEASED_S = 0.8
"""After this time a key that was typed once counts as released [s]."""


def press(console: ConsoleProcess, key: str) -> None:
    """Press a key, and wait until the console counts it as released: it gets no release."""
    console.type(key)
    released = time.monotonic() + RELEASED_S
    console.wait(lambda: time.monotonic() > released, 10.0)


STILL = 1e-3
"""A robot that is slower stands [m/s]."""


def drive(console: ConsoleProcess, observer: Observer) -> None:
    """Hold the key for forward until the robot drives."""
    console.hold_until("w", lambda: observer.truth.linear > 0.2)


def expect_stop(observer: Observer) -> None:
    """The robot is told to stop soon, and does."""
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0, "the wheels are driven on")
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 2.0, "it rolls on")


def gone(processes: Sequence[psutil.Process]) -> bool:
    """Whether all of them have ended."""
    return not any(map(_runs, processes))


def _runs(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:  # it ended between the two looks
        return False


def family(pid: int) -> list[psutil.Process]:
    """A process and all its descendants."""
    process = psutil.Process(pid)
    return [process, *process.children(recursive=True)]
