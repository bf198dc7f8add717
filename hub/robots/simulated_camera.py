"""A simulated camera: any that a robot file describes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hub.gcm.body import BodyFrame, CameraBody
from hub.gcm.vision import CameraCommand, CameraMotion, CameraState
from hub.robots.cropping import cropped_fov, size_within, vertical_fov
from hub.robots.interfaces import Picture
from hub.sim.arena import Arena
from hub.sim.camera.heat import in_heat
from hub.sim.camera.image_noise import SensorNoise
from hub.sim.camera.lighting import Lighting
from hub.sim.camera.mount import mounted_view
from hub.sim.camera.pan_tilt_zoom import PanTiltZoom, horizontal_fov
from hub.sim.camera.ray_caster import RayCaster
from hub.sim.kinematics import limited
from hub.sim.spatial_pose import SpatialPose

SENSOR_WIDTH_PX = 320
SENSOR_HEIGHT_PX = 240
_SENSOR = (SENSOR_WIDTH_PX, SENSOR_HEIGHT_PX)
_PLACES_STOPPED = 0.1
"""Time without a new pose after which the robot counts as standing [s]."""

WAVE_S = 0.8
"""Time for which a victim that moves keeps its arm up, and then down [s]."""
_FARTHEST_PLACE = 1000.0
"""Largest coordinate [m]: beyond every arena, and within the ray caster's single precision."""


class SimulatedCamera:
    """A camera on a pan/tilt/zoom head in an arena; implements `Camera`.

    The same seed and the same calls give the same pictures to the last bit.
    """

    def __init__(
        self,
        arena: Arena,
        *,
        body: CameraBody,
        mount: BodyFrame,
        light: float | None = None,
        headlight: bool = True,
        heat: bool = False,
        seed: int = 0,
    ) -> None:
        """Stand at the start of the arena.

        Args:
            arena: Its arena.
            body: What the camera can do; its pictures have 320 by 240 pixels at most.
            mount: Where it is on its robot.
            light: Brightness of the arena, 0 (dark) to 1; None: the arena file's.
            headlight: Whether there is one beside the camera.
            heat: Whether it sees temperatures in place of colours; light does not matter then.
            seed: Of the noise in the dark.
        """
        if heat:
            arena, light = in_heat(arena), None
        # Victims that move have an arm down, then up.
        poses = [arena, *([replace(arena, boxes=arena.waving)] if arena.waving else [])]
        self._casters = [RayCaster(each) for each in poses]
        self._time = 0.0
        self._body = body
        self._mount = mount
        self._tele = 2.0 * math.atan(math.tan(body.horizontal_fov / 2) / body.zoom)
        self._head = PanTiltZoom(
            body.pan_limit, body.tilt_lowest, body.tilt_highest, zooms=body.zoom > 1.0
        )
        self._robot = SpatialPose().at(arena.start)
        self._placed = -math.inf
        self._has_headlight = headlight
        self._lighting = Lighting(ambient=arena.light if light is None else light)
        self._noise = SensorNoise(SENSOR_WIDTH_PX * SENSOR_HEIGHT_PX * 3, seed)

    def advance(self, seconds: float) -> None:
        """Move the head and the victims for some time [s]."""
        self._head.advance(seconds)
        self._time += seconds

    def move(self, command: CameraCommand) -> None:
        """Set the head's target; NaN leaves an amount unchanged, and limits apply."""
        if command.motion is CameraMotion.HOME:
            self._head.go_to(0.0, 0.0, 0.0)
        elif command.motion is CameraMotion.ABSOLUTE:
            self._head.go_to(command.pan, command.tilt, command.zoom)
        else:
            self._head.go_by(command.pan, command.tilt, command.zoom)

    def set_headlight(self, brightness: float) -> None:
        """Set the headlight, 0 (off) to 1; NaN counts as 0."""
        if self._has_headlight:
            lit = max(0.0, limited(brightness, 1.0))
            self._lighting = Lighting(ambient=self._lighting.ambient, headlight=lit)

    def camera_state(self, stamp: float) -> CameraState:
        """The camera's present direction."""
        return CameraState(
            stamp=stamp,
            pan=self._head.pan,
            tilt=self._head.tilt,
            zoom=self._head.zoom,
            horizontal_fov=self._fov(),
            vertical_fov=vertical_fov(self._fov()),
            mount_forward=self._mount.x,
            mount_height=self._mount.z,
            pan_limit=self._body.pan_limit,
            tilt_limit=max(-self._body.tilt_lowest, self._body.tilt_highest),
            slewing=int(self._head.slewing),
            headlight=self._lighting.headlight if self._has_headlight else math.nan,
        )

    def place(self, pose: SpatialPose, measured: float = -math.inf) -> None:
        """Set the robot's pose in the arena's frame; ignored when not finite."""
        if pose.finite:
            x, y = limited(pose.x, _FARTHEST_PLACE), limited(pose.y, _FARTHEST_PLACE)
            self._robot = replace(pose, x=x, y=y)
            self._placed = measured

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        """A picture from the robot's last pose, with its time."""
        age = now - self._placed
        pixels = self.capture(width_px, height_px)
        size = pixels.shape[1], pixels.shape[0]
        return Picture(
            pixels=pixels,
            # Without a new pose for long, nothing moves.
            measured=self._placed if 0.0 <= age < _PLACES_STOPPED else now,
            horizontal_fov=cropped_fov(self._fov(), size, _SENSOR),
        )

    def capture(self, width_px: int, height_px: int) -> npt.NDArray[np.uint8]:
        """A picture, shape (height, width, 3), at least 1 by 1 and at most 320 by 240 pixels."""
        width, height = size_within(width_px, height_px, _SENSOR)
        view = mounted_view(
            self._robot,
            self._mount,
            pan=self._head.pan,
            tilt=self._head.tilt,
            horizontal_fov=cropped_fov(self._fov(), (width, height), _SENSOR),
        )
        caster = self._casters[int(self._time / WAVE_S) % len(self._casters)]
        pixels = caster.picture(view, width, height, self._lighting)
        # In full light noise would only cost time and bandwidth.
        return pixels if self._lighting.ambient == 1.0 else self._noise.added(pixels)

    def _fov(self) -> float:
        """Field of view of the whole sensor now [rad]."""
        return horizontal_fov(self._head.zoom, self._body.horizontal_fov, self._tele)

    def close(self) -> None:
        """Do nothing: nothing is open."""
