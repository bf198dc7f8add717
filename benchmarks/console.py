"""What the console costs: processor time of its process while robots send it pictures.

Real processes: a console on a pseudo-terminal of 160x48 cells that is read as fast as it writes,
and robots in a process of their own, whose cameras were recorded on a turn in the yellow arena.
"""

from __future__ import annotations

import dataclasses
import math
import multiprocessing
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from multiprocessing.connection import Connection
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from hub.gcm import rle, vision
from hub.gcm.navigation import ROBOT_STATE, MotionState, RobotState
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.robots.magellan import SimulatedCamera, SimulatedMagellan
from hub.sim.arena import load_arena
from tests.system.harness import ConsoleProcess

COLUMNS, ROWS = 160, 48
WARM_S, MEASURED_S = 4.0, 12.0
PICTURES = 90
STEP = math.radians(4.0)
ROUNDS = 3

ROBOT = """<robot name="r{n}" hub="{hub}">
    <capability name="VIS_VID" interval_ms="{interval}"/><capability name="VIS_PTZ"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/>
  </robot>"""
PANES = """<viewport name="camera{n}" robot="r{n}" xpos="{x}" ypos="{y}" xsize="{w}" ysize="{h}">
      <visualizer function="visualizeCameraImage"/>
      <widget handler="widgetSetSpeed"><event key="{n}" control="translate"/></widget>
    </viewport>
    <viewport name="range{n}" robot="r{n}" transparency="96" zpos="1"
              xpos="{rx}" ypos="{ry}" xsize="{rs}" ysize="{rs}">
      <visualizer function="visualizeRangeData"/>
    </viewport>
    <viewport name="status{n}" robot="r{n}" zpos="2" xpos="{x}" ypos="{sy}" xsize="{w}" ysize="2">
      <visualizer function="visualizeStatus"/>
    </viewport>"""


class Robot:
    """A robot's hub: a central and one module that does what vision and navigation would."""

    def __init__(self, number: int, size: tuple[int, int]) -> None:
        self.answered = 0
        self._pictures = list(recorded(size))
        self._body = SimulatedMagellan(load_arena("yellow"), seed=number)
        self.central = Central(["tcp://127.0.0.1:0"])
        self._client = Client("robot", self.central.endpoints[0])
        self._client.define(vision.CAMERA_STATE, ROBOT_STATE)
        self._client.respond(vision.IMAGE_REQUEST, vision.IMAGE, self._picture)
        self._client.every(0.1, self._look)
        self._client.every(0.05, self._drive)
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

    def _picture(self, _: vision.ImageRequest) -> vision.Image:
        self.answered += 1
        return self._pictures[self.answered % len(self._pictures)]

    def _look(self) -> None:
        self._client.publish(vision.CAMERA_STATE, self._pictures[0].camera)

    def _drive(self) -> None:
        self._body.set_velocity(0.2, 0.5)
        self._body.advance(0.05)
        state = self._body.drive_state(time.time())
        known = {
            field.name: getattr(state, field.name, None) for field in dataclasses.fields(state)
        }
        shared = {field.name for field in dataclasses.fields(RobotState)}
        told = {name: value for name, value in known.items() if name in shared}
        told |= {"commanded_linear": 0.2, "commanded_angular": 0.5}
        self._client.publish(ROBOT_STATE, RobotState(**told, motion=MotionState.MOVING, refused=0))


def recorded(size: tuple[int, int]) -> Iterator[vision.Image]:
    """What a camera sees while the robot turns on the spot, coded as vision does."""
    arena = load_arena("yellow")
    camera = SimulatedCamera(arena)
    for number in range(PICTURES):
        camera.place(arena.start.x, arena.start.y, arena.start.theta + number * STEP)
        pixels = camera.take(*size, 0.0).pixels
        data = rle.encode(pixels, quality=60)
        yield vision.Image(
            camera=camera.camera_state(0.0),
            coding=vision.ImageCoding.RLE,
            width_px=pixels.shape[1],
            height_px=pixels.shape[0],
            channels=3,
            length=len(data),
            data=data,
        )


def robots(pipe: Connection, count: int, size: tuple[int, int]) -> None:
    """The process of the robots: says where they are, then how much they answered when asked."""
    with ExitStack() as stack:
        made = [stack.enter_context(closing(Robot(number, size))) for number in range(count)]
        pipe.send([robot.central.endpoints[0] for robot in made])
        while pipe.recv() == "count":
            pipe.send([robot.answered for robot in made])


@contextmanager
def fleet(count: int, size: tuple[int, int]) -> Iterator[tuple[Sequence[str], Connection]]:
    """Robots in a process of their own: where they are, and a way to ask them."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(
        target=robots, args=(theirs, count, size)
    )
    process.start()
    try:
        yield ours.recv(), ours
    finally:
        ours.send("end")
        process.join(10.0)


def layout(hubs: Sequence[str], interval: int) -> str:
    """One robot over the whole view, or four side by side."""
    across = 1 if len(hubs) == 1 else 2
    width, height = COLUMNS // across, 2 * ROWS // across
    panes, named = [], []
    for n, hub in enumerate(hubs):
        x, y = n % across * width, n // across * height
        side = height // 3
        named.append(ROBOT.format(n=n, hub=hub, interval=interval))
        panes.append(
            PANES.format(
                n=n,
                x=x,
                y=y,
                w=width,
                h=height,
                rx=x + width - side,
                ry=y + height - side - 2,
                rs=side,
                sy=y + height - 2,
            )
        )
    inside = "\n    ".join(panes)
    view = f'<view xsize="{COLUMNS}" ysize="{2 * ROWS}">\n    {inside}\n  </view>'
    return "<rune>\n  " + "\n  ".join(named) + f"\n  {view}\n</rune>\n"


def measured(count: int, interval: int) -> tuple[float, float, float]:
    """Share of a core that the console takes, pictures a second of each robot, bytes a second."""
    size = (128, 96) if count == 1 else (64, 48)
    with (
        tempfile.TemporaryDirectory() as folder,
        fleet(count, size) as (hubs, pipe),
    ):
        path = Path(folder) / "layout.xml"
        path.write_text(layout(hubs, interval))
        arguments = ["run", str(path)]
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(arguments, columns=COLUMNS, rows=ROWS, environment=environment)
        ) as console:
            console.drain(WARM_S)
            process = psutil.Process(console.process.pid)
            before, bytes_before = process.cpu_times(), console.output_bytes
            pipe.send("count")
            answered = pipe.recv()
            began = time.monotonic()
            console.drain(MEASURED_S)
            took = time.monotonic() - began
            after = process.cpu_times()
            pipe.send("count")
            shown = [b - a for a, b in zip(answered, pipe.recv(), strict=True)]
        spent = after.user + after.system - before.user - before.system
        return spent / took, min(shown) / took, (console.output_bytes - bytes_before) / took


def figure(name: str, bar: float, count: int, interval: int, wanted: float) -> None:
    """The median of some rounds."""
    rounds = []
    for number in range(ROUNDS):
        rounds.append(measured(count, interval))
        cpu, rate, size = rounds[-1]
        say(f"{name} {number + 1}: {cpu:.2f} cores, {rate:.1f} pictures/s, {size / 1e3:.0f} kB/s")
    cpu, rate, size = sorted(rounds)[len(rounds) // 2]
    note = f"{rate:.1f} pictures/s of each robot ({wanted:g} wanted), {size / 1e3:.0f} kB/s written"
    report(name, cpu, "of a core", bar=bar, note=note)


def main() -> None:
    figures = {
        "console.cpu_30fps": (0.5, 1, 0, 30.0),
        "console.cpu_4_robots_10fps": (0.6, 4, 100, 10.0),
    }
    for name in sys.argv[1:] or figures:
        figure(name, *figures[name])


if __name__ == "__main__":
    main()
