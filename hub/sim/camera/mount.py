"""The view of a camera, from the pose of its robot and its place on it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hub.gcm.body import BodyFrame
from hub.gcm.orientation import rotation
from hub.sim.camera.view import View
from hub.sim.spatial_pose import SpatialPose


def mounted_view(
    robot: SpatialPose, mount: BodyFrame, *, pan: float, tilt: float, horizontal_fov: float
) -> View:
    """The view of a camera on a robot.

    Args:
        robot: Its pose in the arena's frame.
        mount: The camera's frame in `base_link`; its head looks along x at no pan and tilt.
        pan: Of its head [rad], positive left.
        tilt: Of its head [rad], positive up.
        horizontal_fov: Field of view from left to right [rad].
    """
    if (robot.roll, robot.pitch, mount.roll, mount.pitch) == (0.0, 0.0, 0.0, 0.0):
        cos, sin = math.cos(robot.yaw), math.sin(robot.yaw)
        return View(
            x=robot.x + mount.x * cos - mount.y * sin,
            y=robot.y + mount.x * sin + mount.y * cos,
            z=robot.z + mount.z,
            yaw=robot.yaw + pan + mount.yaw,
            pitch=tilt,
            horizontal_fov=horizontal_fov,
        )
    turn = robot.rotation()
    # Tilt is positive up, and pitch is positive down.
    head = turn @ rotation(mount.roll, mount.pitch, mount.yaw) @ rotation(0.0, -tilt, pan)
    x, y, z = turn @ np.array((mount.x, mount.y, mount.z))
    ahead, up = head[:, 0], head[:, 2]
    level = View(
        x=robot.x + float(x),
        y=robot.y + float(y),
        z=robot.z + float(z),
        yaw=math.atan2(ahead[1], ahead[0]),
        pitch=math.atan2(ahead[2], math.hypot(ahead[0], ahead[1])),
        horizontal_fov=horizontal_fov,
    )
    level_right, level_up, _ = level.basis()
    roll = math.atan2(float(up @ level_right), float(up @ level_up))
    return replace(level, roll=roll)
