"""A simulated iRobot Magellan Pro with a Sony EVI-D30 camera on top."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.body import RangeGroup, RangeKind
from hub.gcm.navigation import DriveState, GroundTruth
from hub.gcm.ranges import LaserScan, scan_of
from hub.gcm.vision import CameraCommand, CameraMotion, CameraState
from hub.robots.cropping import cropped_fov, size_within, vertical_fov
from hub.robots.interfaces import Picture
from hub.sim.arena import Arena
from hub.sim.battery import Battery
from hub.sim.contact import ContactBody
from hub.sim.image_noise import SensorNoise
from hub.sim.kinematics import ANGULAR, LINEAR, approach, limited, moved
from hub.sim.lighting import Lighting
from hub.sim.odometry import Odometry
from hub.sim.pan_tilt_zoom import (
    PAN_LIMIT,
    TILT_LIMIT,
    PanTiltZoom,
    horizontal_fov,
)
from hub.sim.range_sensors import RangeSensors
from hub.sim.ray_caster import RayCaster
from hub.sim.view import View

STEP = 0.01
"""Length of a step of the simulation [s]."""
STEPS_PER_SCAN = 10
"""All range sensors measure together at 10 Hz; the real ring of sonars takes half a second."""
LONGEST_ADVANCE = 5.0
"""Longest advance of one call [s]; more is dropped, for example after a suspended process."""
MOUNT_FORWARD = 0.05
"""Camera ahead of the robot's centre [m]."""
MOUNT_HEIGHT = 0.37
"""Camera above the ground [m]."""
SENSOR_WIDTH_PX = 320
SENSOR_HEIGHT_PX = 240
_SENSOR = (SENSOR_WIDTH_PX, SENSOR_HEIGHT_PX)
_PLACES_STOPPED = 0.1
"""Time without a new pose after which the robot counts as standing [s]."""

_ROUNDING = 1e-9
_FARTHEST_PLACE = 1000.0
"""Largest coordinate [m]: beyond every arena, and within the ray caster's single precision."""


class SimulatedMagellan:
    """Wheels, range sensors, bumpers and battery in an arena; implements `DriveBase`.

    The same seed and the same calls give the same values to the last bit. Reading a state changes
    nothing. Sensors scan at 10 Hz of simulated time; between two scans they report the last ranges.
    """

    def __init__(
        self,
        arena: Arena,
        *,
        seed: int = 0,
        linear_limit: float = 0.5,
        angular_limit: float = 1.0,
        groups: Sequence[RangeGroup] = (),
    ) -> None:
        odometry_seed, sensor_seed = np.random.SeedSequence(seed).spawn(2)
        self._linear_limit = linear_limit
        self._angular_limit = angular_limit
        self._body = ContactBody(arena.footprints)
        self._odometry = Odometry(odometry_seed)
        self._sensors = RangeSensors(arena.footprints, sensor_seed)
        self._battery = Battery()
        self._commanded = (0.0, 0.0)
        self._linear = 0.0
        self._angular = 0.0
        self._steps = 0
        self._time_left = 0.0
        self._groups = {group.kind: group for group in groups}
        self._is_new = True
        # Compute the contacts of the body at the start.
        start = moved(arena.start, 0.0, 0.0)  # its heading is in (-pi, pi]
        self._pose = self._body.move(start, start)
        # Its world restarts with it, and it always starts at the same place of its arena.
        self._origin = zlib.crc32(repr((arena.name, arena.start)).encode()) | 1
        self._scan()

    def set_velocity(self, linear: float, angular: float) -> None:
        """Set the velocity: forward [m/s], counter-clockwise [rad/s]; NaN counts as 0."""
        self._commanded = (
            limited(linear, self._linear_limit),
            limited(angular, self._angular_limit),
        )

    def advance(self, seconds: float) -> None:
        """Advance the simulated time in whole steps; the rest counts in the next call."""
        if not seconds > 0.0:
            return
        self._time_left += min(seconds, LONGEST_ADVANCE)
        while self._time_left >= STEP - _ROUNDING:
            self._time_left -= STEP
            self._step()

    def drive_state(self, stamp: float) -> DriveState:
        """The present measurements of encoders, range sensors, bumpers and battery."""
        pose = self._odometry.pose
        return DriveState(
            stamp=stamp,
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            linear=self._linear,
            angular=self._angular,
            commanded_linear=self._commanded[0],
            commanded_angular=self._commanded[1],
            sonar=self._sonar.copy(),
            infrared=self._infrared.copy(),
            bumpers=self._body.bumpers(self._pose),
            battery_voltage=self._battery.voltage,
            battery_fraction=self._battery.fraction,
            origin=self._origin,
        )

    def ranges(self, stamp: float) -> tuple[LaserScan, ...] | None:
        """The newest ranges of its sonars and infrared sensors; None: nothing is new."""
        if not self._is_new:
            return None
        self._is_new = False
        measured = {RangeKind.SONAR: self._sonar, RangeKind.INFRARED: self._infrared}
        return tuple(scan_of(group, measured[kind], stamp) for kind, group in self._groups.items())

    def ground_truth(self) -> GroundTruth:
        """Its true pose in the arena's frame."""
        return GroundTruth(
            time=self._steps * STEP,
            x=self._pose.x,
            y=self._pose.y,
            theta=self._pose.theta,
            linear=self._linear,
            angular=self._angular,
            commanded_linear=self._commanded[0],
            commanded_angular=self._commanded[1],
            contacts=self._body.contacts,
            touching=int(bool(self._body.touched)),
        )

    def _step(self) -> None:
        linear = approach(self._linear, self._commanded[0], LINEAR, STEP)
        angular = approach(self._angular, self._commanded[1], ANGULAR, STEP)
        if linear or angular:
            linear = self._move(linear, angular)
        self._linear, self._angular = linear, angular
        self._battery = self._battery.after(STEP, linear, angular)
        self._steps += 1
        if self._steps % STEPS_PER_SCAN == 0:
            self._scan()

    def _move(self, linear: float, angular: float) -> float:
        """Move for a step at these velocities; returns the forward velocity that contact allows."""
        before = self._pose
        wanted = moved(before, linear * STEP, angular * STEP)
        self._pose = self._body.move(before, wanted)
        if self._body.touched:
            linear = self._held_back(linear, before.x, before.y, before.theta + angular * STEP / 2)
        self._odometry.moved(linear * STEP, angular * STEP, STEP)
        return linear

    def _held_back(self, linear: float, x: float, y: float, heading: float) -> float:
        """Forward velocity against an obstacle: wheels grip the floor, motors stall."""
        forward = (self._pose.x - x) * math.cos(heading) + (self._pose.y - y) * math.sin(heading)
        return max(min(forward / STEP, max(linear, 0.0)), min(linear, 0.0))

    def _scan(self) -> None:
        self._sonar = self._sensors.sonar(self._pose)
        self._infrared = self._sensors.infrared(self._pose)
        self._is_new = True


class SimulatedCamera:
    """A camera on a pan/tilt/zoom head in an arena; implements `Camera`.

    The same seed and the same calls give the same pictures to the last bit.
    """

    def __init__(
        self,
        arena: Arena,
        *,
        light: float | None = None,
        headlight: bool = True,
        seed: int = 0,
    ) -> None:
        """Stand at the start of the arena.

        Args:
            arena: Its arena.
            light: Brightness of the arena, 0 (dark) to 1; None: the arena file's.
            headlight: Whether there is one beside the camera.
            seed: Of the noise in the dark.
        """
        self._caster = RayCaster(arena)
        self._head = PanTiltZoom()
        self._robot = (arena.start.x, arena.start.y, arena.start.theta)
        self._placed = -math.inf
        self._has_headlight = headlight
        self._lighting = Lighting(ambient=arena.light if light is None else light)
        self._noise = SensorNoise(SENSOR_WIDTH_PX * SENSOR_HEIGHT_PX * 3, seed)

    def advance(self, seconds: float) -> None:
        """Move the head for some time [s]."""
        self._head.advance(seconds)

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
            horizontal_fov=horizontal_fov(self._head.zoom),
            vertical_fov=vertical_fov(horizontal_fov(self._head.zoom)),
            mount_forward=MOUNT_FORWARD,
            mount_height=MOUNT_HEIGHT,
            pan_limit=PAN_LIMIT,
            tilt_limit=TILT_LIMIT,
            slewing=int(self._head.slewing),
            headlight=self._lighting.headlight if self._has_headlight else math.nan,
        )

    def place(self, x: float, y: float, theta: float, measured: float = -math.inf) -> None:
        """Set the robot's pose in the arena's frame [m, m, rad]; ignored when not finite."""
        if math.isfinite(x) and math.isfinite(y) and math.isfinite(theta):
            self._robot = (limited(x, _FARTHEST_PLACE), limited(y, _FARTHEST_PLACE), theta)
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
            horizontal_fov=cropped_fov(horizontal_fov(self._head.zoom), size, _SENSOR),
        )

    def capture(self, width_px: int, height_px: int) -> npt.NDArray[np.uint8]:
        """A picture, shape (height, width, 3), at least 1 by 1 and at most 320 by 240 pixels."""
        x, y, theta = self._robot
        width, height = size_within(width_px, height_px, _SENSOR)
        view = View(
            x=x + MOUNT_FORWARD * math.cos(theta),
            y=y + MOUNT_FORWARD * math.sin(theta),
            z=MOUNT_HEIGHT,
            yaw=theta + self._head.pan,
            pitch=self._head.tilt,
            horizontal_fov=cropped_fov(horizontal_fov(self._head.zoom), (width, height), _SENSOR),
        )
        pixels = self._caster.picture(view, width, height, self._lighting)
        # In full light noise would only cost time and bandwidth.
        return pixels if self._lighting.ambient == 1.0 else self._noise.added(pixels)

    def close(self) -> None:
        """Do nothing: nothing is open."""
