"""The interface of autonomy's tasks, and the task that visits given points."""

from __future__ import annotations

from typing import Protocol

from hub.gcm.navigation import Point
from hub.grids.grid import Grid
from hub.values import dataclass

NOWHERE = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """The next target.

    Attributes:
        points: One after the other, in `map`.
        why: The reason, for people.
        patience: Time to wait before a closed path [s]; NaN: navigation's default.
    """

    points: tuple[Point, ...]
    why: str
    patience: float = NOWHERE


@dataclass(frozen=True, slots=True, kw_only=True)
class Pause:
    """Stand, and choose again later.

    Attributes:
        why: The reason, for people.
        waits: Whether it waits for a change; if not, it only looks around.
    """

    why: str
    waits: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """The end of the task.

    Attributes:
        why: How it ended, for people.
        done: Whether it is done; if not, there was no path.
    """

    why: str
    done: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """The input of a task.

    Attributes:
        x: The robot's position in `map` [m].
        y: The same [m].
        grid: The newest map; None: the task needs none.
        fresh: Whether the map came after the end of the last target.
        now: Monotonic time [s].
        left: Length of navigation's path to the present target [m]; NaN: not known.
        theta: Heading of the robot in `map` [rad]; NaN: not known.
    """

    x: float
    y: float
    grid: Grid | None
    fresh: bool
    now: float
    left: float = NOWHERE
    theta: float = NOWHERE


class AutonomyTask(Protocol):
    """A task of autonomy: it chooses targets, and gets their outcomes.

    Attributes:
        needs_map: Whether it needs a fresh map.
        frontier_m: Length of the map's edge that is left to explore [m]; NaN: it does not explore.
        explored: Share of the edge that needs no exploring, 0 to 1; NaN: it does not explore.
    """

    needs_map: bool
    frontier_m: float
    explored: float

    def choose(self, sight: Sight) -> Target | Pause | End:
        """The next step."""

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Whether to keep the target, given a newer map."""

    def reached(self, target: Target, now: float) -> None:
        """The robot has reached the target."""

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """There is no path to the next point, or no headway; `left` points are left."""


class Visit:
    """Goes to points, one after the other, with some retries after a blockage.

    Attributes:
        needs_map: False: navigation finds the way.
        frontier_m: NaN.
        explored: NaN.
    """

    TRIES = 3
    REST_S = 2.0
    """Time between two tries, in which an obstacle may go away [s]."""

    def __init__(self, points: tuple[Point, ...], why: str) -> None:
        """Start.

        Args:
            points: At least one, in `map`.
            why: The action, for people.
        """
        self.needs_map = False
        self.frontier_m = self.explored = NOWHERE
        self._target = Target(points=points, why=why)
        self._why = ""
        self._done = False
        self._blocked = 0
        self._rests_until = float("-inf")

    def choose(self, sight: Sight) -> Target | Pause | End:
        """The points, until they are reached or were blocked too often."""
        if self._done:
            return End(why="it is there")
        if self._blocked >= self.TRIES:
            why = f"tried {self.TRIES} times: {self._why or 'there is no way'}"
            return End(why=why, done=False)
        if sight.now < self._rests_until:
            why = f"waits, and tries again: {self._why or 'there is no way'}"
            return Pause(why=why, waits=True)
        return self._target

    def keeps(self, _target: Target, _sight: Sight) -> bool:
        """Always."""
        return True

    def reached(self, _target: Target, _now: float) -> None:
        """The last point is reached."""
        self._done = True

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """Count a failed try for the points that are left."""
        self._why = why
        if 0 < left < len(target.points):
            self._target = Target(points=target.points[-left:], why=target.why)
            self._blocked = 0
        self._blocked += 1
        self._rests_until = now + self.REST_S
