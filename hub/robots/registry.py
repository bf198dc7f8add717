"""The kinds of robots: what a robot file may name, and how its hardware is opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hub.robots.description import ROBOTS_OWN, RobotDescription
from hub.robots.interfaces import Camera, DriveBase


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotKind:
    """How the hardware of one kind of robot is opened; each module opens what it owns.

    Attributes:
        open_base: Opens wheels, range sensors, bumpers, battery.
        open_camera: Opens its own camera; use the function `open_camera`.
        pan_tilt_zoom: Whether its own camera stands on a head that moves.
    """

    open_base: Callable[[RobotDescription], DriveBase]
    open_camera: Callable[[RobotDescription], Camera]
    pan_tilt_zoom: bool = True


def _simulated_base(robot: RobotDescription) -> DriveBase:
    from hub.robots.magellan import SimulatedMagellan
    from hub.sim.arena import load_arena

    return SimulatedMagellan(
        load_arena(robot.arena),
        seed=robot.seed,
        linear_limit=robot.linear_limit,
        angular_limit=robot.angular_limit,
    )


def _simulated_camera(robot: RobotDescription) -> Camera:
    from hub.robots.magellan import SimulatedCamera
    from hub.sim.arena import load_arena

    return SimulatedCamera(
        load_arena(robot.arena), light=robot.light, headlight=robot.headlight, seed=robot.seed
    )


KINDS = {
    "simulated-magellan": RobotKind(open_base=_simulated_base, open_camera=_simulated_camera),
}


def open_camera(robot: RobotDescription) -> Camera:
    """The camera that a robot file names: the robot's own, or another.

    Raises:
        CameraError: The file names an address of a kind that is not read.
    """
    if robot.camera_source == ROBOTS_OWN:
        return KINDS[robot.kind].open_camera(robot)
    from hub.robots.video_camera import VideoCamera

    return VideoCamera(
        robot.camera_source,
        horizontal_fov=robot.camera_fov,
        forward=robot.camera_forward,
        height=robot.camera_height,
    )


def camera_moves(robot: RobotDescription) -> bool:
    """Whether the camera that a robot file names stands on a pan/tilt/zoom head."""
    return robot.camera_source == ROBOTS_OWN and KINDS[robot.kind].pan_tilt_zoom
