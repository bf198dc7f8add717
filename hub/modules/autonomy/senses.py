"""What is known of the robot, of navigation and of the map, and whether it is fresh; pure."""

from __future__ import annotations

import math

from hub.gcm.navigation import MotionState, NavigationStatus, RobotState, Task
from hub.grids.grid import Grid

STATE_OLD_S = 1.0
"""An older state of the robot is of no use [s]."""
NAVIGATION_OLD_S = 1.6
"""Navigation says twice a second what it does; after this time it counts as gone [s]."""
STICK_S = 0.3
"""After a velocity command somebody drives for this time, whatever navigation says [s]."""
MAP_OLD_S = 15.0
"""An older map is of no use [s]."""
MAP_PERIOD_S = 2.0
"""How often a map is asked for while one is needed [s]."""

_NEVER = -math.inf


class Senses:
    """The newest of everything, with its time.

    Attributes:
        state: What is known of the robot.
        status: What navigation does.
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
        """A state of the robot, measured then [s]."""
        if math.isfinite(state.x) and math.isfinite(state.y):
            self.state, self._measured = state, measured

    def see_navigation(self, status: NavigationStatus, now: float) -> None:
        """Navigation says what it does."""
        self.status, self._heard = status, now

    def see_stick(self, now: float) -> None:
        """Somebody sent a velocity that is not neutral."""
        self._stick = now

    def see_map(self, grid: Grid, now: float) -> None:
        """A map came."""
        self.grid, self._mapped = grid, now
        self.map_number += 1
        self._no_map = "the map is old"

    def miss_map(self, why: str) -> None:
        """A map was asked for and did not come."""
        self._no_map = f"no map: {why}"

    def trouble(self, now: float, *, needs_map: bool) -> str:
        """Why the robot must not drive by itself at `now` [s], for people; empty: it may."""
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
        """Whether somebody drives by hand at `now` [s], as far as is known."""
        if now - self._stick <= STICK_S:
            return True
        fresh = now - self._measured <= STATE_OLD_S
        moving = fresh and self.state is not None and self.state.motion is MotionState.MOVING
        heard = now - self._heard <= NAVIGATION_OLD_S
        return moving or (heard and self.status is not None and self.status.driver != 0)

    @property
    def under_way(self) -> bool:
        """Whether navigation is on its way by itself, for anybody."""
        return self.status is not None and self.status.task in (Task.GOING, Task.TURNING)
