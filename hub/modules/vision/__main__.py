"""The vision process: answers image requests, moves the cameras, and switches night mode."""

from __future__ import annotations

import logging
import math
import sys
import time
from collections.abc import Callable

from hub.control_gate import ControlGate
from hub.errors import CameraError, HubError
from hub.gcm import flight, imu, navigation, vision
from hub.gcm.body import Freedom
from hub.gcm.camera_info import CAMERA_INFO, CameraInfos
from hub.gcm.capability import Abilities, Capability
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics
from hub.gcm.frames import in_base
from hub.gcm.pose_history import PoseHistory
from hub.gcm.shaper import SHAPER_STATE, ShaperState
from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder, too_late
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.responders import Reply
from hub.modules.vision.camera_service import CameraService
from hub.modules.vision.picture_rate import PictureRateLimit
from hub.modules.vision.pose_feed import PoseFeed, PoseSource
from hub.modules.vision.stances import Stances
from hub.modules.vision.travel import Travel
from hub.robots.body_tables import ROBOTS_OWN, CameraTable
from hub.robots.description import RobotDescription
from hub.robots.registry import camera_moves, open_camera
from hub.runtime import publish_on_request, run_module
from hub.sim.spatial_pose import SpatialPose

_logger = logging.getLogger(__name__)

_STATE_PERIOD = 1.0 / vision.CAMERA_STATE.rate_hz
_ASLEEP_PERIOD = 0.5
"""Time between two states of the camera while no client needs pictures [s]."""


class Vision:
    """Connects the cameras to the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._clock = time.monotonic
        self._poses = PoseHistory()
        free = (motion.freedom for motion in robot.body.motions)
        self._stances = Stances(stands=Freedom.HEAVE not in free)
        self._travel = Travel()
        tables = _tables(robot)
        self._cameras = {
            table.name: CameraService(
                in_base(robot.body.frames, table.name) or table.frame,
                open_camera(robot, table),
                self._poses,
                self._stances,
                (table.width_px, table.height_px),
                travel=None if _simulated(robot, table) else self._travel,
            )
            for table in tables
        }
        self._main = tables[0].name
        self._simulated = [
            self._cameras[table.name].camera for table in tables if _simulated(robot, table)
        ]
        self._gate = ControlGate(client)
        sources = [
            PoseSource(definition=navigation.ROBOT_STATE, handler=self._remember),
            PoseSource(definition=imu.IMU, handler=self._tilted, awaited=False),
            PoseSource(definition=flight.ALTITUDE, handler=self._rose, awaited=False),
        ]
        if self._simulated:
            sources.append(PoseSource(definition=navigation.GROUND_TRUTH, handler=self._place))
        self._feed = PoseFeed(client, sources)
        client.respond_later(vision.IMAGE_REQUEST, vision.IMAGE, self._requested)
        self._rate_limit = PictureRateLimit()
        self._had_problems = False
        client.subscribe(SHAPER_STATE, self._shaped)
        client.subscribe(vision.CAMERA_COMMAND, self._move)
        client.subscribe(vision.NIGHT_COMMAND, self._switch_night)
        self._lights = {each.name: each.camera for each in robot.body.lights if each.camera}
        client.subscribe(VEHICLE_COMMAND, self._light)
        client.define(vision.CAMERA_STATE, CAMERA_INFO)
        client.every(1.0 / CAMERA_INFO.rate_hz, self._publish_info)
        client.define(DIAGNOSTICS)
        client.every(1.0 / DIAGNOSTICS.rate_hz, self._publish_problems)
        publish_on_request(client, vision.CAMERA_STATE, self._publish_state)
        self._feed_due = client.alarm(self._look)
        self._next_state = client.alarm(self._work)
        self._state_at = math.inf
        self._need()  # the first picture after the start must not wait

    def finish(self) -> None:
        """Switch headlights off and close the cameras."""
        for each in self._cameras.values():
            each.close()

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
        camera = self._cameras.get(request.camera or self._main)
        if camera is None:
            known = ", ".join(self._cameras)
            text = f"there is no camera {request.camera!r}; the robot has {known}"
            raise CameraError(text)
        image, measured = camera.picture(request, self._rate_limit.at(self._clock()))
        reply.answer(image, measured=measured)

    def _shaped(self, state: ShaperState, _: MessageInfo) -> None:
        self._rate_limit.hear(state, self._clock())

    def _publish_state(self) -> None:
        now = self._clock()
        for each in self._cameras.values():
            each.advance()
        state = self._cameras[self._main].state(now)
        self._client.publish(vision.CAMERA_STATE, state, measured=now)

    def _publish_problems(self) -> None:
        found = [problem for each in self._cameras.values() for problem in each.problems()]
        if found or self._had_problems:
            self._client.publish(DIAGNOSTICS, Diagnostics(status=tuple(found)))
        self._had_problems = bool(found)

    def _publish_info(self) -> None:
        if self._client.has_subscribers(CAMERA_INFO):
            infos = tuple(each.info() for each in self._cameras.values())
            self._client.publish(CAMERA_INFO, CameraInfos(cameras=infos))

    def _move(self, command: vision.CameraCommand, reception: MessageInfo) -> None:
        if self._gate.admits(vision.CAMERA_COMMAND, reception):
            for each in self._chosen(command.camera or self._main):
                each.move(command)

    def _switch_night(self, command: vision.NightCommand, reception: MessageInfo) -> None:
        if not self._gate.admits(vision.NIGHT_COMMAND, reception):
            return
        for each in self._chosen(command.camera):
            each.switch_night(command)
        self._publish_state()

    def _light(self, command: VehicleCommand, reception: MessageInfo) -> None:
        """Set the light of a camera; all other orders are the driver's."""
        name = self._lights.get(command.name)
        if command.order is not VehicleOrder.LIGHT or name is None or math.isnan(command.value):
            return
        if late := too_late(command.order, reception.age):
            _logger.warning("%s", late)
        elif self._gate.admits(VEHICLE_COMMAND, reception):
            self._cameras[name].light(command.value)
            self._publish_state()

    def _chosen(self, name: str) -> list[CameraService]:
        """The camera of a name, all without a name, none for an unknown one."""
        if not name:
            return [*self._cameras.values()]
        if name not in self._cameras:
            _logger.warning("a command for camera %r is ignored: there is none", name)
            return []
        return [self._cameras[name]]

    def _remember(self, state: navigation.RobotState, reception: MessageInfo) -> None:
        self._poses.add(state, reception.measured)
        self._travel.moved(state, reception.measured)

    def _tilted(self, value: imu.Imu, reception: MessageInfo) -> None:
        self._stances.tilted(value, reception.measured)

    def _rose(self, altitude: flight.Altitude, reception: MessageInfo) -> None:
        self._stances.rose(altitude, reception.measured)

    def _place(self, truth: navigation.GroundTruth, reception: MessageInfo) -> None:
        pose = SpatialPose(
            x=truth.x,
            y=truth.y,
            z=truth.z,
            roll=truth.roll,
            pitch=truth.pitch,
            yaw=truth.theta,
        )
        for camera in self._simulated:
            camera.place(pose, reception.measured)


def _tables(robot: RobotDescription) -> tuple[CameraTable, ...]:
    """The cameras in the robot file; without any, one of the robot's own."""
    return robot.cameras or (robot.camera,)


def _simulated(robot: RobotDescription, table: CameraTable) -> bool:
    """Whether a camera is simulated, so that it needs the robot's pose."""
    return robot.simulated and table.source == ROBOTS_OWN


def abilities(robot: RobotDescription) -> Abilities:
    """The abilities of vision on a robot."""
    head = (Capability.VIS_PTZ,) if camera_moves(robot) else ()
    simulated = any(_simulated(robot, table) for table in _tables(robot))
    needs = (Capability.SIM_TRUTH,) if simulated else ()
    light = (Capability.DRV_LIGHT,) if any(each.camera for each in robot.body.lights) else ()
    provides = (Capability.VIS_VID, *head, Capability.VIS_NIGHT, *light)
    return Abilities(provides=provides, needs=needs)


def main() -> int:
    """Run the process."""
    purpose = "Answers image requests, moves the pan/tilt/zoom camera, and sees in the dark."
    return run_module(
        "vision", purpose, abilities, lambda client, robot: Vision(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
