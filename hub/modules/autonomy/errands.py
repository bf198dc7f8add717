"""What a behaviour wants next, as all behaviours say it, and the one that visits given points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from hub.gcm.navigation import Point
from hub.grids.grid import Grid

NOWHERE = float("nan")


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Where to go next.

    Attributes:
        points: One after the other, in `map`.
        why: For people.
        patience: How long to wait where the way is closed [s]; NaN: as long as navigation does.
    """

    points: tuple[Point, ...]
    why: str
    patience: float = NOWHERE


@dataclass(frozen=True, slots=True, kw_only=True)
class Pause:
    """Stand for a while and ask again.

    Attributes:
        why: For people.
        waits: Whether something has to change first; if not, it only looks around.
    """

    why: str
    waits: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """The errand is over.

    Attributes:
        why: How it ended, for people.
        done: Whether it is done; if not, there was no way.
    """

    why: str
    done: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """What an errand may look at.

    Attributes:
        x: Of the robot in `map` [m].
        y: Of the robot in `map` [m].
        grid: The newest map; None if the errand needs none.
        fresh: Whether the map came after the last target was reached or given up.
        now: Monotonic time [s].
        left: Way that navigation has left to the present target [m]; NaN: not known.
        theta: Heading of the robot in `map` [rad]; NaN: not known.
    """

    x: float
    y: float
    grid: Grid | None
    fresh: bool
    now: float
    left: float = NOWHERE
    theta: float = NOWHERE


class Errand(Protocol):
    """What a behaviour does: it is asked for targets, and told what became of them.

    Attributes:
        needs_map: Whether it does nothing without a fresh map.
        frontier_m: Length of the map's edge that is left to explore [m]; NaN: it does not explore.
        explored: Share of the edge that needs no exploring, 0 to 1; NaN: it does not explore.
    """

    needs_map: bool
    frontier_m: float
    explored: float

    def choose(self, sight: Sight) -> Target | Pause | End:
        """What to do next."""

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Whether the target is still worth going to, now that there is a newer map."""

    def reached(self, target: Target, now: float) -> None:
        """The robot is there."""

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """There is no way to the first of so many points that are left, or no headway."""


class Visit:
    """Goes to points, one after the other; tries again a few times where it is blocked.

    Attributes:
        needs_map: False: navigation finds the way.
        frontier_m: NaN.
        explored: NaN.
    """

    TRIES = 3
    REST_S = 2.0
    """Between two tries: whatever stood in the way may have gone [s]."""

    def __init__(self, points: tuple[Point, ...], why: str) -> None:
        """Get ready.

        Args:
            points: At least one, in `map`.
            why: What it does, for people.
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

    def keeps(self, target: Target, sight: Sight) -> bool:
        """Always."""
        del target, sight
        return True

    def reached(self, target: Target, now: float) -> None:
        """The last point is reached."""
        del target, now
        self._done = True

    def blocked(self, target: Target, left: int, now: float, why: str) -> None:
        """One try less, for the points that are left."""
        self._why = why
        if 0 < left < len(target.points):
            self._target = Target(points=target.points[-left:], why=target.why)
            self._blocked = 0
        self._blocked += 1
        self._rests_until = now + self.REST_S
