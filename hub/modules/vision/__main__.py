"""The vision process: answers image requests and moves the camera."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from hub.errors import HandlerFailedError
from hub.gcm import navigation, rle, vision
from hub.gcm.capability import Abilities, Capability
from hub.ipc.client import Client
from hub.ipc.reception import Reception
from hub.modules.vision.picture import prepare
from hub.robots.description import RobotDescription
from hub.robots.registry import KINDS
from hub.runtime import publish_on_request, run_module

_STEP_PERIOD = 0.02
_STATE_PERIOD = 1.0 / vision.CAMERA_STATE.rate_hz


def build(client: Client, robot: RobotDescription) -> Callable[[], None]:
    """Connect the camera to the bus."""
    camera = KINDS[robot.kind].open_camera(robot)
    clock = time.monotonic
    last = clock()

    def advance() -> None:
        nonlocal last
        now = clock()
        camera.advance(now - last)
        last = now

    def answer(request: vision.ImageRequest) -> vision.Image:
        if request.width_px < 1 or request.height_px < 1:
            text = f"a picture of {request.width_px}x{request.height_px} pixels cannot be taken"
            raise HandlerFailedError(text)
        advance()
        state = camera.camera_state(time.time())
        pixels = prepare(camera.capture(request.width_px, request.height_px), request.kind)
        data = rle.encode(pixels, quality=request.quality)
        return vision.Image(
            camera=state,
            coding=vision.ImageCoding.RLE,
            width_px=pixels.shape[1],
            height_px=pixels.shape[0],
            channels=1 if pixels.ndim == 2 else pixels.shape[2],
            length=len(data),
            data=data,
        )

    def move(command: vision.CameraCommand, reception: Reception) -> None:
        del reception
        advance()
        camera.move(command)

    def place(truth: navigation.GroundTruth, reception: Reception) -> None:
        del reception
        camera.place(truth.x, truth.y, truth.theta)

    def publish_state() -> None:
        advance()
        client.publish(vision.CAMERA_STATE, camera.camera_state(time.time()))

    client.respond(vision.IMAGE_REQUEST, vision.IMAGE, answer)
    client.subscribe(vision.CAMERA_COMMAND, move)
    client.subscribe(navigation.GROUND_TRUTH, place)
    client.define(vision.CAMERA_STATE)
    publish_on_request(client, vision.CAMERA_STATE, publish_state)
    client.every(_STEP_PERIOD, advance)
    client.every(_STATE_PERIOD, publish_state)
    return lambda: None


def abilities(robot: RobotDescription) -> Abilities:
    """What vision can do on a robot."""
    needs = (Capability.SIM_TRUTH,) if robot.simulated else ()
    return Abilities(provides=(Capability.VIS_VID, Capability.VIS_PTZ), needs=needs)


def main() -> int:
    """Run the process."""
    purpose = "Answers image requests and moves the pan/tilt/zoom camera."
    return run_module("vision", purpose, abilities, build)


if __name__ == "__main__":
    sys.exit(main())
