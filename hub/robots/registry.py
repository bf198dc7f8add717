"""The kinds of robots: what a robot file may name, and how its hardware is opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hub.robots.description import RobotDescription
from hub.robots.interfaces import Camera, DriveBase


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotKind:
    """How the hardware of one kind of robot is opened; each module opens what it owns.

    Attributes:
        open_base: Opens wheels, range sensors, bumpers, battery.
        open_camera: Opens the camera on its pan/tilt/zoom head.
    """

    open_base: Callable[[RobotDescription], DriveBase]
    open_camera: Callable[[RobotDescription], Camera]


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

    return SimulatedCamera(load_arena(robot.arena))


KINDS = {
    "simulated-magellan": RobotKind(open_base=_simulated_base, open_camera=_simulated_camera),
}
