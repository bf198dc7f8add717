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
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.figures import report, say
from benchmarks.panning_robot import COLUMNS, LAYOUT, ROWS, age_of, robot
from benchmarks.slow_terminal import Line, SlowTerminal
from tests.system.harness import ConsoleProcess
from tests.system.ssh_server import SshServer
from tests.thin_link import ADDRESS, ThinLink

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


def watch(line: Line, within: Sequence[str] = ()) -> Seen:
    """A console at the end of a line, started by a command such as `ssh`."""
    with robot() as (hub, pipe), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=hub, interval=33))
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(
                ["run", str(path)],
                columns=COLUMNS,
                rows=ROWS,
                environment=environment,
                within=within,
            )
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


def through_ssh(bars: dict[str, float]) -> None:
    """The console on the robot in a real ssh session, which a relay makes slow."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        try:
            server = stack.enter_context(closing(SshServer(Path(folder) / "ssh")))
        except pytest.skip.Exception as missing:
            for what, bar in bars.items():
                report(f"link.ssh_terminal_{what}", None, "ms", bar=bar, note=str(missing))
            return
        slow = ThinLink(f":{server.port}", rate=SSH_BIT_PER_S, room=2_000_000, ports=1)
        stack.enter_context(closing(slow))
        user = server.target.partition("@")[0]
        ssh = [str(server.path / "ssh"), "-tt", "-p", str(server.port), f"{user}@{ADDRESS}"]
        own = ["cd", str(Path.cwd()), "&&", "env", "COLORTERM=truecolor"]
        # Everything slow is on the way of ssh; its own terminal takes all at once.
        tell("ssh_terminal", watch(Line(width=1e9, round_trip=0.0), [*ssh, *own]), bars)


def figures(name: str, line: Line, bars: dict[str, float]) -> None:
    """All figures of a line."""
    tell(name, watch(line), bars)


def tell(name: str, seen: Seen, bars: dict[str, float]) -> None:
    """Report what was seen, in milliseconds."""
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


FIRST_BARS = {"age_median_ms": 250, "age_max_ms": 600, "key_ms": 250, "stall_ms": 50, "fps": 8}
SSH_BIT_PER_S = 4e6
LINES = {
    "500kBps": (Line(width=0.5e6, round_trip=0.04), FIRST_BARS),
    "100KiBps": (Line(width=100 * 1024, round_trip=0.04), {"age_median_ms": 400, "fps": 3}),
}


def main() -> None:
    for name in sys.argv[1:] or [*LINES, "ssh", "tmux"]:
        if name == "tmux":
            discarded()
        elif name == "ssh":
            through_ssh(FIRST_BARS)
        else:
            figures(name, *LINES[name])


if __name__ == "__main__":
    main()
