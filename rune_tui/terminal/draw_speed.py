"""How fast this terminal draws moving pictures; Unix only."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import selectors
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.screen_encoder import ScreenEncoder
from rune_tui.terminal.asking import unbuffered
from rune_tui.terminal.traits import Traits

_QUESTION: Final = b"\x1b[2;1H\x1b[6n"
_ANSWER: Final = re.compile(rb"\x1b\[\d{1,5};\d{1,5}R")
_ENTER, _LEAVE = b"\x1b[?1049h\x1b[?25l", b"\x1b[0m\x1b[?25h\x1b[?1049l"
_LATEST_S: Final = 5.0
"""Longest wait for an answer [s]."""
_TRIPS: Final = 5
"""Number of questions without a frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawSpeed:
    """Speed of drawing on a terminal.

    Attributes:
        size: Columns and rows.
        frames: Number of frames that the terminal has shown; 0: it does not answer.
        took: Time of all frames [s].
        sent: Size of all frames [bytes].
        encoding: Time to make the bytes of all frames [s].
        round_trip: Median time of an answer without a frame [s]; NaN: not known.
    """

    size: tuple[int, int]
    frames: int
    took: float
    sent: int
    encoding: float
    round_trip: float

    def as_json(self) -> str:
        """In one line, for programs; without an answer of the terminal, there are no speeds."""
        found: dict[str, float] = {
            "columns": self.size[0],
            "rows": self.size[1],
            "answers": self.frames > 0,
            "frames": self.frames,
        }
        if self.frames:
            found |= {
                "frames_per_s": round(self.frames / self.took, 2),
                "bytes_per_frame": round(self.sent / self.frames),
                "bytes_per_s": round(self.sent / self.took),
                "encode_ms": round(1000.0 * self.encoding / self.frames, 2),
                "round_trip_ms": round(1000.0 * self.round_trip, 2),
            }
        return json.dumps(found) + "\n"

    def report(self) -> str:
        """A line for each number, or why there is none."""
        size = f"{self.size[0]}x{self.size[1]} cells"
        if not self.frames:
            return f"{size}: the terminal does not answer, so its speed is not known\n"
        rate = self.frames / self.took
        lines = (
            ("size", size),
            ("frames", f"{self.frames} in {self.took:.1f} s: {rate:.1f} per second"),
            ("a frame", f"{self.sent / self.frames / 1000:.1f} kB"),
            ("line", f"{self.sent / self.took / 1e6:.2f} MB/s"),
            ("encoding", f"{1000 * self.encoding / self.frames:.1f} ms a frame"),
            ("round trip", f"{1000 * self.round_trip:.1f} ms"),
        )
        return "".join(f"{name:<11} {value}\n" for name, value in lines)


def moving_picture(number: int, columns: int, rows: int) -> Cells:
    """Frame of a picture in which every pixel changes; as a camera's, its neighbours are alike."""
    down, across = np.mgrid[: 2 * rows, :columns]
    waves = (across * 5 + number * 7, down * 6 - number * 5, across * 3 + down * 3 + number * 11)
    pixels = np.zeros((2 * rows, columns, 4), np.uint8)
    for channel, wave in enumerate(waves):
        pixels[..., channel] = np.abs(wave % 510 - 255)
    empty = np.zeros((rows, columns), np.uint32)
    return Cells(pixels=pixels, glyphs=empty, ink=np.zeros((rows, columns, 4), np.uint8))


def measure(
    source: int, sink: int, traits: Traits, size: tuple[int, int], seconds: float
) -> DrawSpeed:
    """Draw pictures for a time, each after the terminal has shown the one before.

    Args:
        source: File descriptor to read from.
        sink: File descriptor to write to.
        traits: What the terminal can do.
        size: Its columns and rows.
        seconds: The time [s].
    """
    encoder = ScreenEncoder(half=traits.glyphs.half)
    frames, sent, encoding, took = 0, 0, 0.0, 0.0
    trips: list[float] = []
    with unbuffered(source), selectors.DefaultSelector() as selector:
        selector.register(source, selectors.EVENT_READ)
        shown = partial(_shown, source, sink, selector.select)
        try:
            with contextlib.suppress(TimeoutError):
                trips.append(shown(_ENTER))
                while len(trips) < _TRIPS:
                    trips.append(shown(b""))
                end = time.monotonic() + seconds
                while time.monotonic() < end:
                    begin = time.monotonic()
                    cells = at_depth(moving_picture(frames, *size), traits.depth)
                    data = encoder.encode(cells)
                    encoded = time.monotonic() - begin
                    time_shown = shown(data)
                    frames, sent = frames + 1, sent + len(data)
                    encoding, took = encoding + encoded, took + encoded + time_shown
        finally:
            os.write(sink, _LEAVE)
    return DrawSpeed(
        size=size,
        frames=frames,
        took=took,
        sent=sent,
        encoding=encoding,
        round_trip=statistics.median(trips) if trips else math.nan,
    )


def _shown(source: int, sink: int, wait: Callable[[float], object], data: bytes) -> float:
    """Time until the terminal has shown some bytes [s].

    Raises:
        TimeoutError: It does not answer.
    """
    begin, received = time.monotonic(), b""
    rest = data + _QUESTION
    while rest:
        rest = rest[os.write(sink, rest) :]
    while not _ANSWER.search(received):
        left = begin + _LATEST_S - time.monotonic()
        piece = os.read(source, 4096) if left > 0.0 and wait(left) else b""
        if not piece:
            raise TimeoutError
        received = (received + piece)[-4096:]
    return time.monotonic() - begin
