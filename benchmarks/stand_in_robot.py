"""Robots to look at: each a hub with one module that does what vision and navigation would.

They run in a process of their own, so that nothing they take is counted with the console.
"""

from __future__ import annotations

import multiprocessing
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.gcm import rle, vision
from hub.gcm.navigation import ROBOT_STATE, VELOCITY_COMMAND, MotionState, RobotState
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.sim.arena import load_arena
from tests.support.magellan import SimulatedMagellan

DRIVE_S = 0.05
CAMERA_STATE_S = 0.1

Camera = Callable[[int, float], vision.Image]
"""Takes a picture, given its number and the time [s]."""


class StandInRobot:
    """It answers whenever it is asked for a picture, and drives in a circle or stands.

    Attributes:
        pictures: When each was taken [s].
        commands: When velocity commands came [s].
    """

    def __init__(self, camera: Camera, *, speeds: tuple[float, float] = (0.0, 0.0)) -> None:
        """Start it.

        Args:
            camera: Takes its pictures.
            speeds: How it drives: forward [m/s], turning [rad/s].
        """
        self.pictures: list[float] = []
        self.commands: list[float] = []
        self._camera, self._speeds = camera, speeds
        self._camera_state = camera(0, 0.0).camera
        self._body = SimulatedMagellan(load_arena("yellow"), seed=1)
        self._central = Central(["tcp://127.0.0.1:0"])
        self.hub = self._central.endpoints[0]
        self._client = Client("robot", self.hub)
        self._client.define(vision.CAMERA_STATE, ROBOT_STATE)
        self._client.respond(vision.IMAGE_REQUEST, vision.IMAGE, self._picture)
        self._client.subscribe(VELOCITY_COMMAND, self._commanded)
        self._client.every(CAMERA_STATE_S, self._publish_camera)
        self._client.every(DRIVE_S, self._drive)
        self._ended = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended = True
        self._thread.join()
        self._client.close()
        self._central.close()

    def _serve(self) -> None:
        while not self._ended:
            self._client.listen(0.05)

    def _commanded(self, _: object, reception: MessageInfo) -> None:
        self.commands.append(reception.measured)

    def _picture(self, _: vision.ImageRequest) -> vision.Image:
        self.pictures.append(time.monotonic())
        return self._camera(len(self.pictures), self.pictures[-1])

    def _publish_camera(self) -> None:
        self._client.publish(vision.CAMERA_STATE, self._camera_state)

    def _drive(self) -> None:
        self._body.set_velocity(*self._speeds)
        self._body.advance(DRIVE_S)
        state = self._body.drive_state(time.time())
        self._client.publish(
            ROBOT_STATE,
            RobotState(
                stamp=state.odometry.header.stamp.seconds,
                x=state.x,
                y=state.y,
                theta=state.theta,
                linear=state.linear,
                angular=state.angular,
                commanded_linear=state.commanded.linear.x,
                commanded_angular=state.commanded.angular.z,
                bumpers=state.bumpers,
                battery_voltage=24.0,
                battery_fraction=1.0,
                motion=MotionState.MOVING,
                refused=0,
            ),
        )


class Fleet:
    """The robots of a process, seen from another.

    Attributes:
        hubs: Where they are.
    """

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self.hubs: list[str] = pipe.recv()

    def ask(self, attribute: str) -> list[Any]:
        """An attribute of each robot, as it is now."""
        self._pipe.send(attribute)
        answer: list[Any] = self._pipe.recv()
        return answer

    def count(self) -> list[int]:
        """How many pictures each has taken."""
        return [len(taken) for taken in self.ask("pictures")]


Make = Callable[..., Sequence[StandInRobot]]


@contextmanager
def fleet(make: Make, *arguments: Any) -> Iterator[Fleet]:
    """Robots that `make` starts there with these arguments; all of them have to be picklable."""
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(
        target=_serve, args=(theirs, make, *arguments)
    )
    process.start()
    theirs.close()  # so that its end closes the pipe
    try:
        yield Fleet(ours)
    finally:
        ours.close()
        process.join(10.0)


def _serve(pipe: Connection, make: Make, *arguments: Any) -> None:
    with ExitStack() as stack:
        robots = [stack.enter_context(closing(robot)) for robot in make(*arguments)]
        pipe.send([robot.hub for robot in robots])
        with suppress(EOFError):
            while True:
                attribute = pipe.recv()
                pipe.send([getattr(robot, attribute) for robot in robots])


def coded(pixels: npt.NDArray[np.uint8], camera: vision.CameraState, quality: int) -> vision.Image:
    """A picture as vision sends it to consoles that are near."""
    data = rle.encode(pixels, quality=quality)
    return vision.Image(
        camera=camera,
        coding=vision.ImageCoding.RLE,
        width_px=pixels.shape[1],
        height_px=pixels.shape[0],
        channels=3,
        data=data,
    )
