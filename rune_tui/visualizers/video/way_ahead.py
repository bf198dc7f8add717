"""The path of a robot at its present command, as lines on the ground."""

from __future__ import annotations

import math
from typing import Final, Self

import numpy as np

from hub.gcm.navigation import RobotState as NavigationState
from hub.values import dataclass
from rune_tui.model.pose import Pose
from rune_tui.model.sightings import Floats
from rune_tui.model.sweep import swept_edges

REACTION_S: Final = 0.3
"""Time for which navigation follows the last command [s]."""

_SLOWEST: Final = 0.01
"""Least speed [m/s] that is not a turn on the spot, and least turn rate [rad/s] of an arc."""
_MOST_ARROWS: Final = 8
_TIP: Final = 0.6
"""Length of an arrow, and half its width [radii of the body]."""
_TURN: Final = 2.0 * math.pi
_BREAK: Final = np.full((1, 2), np.nan)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WayAhead:
    """The ground that a robot covers at constant velocities.

    Attributes:
        edges: The left and the right edge of the swept ground [m], a row of NaN between them.
        arrows: Arrow heads [m] at the robot's centre after each further second.
        stop: Line across the path at the body's end after a stop now, from left to right [m].
        stop_distance: Stopping distance [m].
    """

    edges: Floats
    arrows: Floats
    stop: Floats
    stop_distance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """The command of a robot, and the frame in which it is drawn.

    Attributes:
        linear: Speed forward [m/s].
        angular: Turn rate [rad/s], counter-clockwise.
        radius: Radius of the circle around the whole robot [m].
        now: The robot's pose now; None: not needed.
        then: Its pose in the frame of the drawing; None: its own frame.
        old: Whether a newer command may exist.
    """

    linear: float
    angular: float
    radius: float
    now: Pose | None
    then: Pose | None
    old: bool

    @classmethod
    def of(
        cls, navigation: NavigationState, *, radius: float, then: Pose | None, old: bool
    ) -> Self | None:
        """The command of a robot; None: it stands, or the command is unknown."""
        linear, angular = navigation.commanded_linear, navigation.commanded_angular
        moves = abs(linear) >= _SLOWEST or abs(angular) >= _SLOWEST
        if not moves or not math.isfinite(linear + angular):
            return None
        now: Pose | None = Pose(x=navigation.x, y=navigation.y, theta=navigation.theta)
        if then is None or not math.isfinite(navigation.x + navigation.y + navigation.theta):
            now, then = None, None
        return cls(linear=linear, angular=angular, radius=radius, now=now, then=then, old=old)

    @property
    def words(self) -> str:
        """Its motion in words, if the path is not visible."""
        if not self._drives:
            return "turns left" if self.angular > 0.0 else "turns right"
        return f"drives {'ahead' if self.linear > 0.0 else 'back'}, out of the picture"

    def way(self, *, reach: float, braking: float) -> WayAhead:
        """The ground that the robot covers.

        Args:
            reach: Distance to look ahead [m].
            braking: Guaranteed deceleration [m/s^2].
        """
        speed = abs(self.linear)
        stop_distance = speed * REACTION_S + speed**2 / (2.0 * braking)
        edges = arrows = stop = _BREAK
        if self._drives:
            turns = abs(self.angular) >= _SLOWEST
            seconds = min(reach / speed, _TURN / abs(self.angular) if turns else math.inf)
            left, right = self._swept(seconds)
            edges = np.concatenate((left, _BREAK, right))
            arrows = self._arrows(seconds)
            body = self._swept((stop_distance + self.radius) / speed)
            stop = np.stack([edge[-1] for edge in body])
        return WayAhead(
            edges=self._seen(edges),
            arrows=self._seen(arrows),
            stop=self._seen(stop),
            stop_distance=stop_distance,
        )

    @property
    def _drives(self) -> bool:
        return abs(self.linear) >= _SLOWEST

    def _swept(self, seconds: float) -> tuple[Floats, Floats]:
        return swept_edges(self.radius, self.linear, self.angular, seconds)

    def _seen(self, points: Floats) -> Floats:
        """Points of the robot's frame now [m], in the frame to draw in."""
        if self.now is None or self.then is None:
            return points
        return self.then.from_map(self.now.to_map(points))

    def _arrows(self, seconds: float) -> Floats:
        """An arrow head for each of the next seconds, with a row of NaN after each."""
        heads: list[Floats] = [_BREAK]
        for second in range(1, min(_MOST_ARROWS, math.floor(seconds)) + 1):
            left, right = (edge[-1] for edge in self._swept(second))
            centre, aside = (left + right) / 2.0, (left - right) / 2.0 * _TIP
            ahead = math.copysign(1.0, self.linear) * np.array((aside[1], -aside[0]))
            heads += [np.stack((centre + aside, centre + ahead, centre - aside)), _BREAK]
        return np.concatenate(heads)
