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


def mounted_view(
    stand: Stand,
    *,
    forward: float,
    height: float,
    pan: float,
    tilt: float,
    horizontal_fov: float,
) -> View:
    """The view of a camera on a robot.

    Args:
        stand: The robot.
        forward: Of the camera, ahead of the robot's origin [m].
        height: Of the camera, above the robot's origin [m].
        pan: Of its head [rad], positive left.
        tilt: Of its head [rad], positive up.
        horizontal_fov: Field of view from left to right [rad].
    """
    if stand.roll == 0.0 and stand.pitch == 0.0:
        return View(
            x=stand.x + forward * math.cos(stand.theta),
            y=stand.y + forward * math.sin(stand.theta),
            z=stand.z + height,
            yaw=stand.theta + pan,
            pitch=tilt,
            horizontal_fov=horizontal_fov,
        )
    turn = _rotation(stand.theta, stand.pitch, stand.roll)
    # Tilt is positive up, and pitch is positive down.
    head = turn @ _rotation(pan, -tilt, 0.0)
    x, y, z = turn @ np.array((forward, 0.0, height))
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
