"""A robot that can dive and fly, as far as the driver knows: it writes down what it has to do."""

from __future__ import annotations

import os
from pathlib import Path

from hub.robots.description import RobotDescription
from hub.robots.left_alone import LeftAlone
from hub.robots.registry import RobotKind
from hub.sim.arena import load_arena
from tests.support.magellan import SimulatedMagellan

VARIABLE = "RUNE_TEST_DEEDS"
"""Names the file."""


class DivingRobot(SimulatedMagellan):
    """Implements `BodyLeftAlone`."""

    def __init__(self, robot: RobotDescription) -> None:
        super().__init__(load_arena(robot.arena))

    def left_alone(self, action: LeftAlone | None) -> None:
        """Note it, a line each."""
        with Path(os.environ[VARIABLE]).open("a") as file:
            file.write(f"{'operated' if action is None else action.value}\n")


KIND = RobotKind(open_body=DivingRobot)
KIND_NAME = f"{__name__}:KIND"
