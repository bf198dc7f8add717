"""The interfaces of a robot's hardware for the modules; each robot implements them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from hub.gcm.autopilot import AutopilotState, AutopilotText, MavlinkFrames
from hub.gcm.battery import BatteryState
from hub.gcm.body import HoldKind
from hub.gcm.diagnostics import DiagnosticStatus
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.imu import Acceleration, Imu
from hub.gcm.joints import JointState
from hub.gcm.navigation import GroundTruth
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.own_navigation import DriveGoal, OwnNavigation
from hub.gcm.ranges import LaserScan
from hub.gcm.vehicle import VehicleState
from hub.gcm.vision import CameraCommand, CameraState
from hub.robots.left_alone import LeftAlone
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sensors:
    """The newest measurement of each part of a body; a part that it lacks keeps its default.

    Attributes:
        known: Whether the body answers; else no state of the base is published.
        measured: When its base was measured [s, monotonic]; a time that was published already
            means that nothing is new. NaN: now.
        x: Dead-reckoned position in `odom` [m].
        y: Dead-reckoned position in `odom` [m].
        z: Dead-reckoned height in `odom` [m]; of a robot under water, below 0 by its depth.
        theta: Dead-reckoned heading in `odom` [rad], in (-pi, pi].
        velocity: Measured velocity in `base_link`.
        commanded: The velocity that it follows now, within its limits.
        scans: The newest scan of each group of range sensors, in the order of the description.
        scanned: When the newest of them was measured [s, monotonic]; NaN: now.
        bumpers: Bit i is set while bumper i of the description is pressed.
        battery_voltage: [V]; NaN: not measured.
        battery_fraction: Charge left, 0 to 1; NaN: not known.
        battery: All that a battery says, in place of these two; None: only they are known.
        imu: All that an IMU says, in `base_link`, in place of `roll`, `pitch`, `heading`,
            `turning` and `acceleration` in its message; None: only they are known.
        roll: About x [rad], positive right side down; NaN: not measured.
        pitch: About y [rad], positive nose down; NaN: not measured.
        heading: Of a compass, counter-clockwise from x of `map` [rad]; NaN: not measured.
        height: Above the origin of `map` [m]; NaN: not measured.
        above_ground: Above the ground or the sea floor [m]; NaN: not measured.
        depth: Below the water's surface [m]; NaN: not measured.
        turning: Turn rates about x, y and z of `base_link`, by a gyro; None: not measured.
        acceleration: By an accelerometer, with gravity; None: not measured.
        pressure: Of the air or the water around it [Pa]; NaN: not measured.
        climb: Vertical velocity [m/s], positive up; NaN: not measured.
        sound: Sound level [dB]; NaN: not measured.
        co2: Carbon dioxide of the air [ppm]; NaN: not measured.
        reckoning: Number of this dead reckoning; it changes with each restart. 0: the driver
            process gives it one.
        origin: Number of the origin of `odom`; equal numbers mean equal places, even after a
            restart of the dead reckoning. 0: the robot's place at the restart.
        diagnostics: What is wrong with the body now; none: nothing.
        vehicle: Holds, arming, lights, tether, and what it does; the driver adds the time, and
            "drives" or "stands" where `activity` is empty.
        joints: Its joints, in the order of the description.
        slow: Whether it measures at most 20 times per second, also while it moves.
    """

    known: bool = True
    measured: float = math.nan
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    theta: float = 0.0
    velocity: Twist = Twist()
    commanded: Twist = Twist()
    scans: tuple[LaserScan, ...] = ()
    scanned: float = math.nan
    bumpers: int = 0
    battery_voltage: float = math.nan
    battery_fraction: float = math.nan
    battery: BatteryState | None = None
    imu: Imu | None = None
    roll: float = math.nan
    pitch: float = math.nan
    heading: float = math.nan
    height: float = math.nan
    above_ground: float = math.nan
    depth: float = math.nan
    turning: Vector3 | None = None
    acceleration: Acceleration | None = None
    pressure: float = math.nan
    climb: float = math.nan
    sound: float = math.nan
    co2: float = math.nan
    reckoning: int = 0
    origin: int = 0
    diagnostics: tuple[DiagnosticStatus, ...] = ()
    vehicle: VehicleState = VehicleState()
    joints: tuple[JointState, ...] = ()
    slow: bool = False


class Body(Protocol):
    """The hardware that moves and measures; owned by the driver module."""

    def command(self, twist: Twist) -> None:
        """Set the velocity in `base_link` [m/s, rad/s]; limits apply.

        A body leaves out the degrees of freedom that it does not have.
        """

    def advance(self, seconds: float) -> None:
        """Advance a simulation; real hardware reads its port, without waiting."""

    def sensors(self, stamp: float) -> Sensors:
        """The present measurements; `stamp` is the time now [s since the epoch]."""

    def ground_truth(self) -> GroundTruth | None:
        """Its true pose; None: unknown."""


@runtime_checkable
class BodyLeftAlone(Protocol):
    """A `Body` with more actions than standing when it has no operator."""

    def left_alone(self, action: LeftAlone | None) -> None:
        """Do this from now on; None: it has an operator again.

        The driver calls this at each change; it goes on setting velocities.
        """


@runtime_checkable
class BodyHolds(Protocol):
    """A `Body` that keeps height, depth, heading or position by itself, see `[[hold]]`."""

    def hold(self, kind: HoldKind, target: float) -> None:
        """Switch a hold on: go to the target [m or rad] and keep it; NaN: where it is now.

        A heading is that of `Sensors.theta`. While the freedom is commanded, the hold waits; then
        it keeps the new place.
        """

    def release(self, kind: HoldKind) -> None:
        """Switch a hold off: without a command the body brakes, then drifts."""


@runtime_checkable
class BodyLights(Protocol):
    """A `Body` with lights of its own, see `[[light]]`."""

    def set_light(self, name: str, brightness: float) -> None:
        """Set the brightness of a light, 0 (off) to 1."""


@runtime_checkable
class BodyJoints(Protocol):
    """A `Body` with joints, see `[[joint]]`."""

    def turn_joint(self, name: str, rate: float) -> None:
        """Turn a joint at a rate [rad/s] within its limits; 0 stops it.

        The driver sends 0 when orders end.
        """


@runtime_checkable
class BodyArms(Protocol):
    """A `Body` whose motors can be switched off, see `[body] arming`."""

    def arm(self, *, armed: bool) -> None:
        """Give the motors power, or switch them off; then commands and holds move nothing."""


@runtime_checkable
class BodyModes(Protocol):
    """A `Body` whose motors belong to an autopilot, which has modes and arms by itself.

    A new driver process does not arm or disarm it.
    """

    def drive(self) -> None:
        """Ask for the mode that follows velocities; they begin with a neutral one."""

    def stay(self) -> None:
        """Ask for the mode in which it stays; it follows no velocity then, in any mode."""

    def set_mode(self, name: str) -> None:
        """Ask for a mode by its name in `AutopilotState.modes`; another name changes nothing."""

    def autopilot(self, stamp: float) -> AutopilotState:
        """Its present state; `stamp` is the time now [s since the epoch]."""

    def pass_on(self, frames: bytes) -> None:
        """Send frames of another ground station, unless they drive or keep alive."""

    def take_texts(self) -> tuple[AutopilotText, ...]:
        """The texts that came since the last call."""

    def take_frames(self, *, wanted: bool) -> tuple[MavlinkFrames, ...]:
        """The bytes of its link since the last call; `wanted`: keep those from now on."""


@runtime_checkable
class BodyNavigates(Protocol):
    """A `Body` with navigation of its own, which drives to places."""

    def go(self, goal: DriveGoal) -> None:
        """Drive there until the next `command`; a number that is known changes nothing.

        A `command` ends it: the body cancels the goal before it follows the velocity.
        """

    def own_navigation(self) -> OwnNavigation:
        """The state of that navigation."""


@runtime_checkable
class BodyStops(Protocol):
    """A `Body` with a stop of its own besides zero velocity."""

    def stop(self) -> None:
        """Ask for it; the driver calls this at each `GCM_Stop`."""


class FileLoop(Protocol):
    """A loop that waits for file descriptors."""

    def watch(self, file: int, work: Callable[[], None]) -> None:
        """Call `work` whenever the file descriptor is readable."""

    def unwatch(self, file: int) -> None:
        """Stop watching it; call this before it is closed."""


@runtime_checkable
class BodyWakes(Protocol):
    """A `Body` that reads its port between two calls of `advance` too.

    The driver calls `advance` at 20 Hz, and as often as such a body asks for it.
    """

    def wake_by(self, loop: FileLoop, report: Callable[[], bool]) -> None:
        """Watch the port by this loop.

        Args:
            loop: The loop of the driver.
            report: Asks the driver to call `advance` and to publish soon; whether it will.
        """


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """One picture of a camera.

    Attributes:
        pixels: Red, green, blue, shape (height, width, 3).
        measured: Time of the picture, on the monotonic clock [s].
        horizontal_fov: Field of view from left to right of this picture [rad].
    """

    pixels: npt.NDArray[np.uint8]
    measured: float
    horizontal_fov: float


class Camera(Protocol):
    """A camera, perhaps on a pan/tilt/zoom head; owned by the vision module."""

    def advance(self, seconds: float) -> None:
        """Advance a simulation; real hardware does nothing here."""

    def move(self, command: CameraCommand) -> None:
        """Start to move within the limits; a camera without a head does nothing."""

    def set_headlight(self, brightness: float) -> None:
        """Set the headlight, 0 (off) to 1; without one, do nothing."""

    def camera_state(self, stamp: float) -> CameraState:
        """Its present direction; `stamp` [s since the epoch] is copied into it."""

    def place(self, pose: SpatialPose, measured: float) -> None:
        """Set the robot's pose and its time; only a simulated camera uses it.

        Args:
            pose: In the arena's frame.
            measured: Monotonic time of the pose [s].
        """

    def take(self, width_px: int, height_px: int, now: float) -> Picture:
        """A picture of this size, at most as large as the camera's own.

        Pixels are square. A picture of another shape than the camera's shows the middle.

        Args:
            width_px: Requested width.
            height_px: Requested height.
            now: Monotonic time [s].

        Raises:
            CameraError: There is none; the text gives the reason and the remedy.
        """

    def close(self) -> None:
        """Release the camera."""


class OwnMap(Protocol):
    """A map that the robot makes itself; owned by the mapping module, which maps until it comes."""

    @property
    def fault(self) -> str:
        """Why there is no map, or no newer one, in a sentence; empty: all is well."""

    def advance(self, now: float) -> None:
        """Read its port, without waiting; `now` is monotonic [s]."""

    def take(self) -> OccupancyMap | None:
        """The map, in the frame of the body's places; None: it is as at the last call."""

    def close(self) -> None:
        """Release it."""
