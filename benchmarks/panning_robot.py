"""A robot whose camera pans over a detailed scene and writes the time into each picture."""

from __future__ import annotations

import dataclasses
import multiprocessing
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from multiprocessing.connection import Connection

import numpy as np
import numpy.typing as npt

from benchmarks.camera_scenes import panning
from hub.gcm import rle, vision
from hub.gcm.navigation import ROBOT_STATE, VELOCITY_COMMAND, MotionState, RobotState
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from hub.robots.magellan import SimulatedMagellan
from hub.sim.arena import load_arena
from tests.messages import camera_state

Pixels = npt.NDArray[np.uint8]

COLUMNS, ROWS = 160, 48
PICTURE = (160, 96)
BITS, BLOCK = 16, 10
LAYOUT = f"""<rune>
  <robot name="r" hub="{{hub}}">
    <capability name="VIS_VID" interval_ms="{{interval}}"/><capability name="VIS_PTZ"/>
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


def age_of(pixels: Pixels, now: float) -> float | None:
    """How old the picture on a screen is [s]; None while it is not one whole picture."""
    across, height = COLUMNS / PICTURE[0], 2 * ROWS - 2
    columns = [round(across * BLOCK * (bit + 0.5)) for bit in range(BITS)]
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
        self.pictures = 0
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
        self.pictures += 1
        pixels = self._frames[self.pictures % len(self._frames)].copy()
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
    """The robot's process: says where it is, then when commands came, or how many pictures went."""
    with closing(Robot()) as robot:
        pipe.send(robot.central.endpoints[0])
        while (wanted := pipe.recv()) != "end":
            pipe.send(list(robot.commands) if wanted == "commands" else robot.pictures)


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
