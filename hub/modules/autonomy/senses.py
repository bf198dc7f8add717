"""The newest state of the robot, of navigation and of the map, with their ages; pure."""

from __future__ import annotations

import math

from hub.gcm.navigation import MotionState, NavigationStatus, RobotState, Task
from hub.grids.grid import Grid

STATE_OLD_S = 1.0
"""Largest age of the robot's state [s]."""
NAVIGATION_OLD_S = 1.6
"""Largest age of navigation's status, which comes at 2 Hz [s]."""
STICK_S = 0.3
"""After a velocity command an operator drives for this time, with any status of navigation [s]."""
MAP_OLD_S = 15.0
"""Largest age of the map [s]."""
MAP_PERIOD_S = 2.0
"""Time between two requests of a map [s]."""

_NEVER = -math.inf


class Senses:
    """The newest data, with their times.

    Attributes:
        state: The state of the robot.
        status: The status of navigation.
        grid: The map.
        map_number: Counts the maps.
    """

    def __init__(self) -> None:
        self.state: RobotState | None = None
        self.status: NavigationStatus | None = None
        self.grid: Grid | None = None
        self.map_number = 0
        self._measured = self._stick = _NEVER
        self._heard = _NEVER
        self._mapped = _NEVER
        self._no_map = "no map has come yet"

    def see_robot(self, state: RobotState, measured: float) -> None:
        """Take a state of the robot, measured at that time [s]."""
        if math.isfinite(state.x) and math.isfinite(state.y):
            self.state, self._measured = state, measured

    def see_navigation(self, status: NavigationStatus, now: float) -> None:
        """Take a status of navigation."""
        self.status, self._heard = status, now

    def see_stick(self, now: float) -> None:
        """Note a command to move by an operator."""
        self._stick = now

    def see_map(self, grid: Grid, now: float) -> None:
        """Take a map."""
        self.grid, self._mapped = grid, now
        self.map_number += 1
        self._no_map = "the map is old"

    def miss_map(self, why: str) -> None:
        """Note that a request of a map failed."""
        self._no_map = f"no map: {why}"

    def fault(self, now: float, *, needs_map: bool) -> str:
        """Why autonomy must not drive at `now` [s], for people; empty: it may."""
        if self.state is None:
            return "nothing is known of the robot"
        if now - self._measured > STATE_OLD_S:
            return "nothing new is known of the robot"
        if self.status is None or now - self._heard > NAVIGATION_OLD_S:
            return "navigation does not answer"
        if self.state.motion is MotionState.NO_DRIVER:
            return "the driver is gone"
        if needs_map and now - self._mapped > MAP_OLD_S:
            return self._no_map
        return ""

    def driven(self, now: float) -> bool:
        """Whether an operator drives at `now` [s]."""
        if now - self._stick <= STICK_S:
            return True
        fresh = now - self._measured <= STATE_OLD_S
        moving = fresh and self.state is not None and self.state.motion is MotionState.MOVING
        heard = now - self._heard <= NAVIGATION_OLD_S
        return moving or (heard and self.status is not None and self.status.driver != 0)

    @property
    def under_way(self) -> bool:
        """Whether navigation has an active task of any sender."""
        return self.status is not None and self.status.task in (Task.GOING, Task.TURNING)
