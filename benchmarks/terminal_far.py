"""What an operator sees at the far end of a slow line: how old it is, and how soon keys show.

A real console on a pseudo-terminal, a real hub, and a camera that pans over a detailed scene and
writes the time into each picture, from where it is read off the screen at the far end.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.figures import report, say
from benchmarks.panning_robot import COLUMNS, LAYOUT, ROWS, age_of, robot
from benchmarks.slow_terminal import Line, SlowTerminal
from tests.system.harness import ConsoleProcess

Pixels = npt.NDArray[np.uint8]

WARM_S, MEASURED_S = 8.0, 20.0
KEYS = 8


@dataclasses.dataclass(slots=True)
class Seen:
    """What was seen at the far end."""

    ages: list[float]
    keys: list[float]
    gaps: list[float]
    fps: float
    bytes_per_s: float


def watch(line: Line) -> Seen:
    """A console at the end of a line."""
    with robot() as (hub, pipe), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=hub, interval=33))
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(["run", str(path)], columns=COLUMNS, rows=ROWS, environment=environment)
        ) as console:
            terminal = SlowTerminal(console, line, COLUMNS, ROWS)
            terminal.run(WARM_S)
            ages: list[float] = []
            last = [0.0]

            def look(now: float) -> bool:
                age = age_of(terminal.screen.pixels(), now)
                if age is not None and abs((taken := now - age) - last[0]) > 0.002:
                    last[0] = taken
                    ages.append(age)
                return False

            written, began = terminal.written, time.monotonic()
            terminal.run(MEASURED_S, look)
            took = time.monotonic() - began
            bytes_per_s = (terminal.written - written) / took
            frames = len(ages)
            pressed = time.monotonic()
            keys = [key_time(terminal) for _ in range(KEYS)]
            pipe.send("commands")
            times = [at for at in pipe.recv() if at > pressed]
            gaps = [b - a for a, b in itertools.pairwise(times)]
            return Seen(ages, keys, gaps, frames / took, bytes_per_s)


def key_time(terminal: SlowTerminal) -> float:
    """From pressing a key at the far end to seeing there that it counts as held [s]."""
    shown = [math.nan]

    def look(now: float) -> bool:
        if "keys w" not in terminal.screen.text(ROWS - 1):
            return False
        shown[0] = now
        return True

    began = time.monotonic()
    terminal.type("w")
    terminal.run(10.0, look)
    terminal.run(1.5)
    return shown[0] - began


def discarded() -> None:
    """What tmux throws away for a client that reads 2 MB/s [bytes]."""
    name, tmux = "link.tmux_discarded_bytes", shutil.which("tmux")
    if tmux is None:
        report(name, None, "bytes", bar=0, note="tmux is not installed")
        return
    own = [tmux, "-L", f"rune-far-{os.getpid()}"]
    settings = ["-f", os.devnull, "new-session", "-x", str(COLUMNS), "-y", str(ROWS + 1)]
    with robot() as (hub, _), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=hub, interval=33))
        arguments = ["run", str(path), "--colors", "truecolor"]
        with closing(
            ConsoleProcess(
                arguments,
                columns=COLUMNS,
                rows=ROWS + 1,
                environment={"COLORTERM": "truecolor"},
                within=[*own, "-T", "RGB", *settings],
            )
        ) as console:
            try:
                line = Line(width=2e6, round_trip=0.001, buffer=1 << 16)
                terminal = SlowTerminal(console, line, COLUMNS, ROWS + 1)
                terminal.run(WARM_S + MEASURED_S)
                told = [*own, "list-clients", "-F", "#{client_written} #{client_discarded}"]
                said = subprocess.run(told, capture_output=True, text=True, check=True).stdout
            finally:
                subprocess.run([*own, "kill-server"], capture_output=True, check=False)
    written, lost = (int(number) for number in said.split())
    report(name, lost, "bytes", bar=0, note=f"{written} bytes written")


def figures(name: str, line: Line, bars: dict[str, float]) -> None:
    """All figures of a line, in milliseconds."""
    seen = watch(line)
    if not seen.ages:
        for what, bar in bars.items():
            report(f"link.{name}_{what}", None, "ms", bar=bar, note="no picture could be read")
        return
    say(f"{name}: {seen.fps:.1f} pictures/s, {seen.bytes_per_s / 1e3:.0f} kB/s")
    values = {
        "age_median_ms": 1e3 * statistics.median(seen.ages),
        "age_max_ms": 1e3 * max(seen.ages),
        "key_ms": 1e3 * max(seen.keys),
        "stall_ms": 1e3 * (max(seen.gaps) - 0.2),
        "fps": seen.fps,
    }
    for what, bar in bars.items():
        better = "higher" if what == "fps" else "lower"
        unit = "1/s" if what == "fps" else "ms"
        report(f"link.{name}_{what}", values[what], unit, bar=bar, better=better)


LINES = {
    "500kBps": (
        Line(width=0.5e6, round_trip=0.04),
        {"age_median_ms": 250, "age_max_ms": 600, "key_ms": 250, "stall_ms": 50, "fps": 8},
    ),
    "100KiBps": (Line(width=100 * 1024, round_trip=0.04), {"age_median_ms": 400, "fps": 3}),
}


def main() -> None:
    for name in sys.argv[1:] or [*LINES, "tmux"]:
        if name == "tmux":
            discarded()
        else:
            figures(name, *LINES[name])


if __name__ == "__main__":
    main()
