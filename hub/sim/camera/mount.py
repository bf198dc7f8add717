"""From how a robot stands, and where its camera sits on it, to the camera's view."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hub.gcm.orientation import rotation
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
    turn = rotation(stand.roll, stand.pitch, stand.theta)
    # Tilt is positive up, and pitch is positive down.
    head = turn @ rotation(mount.roll, mount.pitch, mount.yaw) @ rotation(0.0, -tilt, pan)
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
