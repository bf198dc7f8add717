"""From how a robot stands, and where its camera sits on it, to the camera's view."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hub.sim.camera.view import View
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Stand:
    """Where a robot is in the arena's frame, and how it stands.

    Each rotation turns the axes of the next one: theta first, then pitch, then roll.

    Attributes:
        x: Position [m].
        y: Position [m].
        theta: Its heading [rad], counter-clockwise from x.
        z: Height of the robot's origin above the floor [m].
        roll: About its x [rad]; positive: its right side is down.
        pitch: About its y [rad]; positive: its nose is down.
    """

    x: float
    y: float
    theta: float
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0

    @property
    def finite(self) -> bool:
        """Whether all its numbers are."""
        numbers = (self.x, self.y, self.theta, self.z, self.roll, self.pitch)
        return all(math.isfinite(number) for number in numbers)


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """Where a camera sits on its robot, and where its head looks at no pan and tilt.

    Attributes:
        forward: Ahead of the robot's origin [m].
        left: Left of it [m].
        height: Above it [m].
        roll: As the robot's [rad].
        pitch: As the robot's [rad].
        yaw: To the left [rad].
    """

    forward: float = 0.0
    left: float = 0.0
    height: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


def mounted_view(
    stand: Stand, mount: Mount, *, pan: float, tilt: float, horizontal_fov: float
) -> View:
    """The view of a camera on a robot.

    Args:
        stand: The robot.
        mount: Of the camera.
        pan: Of its head [rad], positive left.
        tilt: Of its head [rad], positive up.
        horizontal_fov: Field of view from left to right [rad].
    """
    if (stand.roll, stand.pitch, mount.roll, mount.pitch) == (0.0, 0.0, 0.0, 0.0):
        cos, sin = math.cos(stand.theta), math.sin(stand.theta)
        return View(
            x=stand.x + mount.forward * cos - mount.left * sin,
            y=stand.y + mount.forward * sin + mount.left * cos,
            z=stand.z + mount.height,
            yaw=stand.theta + pan + mount.yaw,
            pitch=tilt,
            horizontal_fov=horizontal_fov,
        )
    turn = _rotation(stand.theta, stand.pitch, stand.roll)
    # Tilt is positive up, and pitch is positive down.
    head = turn @ _rotation(mount.yaw, mount.pitch, mount.roll) @ _rotation(pan, -tilt, 0.0)
    x, y, z = turn @ np.array((mount.forward, mount.left, mount.height))
    ahead, up = head[:, 0], head[:, 2]
    level = View(
        x=stand.x + float(x),
        y=stand.y + float(y),
        z=stand.z + float(z),
        yaw=math.atan2(ahead[1], ahead[0]),
        pitch=math.atan2(ahead[2], math.hypot(ahead[0], ahead[1])),
        horizontal_fov=horizontal_fov,
    )
    level_right, level_up, _ = level.basis()
    roll = math.atan2(float(up @ level_right), float(up @ level_up))
    return replace(level, roll=roll)


def _rotation(yaw: float, pitch: float, roll: float) -> npt.NDArray[np.float64]:
    """Matrix whose columns are the turned axes: forward, left, up; pitch is positive nose down."""
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    cos_pitch, sin_pitch = math.cos(pitch), math.sin(pitch)
    cos_roll, sin_roll = math.cos(roll), math.sin(roll)
    about_z = ((cos_yaw, -sin_yaw, 0.0), (sin_yaw, cos_yaw, 0.0), (0.0, 0.0, 1.0))
    about_y = ((cos_pitch, 0.0, sin_pitch), (0.0, 1.0, 0.0), (-sin_pitch, 0.0, cos_pitch))
    about_x = ((1.0, 0.0, 0.0), (0.0, cos_roll, -sin_roll), (0.0, sin_roll, cos_roll))
    turned: npt.NDArray[np.float64] = np.array(about_z) @ np.array(about_y) @ np.array(about_x)
    return turned
