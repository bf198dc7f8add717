"""What the console costs: processor time of its process while robots send it pictures.

Real processes: a console on a pseudo-terminal of 160x48 cells that is read as fast as it writes,
and robots in a process of their own. Their pictures were recorded on a turn in the yellow arena.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from benchmarks.stand_in_robot import StandInRobot, coded, fleet
from hub.gcm import vision
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose
from tests.support.magellan import magellan_camera
from tests.system.harness import ConsoleProcess

COLUMNS, ROWS = 160, 48
WARM_S, MEASURED_S = 4.0, 12.0
PICTURES = 90
STEP = math.radians(4.0)
ROUNDS = 3
SHAPES = {1: (1, 1), 4: (2, 2), 8: (4, 2)}
"""Viewports across and down, by the number of robots."""

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


class Recording:
    """What a camera sees while the robot turns on the spot, coded as vision does."""

    def __init__(self, size: tuple[int, int]) -> None:
        arena = load_arena("yellow")
        camera = magellan_camera(arena)
        self._pictures = []
        for number in range(PICTURES):
            heading = arena.start.theta + number * STEP
            camera.place(SpatialPose(x=arena.start.x, y=arena.start.y, yaw=heading))
            pixels = camera.take(*size, 0.0).pixels
            self._pictures.append(coded(pixels, camera.camera_state(0.0), quality=60))

    def __call__(self, number: int, _: float) -> vision.Image:
        return self._pictures[number % len(self._pictures)]


def recorded_robots(count: int, size: tuple[int, int]) -> list[StandInRobot]:
    """Start this number of robots."""
    recording = Recording(size)
    return [StandInRobot(recording, speeds=(0.2, 0.5)) for _ in range(count)]


def layout(hubs: Sequence[str], interval: int) -> str:
    """One robot over the whole view, or several side by side."""
    across, down = SHAPES[len(hubs)]
    width, height = COLUMNS // across, 2 * ROWS // down
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


def measured(count: int, interval: int, *, recording: bool) -> tuple[float, float, float]:
    """Share of a core that the console takes, pictures a second of each robot, bytes a second."""
    size = {1: (128, 96), 4: (64, 48), 8: (40, 30)}[count]
    with (
        tempfile.TemporaryDirectory() as folder,
        fleet(recorded_robots, count, size) as robots,
    ):
        path = Path(folder) / "layout.xml"
        path.write_text(layout(robots.hubs, interval))
        arguments = ["run", str(path), *(["--record", folder] if recording else [])]
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(arguments, columns=COLUMNS, rows=ROWS, environment=environment)
        ) as console:
            console.drain(WARM_S)
            process = psutil.Process(console.process.pid)
            before, bytes_before = process.cpu_times(), console.output_bytes
            taken = robots.count()
            began = time.monotonic()
            console.drain(MEASURED_S)
            took = time.monotonic() - began
            after = process.cpu_times()
            shown = [b - a for a, b in zip(taken, robots.count(), strict=True)]
        spent = after.user + after.system - before.user - before.system
        return spent / took, min(shown) / took, (console.output_bytes - bytes_before) / took


def figure(
    name: str, bar: float, count: int, interval: int, wanted: float, *, recording: bool = False
) -> None:
    """The median of some rounds."""
    rounds = []
    for number in range(ROUNDS):
        rounds.append(measured(count, interval, recording=recording))
        cpu, rate, size = rounds[-1]
        say(f"{name} {number + 1}: {cpu:.2f} cores, {rate:.1f} pictures/s, {size / 1e3:.0f} kB/s")
    cpu, rate, size = sorted(rounds)[len(rounds) // 2]
    note = f"{rate:.1f} pictures/s of each robot ({wanted:g} wanted), {size / 1e3:.0f} kB/s written"
    report(name, cpu, "of a core", bar=bar, note=note)


def main() -> None:
    figures = {
        "console.cpu_30fps": (0.5, 1, 0, 30.0),
        "console.cpu_4_robots_10fps": (0.6, 4, 100, 10.0),
        "console.cpu_8_robots_5fps": (0.6, 8, 200, 5.0),
    }
    recorded = {"console.cpu_30fps_recorded": figures["console.cpu_30fps"]}
    for name in sys.argv[1:] or [*figures, *recorded]:
        figure(name, *{**figures, **recorded}[name], recording=name in recorded)


if __name__ == "__main__":
    main()
