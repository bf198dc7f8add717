"""A terminal at the far end of a slow line: a buffer, a width, a delay, and a screen.

The console runs on a real pseudo-terminal. What it writes waits in a buffer, leaves it at a
fixed rate, and reaches the screen half a round trip later; what is typed and answered takes the
other half.
"""

from __future__ import annotations

import contextlib
import os
import re
import selectors
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.system.harness import ConsoleProcess

_TOKEN = re.compile(
    r"\x1b\[([\d;]*)([A-Za-z])|\x1b\[[?><=][0-?]*[ -/]*[@-~]|\x1b[P\]][^\x1b]*\x1b\\|\x1b.|"
    r"([^\x00-\x1f\x7f\x1b]+)|[\x00-\x1f]",
    re.DOTALL,
)
_PART = re.compile(r"\x1b(\[[0-?]*|[P\]][^\x1b]*\x1b?)?\Z")
_READ_BYTES = 1 << 16
_SLICE_S = 0.004
"""How finely the line's time is sliced [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """The way between console and terminal.

    Attributes:
        width: What it takes [bytes/s].
        round_trip: There and back, empty [s].
        buffer: What may wait at its beginning [bytes].
    """

    width: float
    round_trip: float
    buffer: int = 2_000_000


class Screen:
    """What a truecolour terminal shows: characters, ink and ground of each cell."""

    def __init__(self, columns: int, rows: int) -> None:
        self.marks = np.full((rows, columns), ord(" "), np.uint32)
        self.ink = np.zeros((rows, columns, 3), np.uint8)
        self.ground = np.zeros((rows, columns, 3), np.uint8)
        self._row = self._column = 0
        self._colours = {38: (255, 255, 255), 48: (0, 0, 0)}
        self._rest = ""

    def feed(self, data: bytes) -> list[tuple[int, int] | None]:
        """Show it; the questions in it: where the cursor is, counted from 1, or None for "who"."""
        text = self._rest + data.decode(errors="replace")
        cut = _PART.search(text)
        self._rest = cut[0] if cut else ""
        asked: list[tuple[int, int] | None] = []
        for token in _TOKEN.finditer(text, 0, cut.start() if cut else len(text)):
            numbers, final, written = token.groups()
            if written:
                self._write(written)
            elif final == "m":
                self._colour(numbers)
            elif final == "H":
                row, _, column = (numbers or "1;1").partition(";")
                self._row, self._column = int(row or 1) - 1, int(column or 1) - 1
            elif final == "C":
                self._column += int(numbers or 1)
            elif final == "n" and numbers == "6":
                asked.append((self._row + 1, self._column + 1))
            elif final == "c" and not numbers:
                asked.append(None)
            elif token[0] == "\n":
                self._row, self._column = self._row + 1, 0
        return asked

    def text(self, row: int) -> str:
        """What is written in a row."""
        return "".join(map(chr, self.marks[row]))

    def pixels(self) -> npt.NDArray[np.uint8]:
        """The expected picture, two pixels a cell, shape (2 * rows, columns, 3)."""
        upper, lower = self.ground.copy(), self.ground.copy()
        for shape, halves in {"▀": (upper,), "▄": (lower,), "█": (upper, lower)}.items():
            where = self.marks == ord(shape)
            for half in halves:
                half[where] = self.ink[where]
        return np.stack([upper, lower], 1).reshape(-1, *upper.shape[1:])

    def _write(self, text: str) -> None:
        row, first = self._row, self._column
        end = min(first + len(text), self.marks.shape[1])
        if 0 <= row < len(self.marks) and first < end:
            self.marks[row, first:end] = [ord(c) for c in text[: end - first]]
            self.ink[row, first:end] = self._colours[38]
            self.ground[row, first:end] = self._colours[48]
        self._column += len(text)

    def _colour(self, numbers: str) -> None:
        parts = [int(number or 0) for number in numbers.split(";")]
        while parts:
            code = parts.pop(0)
            if code in self._colours and parts[:1] == [2]:
                self._colours[code] = (parts[1], parts[2], parts[3])
                del parts[:4]
            elif code == 0:
                self._colours = {38: (255, 255, 255), 48: (0, 0, 0)}


class SlowTerminal:
    """The far end of the line, and the line."""

    def __init__(self, console: ConsoleProcess, line: Line, columns: int, rows: int) -> None:
        self.screen = Screen(columns, rows)
        self.written = 0
        self._console = console
        self._line = line
        self._waiting: deque[bytes] = deque()
        self._queued = 0
        self._going: deque[tuple[float, bytes]] = deque()
        self._coming: deque[tuple[float, bytes]] = deque()
        self._spare = 0.0
        self._moved = time.monotonic()

    def type(self, keys: str) -> None:
        """Press keys at the far end."""
        self._return(keys.encode())

    def run(self, seconds: float, looked: Callable[[float], bool] | None = None) -> None:
        """Let time go by; after each change of the screen `looked` may end it with True."""
        end = time.monotonic() + seconds
        with selectors.DefaultSelector() as selector:
            selector.register(self._console.terminal, selectors.EVENT_READ)
            while (now := time.monotonic()) < end:
                if self._queued < self._line.buffer:
                    if selector.select(_SLICE_S):
                        self._read()
                else:
                    time.sleep(_SLICE_S)
                self._move()
                if self._arrive() and looked is not None and looked(time.monotonic()):
                    return
                self._give_back(now)

    def _read(self) -> None:
        with contextlib.suppress(OSError):
            data = os.read(self._console.terminal, _READ_BYTES)
            self._waiting.append(data)
            self._queued += len(data)
            self.written += len(data)

    def _move(self) -> None:
        """What leaves the buffer now."""
        now = time.monotonic()
        self._spare += (now - self._moved) * self._line.width
        self._moved = now
        if not self._waiting:
            self._spare = min(self._spare, _SLICE_S * self._line.width)
        while self._waiting and self._spare >= 1.0:
            data = self._waiting.popleft()
            part, rest = data[: int(self._spare)], data[int(self._spare) :]
            if rest:
                self._waiting.appendleft(rest)
            self._spare -= len(part)
            self._queued -= len(part)
            self._going.append((now + self._line.round_trip / 2, part))

    def _arrive(self) -> bool:
        """Show what is there; whether anything was."""
        arrived = b""
        while self._going and self._going[0][0] <= time.monotonic():
            arrived += self._going.popleft()[1]
        for place in self.screen.feed(arrived) if arrived else ():
            self._return(b"\x1b[?6c" if place is None else b"\x1b[%d;%dR" % place)
        return bool(arrived)

    def _return(self, data: bytes) -> None:
        self._coming.append((time.monotonic() + self._line.round_trip / 2, data))

    def _give_back(self, now: float) -> None:
        while self._coming and self._coming[0][0] <= now:
            os.write(self._console.terminal, self._coming.popleft()[1])
