"""What an operator sees at the far end of a slow line: how old it is, and how soon keys show.

A real console on a pseudo-terminal, a real hub, and a camera that pans over a detailed scene. The
camera writes the time into each picture; it is read off the screen at the far end.
"""

from __future__ import annotations

import itertools
import math
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.figures import report
from benchmarks.panning_robot import (
    COLUMNS,
    LAYOUT,
    PANE,
    ROWS,
    PanningCamera,
    Pixels,
    code_in,
    code_of,
    panning_robots,
)
from benchmarks.slow_terminal import Line, SlowTerminal
from benchmarks.stand_in_robot import fleet
from rune_tui.raster.resize import resized
from tests.support.thin_link import ADDRESS, ThinLink
from tests.system.harness import ConsoleProcess
from tests.system.ssh_server import SshServer, missing

WARM_S, MEASURED_S = 8.0, 20.0
KEYS = 8


@dataclass(slots=True)
class Seen:
    """What was seen at the far end.

    Attributes:
        ages: Of each picture when its time could be read [s].
        errors: What was wrong with the colours of each before the next was drawn; mean squares.
        keys: From pressing a key to seeing it [s].
        gaps: Between two commands while keys were pressed [s].
        fps: Pictures [1/s].
        bytes_per_s: Written by the console [bytes/s].
    """

    ages: list[float]
    errors: list[float]
    keys: list[float]
    gaps: list[float]
    fps: float
    bytes_per_s: float


class FarEye:
    """Looks at the screen at the far end.

    Attributes:
        first: When the time of each picture could first be read [s], by what was read.
        last: What the screen showed when it could last be read, by what was read.
    """

    def __init__(self, terminal: SlowTerminal) -> None:
        self.first: dict[int, float] = {}
        self.last: dict[int, Pixels] = {}
        self._terminal = terminal

    def look(self, now: float) -> bool:
        """Look once, and go on."""
        pixels = self._terminal.screen.pixels()
        if (code := code_in(pixels)) is not None:
            self.first.setdefault(code, now)
            self.last[code] = pixels
        return False


def watch(line: Line, within: Sequence[str] = ()) -> Seen:
    """A console at the end of a line, started by a command such as `ssh`."""
    with fleet(panning_robots) as robots, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=robots.hubs[0], interval=33))
        with closing(
            ConsoleProcess(
                ["run", str(path)],
                columns=COLUMNS,
                rows=ROWS,
                environment={"COLORTERM": "truecolor"},
                within=within,
            )
        ) as console:
            terminal = SlowTerminal(console, line, COLUMNS, ROWS)
            terminal.run(WARM_S)
            eye = FarEye(terminal)
            written, began = terminal.written, time.monotonic()
            terminal.run(MEASURED_S, eye.look)
            took = time.monotonic() - began
            bytes_per_s = (terminal.written - written) / took
            (pictures,) = robots.ask("pictures")
            pressed = time.monotonic()
            keys = [key_time(terminal) for _ in range(KEYS)]
            times = [at for at in robots.ask("commands")[0] if at > pressed]
    taken = {code_of(at): (number, at) for number, at in enumerate(pictures, 1)}
    camera = PanningCamera()
    wanted = {code: camera.taken(*taken[code]) for code in eye.first if code in taken}
    return Seen(
        ages=[eye.first[code] - taken[code][1] for code in wanted],
        errors=[wrong(eye.last[code], picture) for code, picture in wanted.items()],
        keys=keys,
        gaps=[b - a for a, b in itertools.pairwise(times)],
        fps=len(wanted) / took,
        bytes_per_s=bytes_per_s,
    )


def wrong(screen: Pixels, picture: Pixels) -> float:
    """The mean square of the difference between the screen and a camera's picture."""
    pane = screen[: PANE[1]]
    return float(np.square(pane - resized(picture, *PANE).astype(float)).mean())


def decibels(errors: list[float]) -> float:
    """Likeness of the pictures and those of the camera, on average [dB]."""
    return 10.0 * math.log10(255.0**2 / statistics.fmean(errors))


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
    """What tmux drops for a client that reads 2 MB/s [bytes]."""
    name, tmux = "link.tmux_discarded_bytes", shutil.which("tmux")
    if tmux is None:
        report(name, None, "bytes", bar=0, note="tmux is not installed")
        return
    own = [tmux, "-L", f"rune-far-{os.getpid()}"]
    settings = ["-f", os.devnull, "new-session", "-x", str(COLUMNS), "-y", str(ROWS + 1)]
    with fleet(panning_robots) as robots, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=robots.hubs[0], interval=33))
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
                command = [*own, "list-clients", "-F", "#{client_written} #{client_discarded}"]
                said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            finally:
                subprocess.run([*own, "kill-server"], capture_output=True, check=False)
    written, lost = (int(number) for number in said.split())
    report(name, lost, "bytes", bar=0, note=f"{written} bytes written")


def through_ssh() -> None:
    """The console on the robot in a real ssh session, which a relay makes slow."""
    if why := missing():
        tell("ssh_terminal", None, FIRST_BARS, why)
        return
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        server = stack.enter_context(closing(SshServer(Path(folder) / "ssh")))
        slow = ThinLink(f":{server.port}", rate=SSH_BIT_PER_S, room=2_000_000, ports=1)
        stack.enter_context(closing(slow))
        user = server.target.partition("@")[0]
        ssh = [str(server.path / "ssh"), "-tt", "-p", str(server.port), f"{user}@{ADDRESS}"]
        own = ["cd", str(Path.cwd()), "&&", "env", "COLORTERM=truecolor"]
        # Everything slow is on the way of ssh; its own terminal takes all at once.
        tell("ssh_terminal", watch(Line(width=1e9, round_trip=0.0), [*ssh, *own]), FIRST_BARS)


def over(name: str, line: Line, bars: dict[str, float | None]) -> None:
    """All figures of a line."""
    tell(name, watch(line), bars)


def tell(name: str, seen: Seen | None, bars: dict[str, float | None], why: str = "") -> None:
    """Report what was seen; why nothing was, if so."""
    values: dict[str, float] = {}
    note = why
    if seen is not None and seen.ages:
        values = {
            "age_median_ms": 1e3 * statistics.median(seen.ages),
            "age_max_ms": 1e3 * max(seen.ages),
            "key_ms": 1e3 * max(seen.keys),
            "stall_ms": 1e3 * (max(seen.gaps) - 0.2),
            "fps": seen.fps,
            "psnr_dB": decibels(seen.errors),
        }
        note = f"{seen.fps:.1f} pictures/s, {seen.bytes_per_s / 1e3:.0f} kB/s"
    elif seen is not None:
        note = "no picture could be read"
    for what, bar in bars.items():
        unit = {"fps": "1/s", "psnr_dB": "dB"}.get(what, "ms")
        better = "lower" if unit == "ms" else "higher"
        report(f"link.{name}_{what}", values.get(what), unit, bar=bar, better=better, note=note)


FIRST_BARS = {
    "age_median_ms": 250,
    "age_max_ms": 600,
    "key_ms": 250,
    "stall_ms": 50,
    "fps": 8,
    "psnr_dB": None,
}
SECOND_BARS = {"age_median_ms": 400, "fps": 3, "psnr_dB": None}
SSH_BIT_PER_S = 4e6
FIGURES: dict[str, Callable[[], None]] = {
    "500kBps": partial(over, "500kBps", Line(width=0.5e6, round_trip=0.04), FIRST_BARS),
    "100KiBps": partial(over, "100KiBps", Line(width=100 * 1024, round_trip=0.04), SECOND_BARS),
    "ssh_terminal": through_ssh,
    "tmux": discarded,
}
"""What `benchmarks.terminal_link` reports of it."""
