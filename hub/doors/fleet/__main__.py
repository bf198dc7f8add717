"""The process `fleet` of a robot: its gateway to the fleet."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from hub.doors.fleet.gateway import FleetGateway
from hub.errors import RobotFileError
from hub.gcm.capability import Abilities
from hub.ipc.client import Client
from hub.robots.description import RobotDescription
from hub.runtime import run_module


def abilities(_robot: RobotDescription) -> Abilities:
    """The gateway does nothing for modules of the robot."""
    return Abilities(provides=())


def build(client: Client, robot: RobotDescription) -> Callable[[], None]:
    """Join the fleet.

    Raises:
        RobotFileError: The robot file has no table [fleet].
    """
    if robot.fleet is None:
        raise RobotFileError(str(robot.path), ["it has no table [fleet]; add one"])
    return FleetGateway(client, robot.name, robot.fleet).finish


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the process."""
    return run_module("fleet", "Joins the robot with its fleet.", abilities, build, arguments)


if __name__ == "__main__":
    sys.exit(main())
