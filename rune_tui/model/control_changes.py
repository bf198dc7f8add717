"""Finds robots whose owner changed or that were stopped: their inputs must be released."""

from __future__ import annotations

from collections.abc import Iterable

from rune_tui.model.control import Standing, is_lost, standing
from rune_tui.model.robot_state import RobotState


class ControlChanges:
    """Remembers each robot's last report of control and of stops."""

    def __init__(self) -> None:
        self._standings: dict[str, Standing] = {}
        self._stops: dict[str, int] = {}

    def look(self, robots: Iterable[RobotState]) -> list[str]:
        """Names of the robots that were stopped, or whose owner changed, since the last call."""
        return [
            robot.name for robot in robots if self._owner_changed(robot) or self._stopped(robot)
        ]

    def _owner_changed(self, robot: RobotState) -> bool:
        now = standing(robot)
        before = self._standings.get(robot.name, Standing.UNKNOWN)
        self._standings[robot.name] = now
        return is_lost(before, now)

    def _stopped(self, robot: RobotState) -> bool:
        if (navigation := robot.navigation) is None:
            return False
        now = navigation.value.stops
        before = self._stops.get(robot.name, now)
        self._stops[robot.name] = now
        return now != before
