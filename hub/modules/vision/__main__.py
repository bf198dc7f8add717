"""The vision process: answers image requests, moves the camera, and switches night mode."""

from __future__ import annotations

import dataclasses
import sys
import time

from hub.control_gate import ControlGate
from hub.gcm import navigation, vision
from hub.gcm.capability import Abilities, Capability
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import Reply
from hub.modules.vision.coding import code
from hub.modules.vision.night import NightMode
from hub.modules.vision.picture import brightened, brightness, prepare
from hub.modules.vision.poses import PoseHistory
from hub.robots.cropping import vertical_fov
from hub.robots.description import ROBOTS_OWN, RobotDescription
from hub.robots.registry import camera_moves, open_camera
from hub.runtime import publish_on_request, run_module

_STEP_PERIOD = 0.02
_STATE_PERIOD = 1.0 / vision.CAMERA_STATE.rate_hz


class Vision:
    """Connects the camera to the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._clock = time.monotonic
        self._camera = open_camera(robot)
        self._night = NightMode()
        self._poses = PoseHistory()
        self._advanced = self._clock()
        self._gate = ControlGate(client)
        client.respond_later(vision.IMAGE_REQUEST, vision.IMAGE, self._answer)
        client.subscribe(vision.CAMERA_COMMAND, self._move)
        client.subscribe(vision.NIGHT_COMMAND, self._switch_night)
        client.subscribe(navigation.ROBOT_STATE, self._remember)
        if _simulated(robot):
            client.subscribe(navigation.GROUND_TRUTH, self._place)
        client.define(vision.CAMERA_STATE)
        publish_on_request(client, vision.CAMERA_STATE, self._publish_state)
        client.every(_STEP_PERIOD, self._advance)
        client.every(_STATE_PERIOD, self._publish_state)

    def finish(self) -> None:
        """Switch the headlight off and close the camera."""
        self._camera.set_headlight(0.0)
        self._camera.close()

    def _advance(self) -> None:
        now = self._clock()
        self._camera.advance(now - self._advanced)
        self._advanced = now

    def _answer(self, request: vision.ImageRequest, reply: Reply[vision.Image]) -> None:
        self._advance()
        now = self._clock()
        picture = self._camera.take(request.width_px, request.height_px, now)
        gain = self._night.see(brightness(picture.pixels), now)
        pixels = prepare(brightened(picture.pixels, gain), request.kind)
        data = code(pixels, request.coding, request.quality)
        state = dataclasses.replace(
            self._state(picture.measured),
            horizontal_fov=picture.horizontal_fov,
            vertical_fov=vertical_fov(picture.horizontal_fov),
        )
        image = vision.Image(
            camera=state,
            coding=request.coding,
            width_px=pixels.shape[1],
            height_px=pixels.shape[0],
            channels=1 if pixels.ndim == 2 else pixels.shape[2],
            data=data,
        )
        reply.answer(image, measured=picture.measured)

    def _state(self, measured: float) -> vision.CameraState:
        """The state of the camera, with the robot's pose at `measured` [s]."""
        place = self._poses.at(measured)
        stamp = time.time() - (self._clock() - measured)
        return dataclasses.replace(
            self._camera.camera_state(stamp),
            robot_x=place.x,
            robot_y=place.y,
            robot_theta=place.theta,
            gain=self._night.gain,
        )

    def _publish_state(self) -> None:
        self._advance()
        now = self._clock()
        self._client.publish(vision.CAMERA_STATE, self._state(now), measured=now)

    def _move(self, command: vision.CameraCommand, reception: MessageInfo) -> None:
        if self._gate.admits(vision.CAMERA_COMMAND, reception):
            self._advance()
            self._camera.move(command)

    def _switch_night(self, command: vision.NightCommand, reception: MessageInfo) -> None:
        if not self._gate.admits(vision.NIGHT_COMMAND, reception):
            return
        self._night.command(command)
        self._camera.set_headlight(self._night.headlight)
        self._publish_state()

    def _remember(self, state: navigation.RobotState, reception: MessageInfo) -> None:
        self._poses.add(state, reception.measured)

    def _place(self, truth: navigation.GroundTruth, reception: MessageInfo) -> None:
        self._camera.place(truth.x, truth.y, truth.theta, reception.measured)


def _simulated(robot: RobotDescription) -> bool:
    """Whether the camera is simulated, so that it needs the robot's pose."""
    return robot.simulated and robot.camera_source == ROBOTS_OWN


def abilities(robot: RobotDescription) -> Abilities:
    """The abilities of vision on a robot."""
    head = (Capability.VIS_PTZ,) if camera_moves(robot) else ()
    needs = (Capability.SIM_TRUTH,) if _simulated(robot) else ()
    return Abilities(provides=(Capability.VIS_VID, *head, Capability.VIS_NIGHT), needs=needs)


def main() -> int:
    """Run the process."""
    purpose = "Answers image requests, moves the pan/tilt/zoom camera, and sees in the dark."
    return run_module(
        "vision", purpose, abilities, lambda client, robot: Vision(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
