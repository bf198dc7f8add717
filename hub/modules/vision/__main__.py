"""The vision process: answers image requests, moves the camera, and switches night mode."""

from __future__ import annotations

import dataclasses
import math
import sys
import time
from collections.abc import Callable

from hub.control_gate import ControlGate
from hub.errors import HubError
from hub.gcm import navigation, vision
from hub.gcm.capability import Abilities, Capability
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import Reply
from hub.modules.vision.coding import code
from hub.modules.vision.night import NightMode
from hub.modules.vision.picture import brightened, brightness, prepare
from hub.modules.vision.pose_feed import PoseFeed, PoseSource
from hub.modules.vision.poses import PoseHistory
from hub.robots.body_tables import ROBOTS_OWN
from hub.robots.cropping import vertical_fov
from hub.robots.description import RobotDescription
from hub.robots.registry import camera_moves, open_camera
from hub.runtime import publish_on_request, run_module

_STATE_PERIOD = 1.0 / vision.CAMERA_STATE.rate_hz
_ASLEEP_PERIOD = 0.5
"""Time between two states of the camera while no client needs pictures [s]."""


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
        sources = [PoseSource(definition=navigation.ROBOT_STATE, handler=self._remember)]
        if _simulated(robot):
            sources.append(PoseSource(definition=navigation.GROUND_TRUTH, handler=self._place))
        self._feed = PoseFeed(client, sources)
        client.respond_later(vision.IMAGE_REQUEST, vision.IMAGE, self._requested)
        client.subscribe(vision.CAMERA_COMMAND, self._move)
        client.subscribe(vision.NIGHT_COMMAND, self._switch_night)
        client.define(vision.CAMERA_STATE)
        publish_on_request(client, vision.CAMERA_STATE, self._publish_state)
        self._feed_due = client.alarm(self._look)
        self._next_state = client.alarm(self._work)
        self._state_at = math.inf
        self._need()  # the first picture after the start must not wait

    def finish(self) -> None:
        """Switch the headlight off and close the camera."""
        self._camera.set_headlight(0.0)
        self._camera.close()

    def _advance(self) -> None:
        now = self._clock()
        self._camera.advance(now - self._advanced)
        self._advanced = now

    def _requested(self, request: vision.ImageRequest, reply: Reply[vision.Image]) -> None:
        self._need(lambda: self._answer_or_fail(request, reply))

    def _need(self, work: Callable[[], None] | None = None) -> None:
        """Note that a client needs pictures; do the work when the robot's pose is known."""
        now = self._clock()
        self._feed.need(now, work)
        self._feed_due.due = self._feed.due
        self._next_state.due = self._state_at = min(self._state_at, now + _STATE_PERIOD)

    def _look(self) -> None:
        try:
            self._feed.look(self._clock())
        finally:  # after work that raised, the rest is due at once
            self._feed_due.due = self._feed.due

    def _work(self) -> None:
        """Publish the camera's state, and look whether a client needs it."""
        period = _ASLEEP_PERIOD if self._feed.asleep else _STATE_PERIOD
        self._next_state.due = self._state_at = max(self._state_at + period, self._clock())
        if self._client.has_subscribers(vision.CAMERA_STATE):
            self._need()
        self._publish_state()
        self._look()

    def _answer_or_fail(self, request: vision.ImageRequest, reply: Reply[vision.Image]) -> None:
        try:
            self._answer(request, reply)
        except HubError as error:
            reply.fail(str(error))

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
    return robot.simulated and robot.camera.source == ROBOTS_OWN


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
