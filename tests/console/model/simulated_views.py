"""Pictures of the simulated camera in a hall that is empty but for a thing or two."""

from __future__ import annotations

import dataclasses
import functools
import math

import pytest

from hub.gcm.vision import CameraCommand, CameraMotion
from hub.robots.simulated_camera import SimulatedCamera
from hub.sim.spatial_pose import SpatialPose
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import Picture
from tests.hub.sim.arenas import VOID, arena_of
from tests.support.magellan import magellan_camera

POST = (3.0, 4.0)
POST_RADIUS = 0.06
FEET_LOW, FEET_HIGH = (-2.17, -3.88), (-1.83, -3.38)
"""The legs of the sitting victim, whose middle is at (-2, -4), which looks north."""

LANDMARK = "[[cylinder]]\nat=[3.0, 4.0]\nradius=0.06\nheight=0.5\n"
VICTIM = '[[victim]]\nname="a"\nat=[-2.0, -4.0]\nfacing="north"\npose="sitting"\ncolour="red"\n'


@functools.cache
def camera(things: str) -> SimulatedCamera:
    return magellan_camera(arena_of(VOID + things), seed=0)


def take(
    things: str,
    robot: Pose,
    aim: tuple[float, float, float],
    size: tuple[int, int],
    stance: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Picture:
    """A picture and where it was taken, as the vision module would send them.

    Args:
        things: What stands in the hall.
        robot: Where the robot is.
        aim: Pan, tilt and zoom.
        size: Of the picture [pixels].
        stance: Its height [m], roll and pitch [rad].
    """
    taker = camera(things)
    pan, tilt, zoom = aim
    taker.move(CameraCommand(motion=CameraMotion.ABSOLUTE, pan=pan, tilt=tilt, zoom=zoom))
    taker.advance(60.0)
    above, roll, pitch = stance
    taker.place(SpatialPose(z=above, roll=roll, pitch=pitch).at(robot))
    picture = taker.take(*size, 0.0)
    state = dataclasses.replace(taker.camera_state(0.0), horizontal_fov=picture.horizontal_fov)
    assert (state.pan, state.tilt) == pytest.approx((pan, tilt)), "beyond the head's limits"
    state = dataclasses.replace(
        state,
        robot_x=robot.x,
        robot_y=robot.y,
        robot_theta=robot.theta,
        robot_roll=roll,
        robot_pitch=pitch,
        robot_above_ground=above,
    )
    return Picture(pixels=picture.pixels, camera=state)


def aimed(robot: Pose, at: tuple[float, float], aside: float, up: float) -> tuple[float, float]:
    """Pan and tilt that look at a place on the ground, and by so much beside it [rad]."""
    ahead, left = robot.from_map(at).tolist()
    ahead -= 0.05
    return math.atan2(left, ahead) + aside, -math.atan2(0.37, math.hypot(ahead, left)) + up
