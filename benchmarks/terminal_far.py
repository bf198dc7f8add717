"""What an operator sees at the far end of a slow line: how old it is, and how soon keys show.

A real console on a pseudo-terminal, a real hub, and a camera that pans over a detailed scene and
writes the time into each picture, from where it is read off the screen at the far end.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import multiprocessing
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.camera_scenes import panning
from benchmarks.figures import report, say
from benchmarks.slow_terminal import Line, Screen, SlowTerminal
from hub.gcm import rle, vision
from hub.gcm.navigation import ROBOT_STATE, VELOCITY_COMMAND, MotionState, RobotState
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from hub.robots.magellan import SimulatedMagellan
from hub.sim.arena import load_arena
from tests.messages import camera_state
from tests.system.harness import ConsoleProcess

Pixels = npt.NDArray[np.uint8]

COLUMNS, ROWS = 160, 48
PICTURE = (160, 96)
BITS, BLOCK = 16, 10
WARM_S, MEASURED_S = 8.0, 20.0
KEYS = 8
LAYOUT = f"""<rune>
  <robot name="r" hub="{{hub}}">
    <capability name="VIS_VID" interval_ms="33"/><capability name="VIS_PTZ"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/>
  </robot>
  <view xsize="{COLUMNS}" ysize="{2 * ROWS}">
    <viewport name="camera" xpos="0" ypos="0" xsize="{COLUMNS}" ysize="{2 * ROWS - 2}">
      <visualizer function="visualizeCameraImage"><option name="fit" value="stretch"/></visualizer>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
    </viewport>
    <viewport name="status" xpos="0" ypos="{2 * ROWS - 2}" xsize="{COLUMNS}" ysize="2">
      <visualizer function="visualizeStatus"/>
    </viewport>
  </view>
</rune>"""


def stamped(pixels: Pixels, now: float) -> Pixels:
    """The picture with the time in milliseconds as black and white squares, above and below."""
    code = int(now * 1000) % (1 << BITS)
    for bit in range(BITS):
        shade = 255 if code >> bit & 1 else 0
        for edge in (pixels[:BLOCK], pixels[-BLOCK:]):
            edge[:, bit * BLOCK : (bit + 1) * BLOCK] = shade
    return pixels


def age_of(screen: Screen, now: float) -> float | None:
    """How old the picture on the screen is [s]; None while it is not one whole picture."""
    across, height = COLUMNS / PICTURE[0], 2 * ROWS - 2
    columns = [round(across * BLOCK * (bit + 0.5)) for bit in range(BITS)]
    pixels = screen.pixels()
    shades = [pixels[row, columns].mean(-1) for row in (BLOCK // 2, height - BLOCK // 2)]
    codes = {sum(1 << bit for bit, shade in enumerate(row) if shade > 127) for row in shades}
    clear = all(((row < 60) | (row > 195)).all() for row in shades)
    if len(codes) != 1 or not clear:
        return None
    return ((int(now * 1000) - codes.pop()) % (1 << BITS)) / 1000


class Robot:
    """A hub with a module that does what vision and navigation would."""

    def __init__(self) -> None:
        there = [cells.pixels[..., :3] for cells in panning()]
        self._frames = [*there, *there[-2:0:-1]]
        self._number = 0
        self._body = SimulatedMagellan(load_arena("yellow"), seed=1)
        self.central = Central(["tcp://127.0.0.1:0"])
        self._client = Client("robot", self.central.endpoints[0])
        self._client.define(vision.CAMERA_STATE, ROBOT_STATE)
        self._client.respond(vision.IMAGE_REQUEST, vision.IMAGE, self._picture)
        self._client.subscribe(VELOCITY_COMMAND, self._commanded)
        self._client.every(0.05, self._drive)
        self.commands: list[float] = []
        self._ended = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended = True
        self._thread.join()
        self._client.close()
        self.central.close()

    def _serve(self) -> None:
        while not self._ended:
            self._client.listen(0.05)

    def _commanded(self, _: object, reception: Reception) -> None:
        self.commands.append(reception.measured)

    def _picture(self, _: vision.ImageRequest) -> vision.Image:
        self._number += 1
        pixels = self._frames[self._number % len(self._frames)].copy()
        data = rle.encode(stamped(pixels, time.monotonic()), quality=100)
        return vision.Image(
            camera=camera_state(),
            coding=vision.ImageCoding.RLE,
            width_px=PICTURE[0],
            height_px=PICTURE[1],
            channels=3,
            length=len(data),
            data=data,
        )

    def _drive(self) -> None:
        state = self._body.drive_state(time.time())
        shared = {field.name for field in dataclasses.fields(RobotState)}
        told = {
            field.name: getattr(state, field.name)
            for field in dataclasses.fields(state)
            if field.name in shared
        }
        self._client.publish(ROBOT_STATE, RobotState(**told, motion=MotionState.MOVING, refused=0))


def serve(pipe: Connection) -> None:
    """The robot's process: says where it is, then when commands came."""
    with closing(Robot()) as robot:
        pipe.send(robot.central.endpoints[0])
        while pipe.recv() == "commands":
            pipe.send(list(robot.commands))


@contextmanager
def robot() -> Iterator[tuple[str, Connection]]:
    """A robot in a process of its own."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=serve, args=(theirs,))
    process.start()
    try:
        yield ours.recv(), ours
    finally:
        ours.send("end")
        process.join(10.0)


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
        path.write_text(LAYOUT.format(hub=hub))
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(["run", str(path)], columns=COLUMNS, rows=ROWS, environment=environment)
        ) as console:
            terminal = SlowTerminal(console, line, COLUMNS, ROWS)
            terminal.run(WARM_S)
            ages: list[float] = []
            last = [0.0]

            def look(now: float) -> bool:
                age = age_of(terminal.screen, now)
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
        path.write_text(LAYOUT.format(hub=hub))
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
