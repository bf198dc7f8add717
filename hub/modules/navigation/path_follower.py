"""From what the robot reports and what is wanted to what the wheels get; pure.

Holds together what has to agree: the obstacles around the robot, its pose in `map`, the task, the
map, and whether the operator is assisted. Every method gets the present monotonic time [s].
"""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.mapping import MapRequest
from hub.gcm.navigation import (
    Assistance,
    DriveState,
    GoalCommand,
    LandmarkCorrection,
    TurnCommand,
)
from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.modules.navigation.assistance import AssistanceSwitch
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.drift_watch import DriftWatch
from hub.modules.navigation.dynamic_window import BodyLimits, DynamicWindow
from hub.modules.navigation.obstacle_memory import ObstacleMemory, RangeScan
from hub.modules.navigation.pose_uncertainty import Spread
from hub.modules.navigation.task import LARGEST_TURN, Aim, NavigationTask, refusal
from hub.modules.navigation.unmapped_obstacles import UnmappedObstacles
from hub.pose import Pose, each_wrapped

REACH = 0.7
"""Obstacles farther away than this [m] do not matter to an operator's velocity."""
GOAL_REACH = 1.8
"""Obstacles farther away than this [m] do not matter on the way to a goal."""
SLOW_DOWN = 0.5
"""How softly the robot comes to a goal [m/s^2]."""
DETOUR = 5.0
"""So far beyond robot and goal the part of the map reaches that is asked for first [m]."""
HINDERS = 0.6
"""What holds the robot up is nearer than this [m], and not farther aside than HINDERS_ASIDE."""
HINDERS_ASIDE = math.radians(60.0)
PLAN_AGAIN_S = 1.0
"""A way that was left is not planned anew sooner than this [s]."""

Velocity = tuple[float, float]


class PathFollower:
    """Decides for one robot.

    Attributes:
        errand: What it does by itself.
        correction: How `odom` lies in `map`.
        held_back: How much of the velocity wanted last was held back, 0 to 1.
    """

    def __init__(self, body: BodyLimits) -> None:
        self.errand = NavigationTask()
        self.correction = PoseCorrection()
        self.held_back = 0.0
        self._body = body
        self._window = DynamicWindow(body)
        self._obstacles = ObstacleMemory(body.radius)
        self._hindrances = UnmappedObstacles()
        self._drift = DriftWatch(self.correction, body.radius)
        self._switch = AssistanceSwitch()
        self._drive: DriveState | None = None
        self._map: Grid | None = None
        self._whole = False
        self._planned_at = -math.inf
        self._planned_for: tuple[float, float] | None = None

    @property
    def pose(self) -> Pose:
        """Where the robot is in `map`; the origin before its first report."""
        drive = self._drive
        return self.correction.odom if drive is None else self.correction.pose(*_odom(drive))

    @property
    def spread(self) -> Spread:
        """How far the pose may be off."""
        return self._drift.spread

    def reported(self, drive: DriveState, now: float) -> None:
        """The hardware has reported."""
        self._drive = drive
        scan = RangeScan(
            x=drive.x,
            y=drive.y,
            theta=drive.theta,
            sonar=drive.sonar,
            infrared=drive.infrared,
            bumpers=drive.bumpers,
        )
        self._obstacles.scanned(scan, now)
        self._drift.reported(drive, now)

    def restart(self, odom: Pose) -> None:
        """Begin anew: the dead reckoning did, and lies so in `map`."""
        self.correction.restart(odom)
        self._drift.restart()
        self._obstacles = ObstacleMemory(self._body.radius)
        self._hindrances.forget()
        self._map = None

    def assisted(self, wanted: Velocity, now: float) -> Velocity:
        """What is left of the velocity that an operator wants [m/s, rad/s]."""
        if wanted != (0.0, 0.0):
            self._switch.moved(now)
        drive = self._drive
        if drive is None or wanted[0] == 0.0 or self.assistance(now) is Assistance.OFF:
            self.held_back = 0.0
            return wanted
        points = self._obstacles.points(*_odom(drive), REACH)
        given = self._window.towards((drive.linear, drive.angular), wanted, points)
        self.held_back = _share_taken(wanted, given, self._body)
        return given

    def steered(self, now: float) -> Velocity | None:
        """The velocity for the task that is under way [m/s, rad/s]; None: there is none."""
        self.held_back = 0.0
        drive = self._drive
        aim = None if drive is None else self.errand.aim(self.pose, now)
        if drive is None or aim is None:
            return None
        if aim.stay:
            return 0.0, 0.0
        if aim.turn is not None:
            return 0.0, self._window.turn(aim.turn)
        if self.errand.goal != self._planned_for or (
            self.errand.astray(self.pose) and now - self._planned_at > PLAN_AGAIN_S
        ):
            self._plan(now)
        given = self._heading_for(aim, drive)
        self._look_for_hindrances(aim, drive, given, now)
        return given

    def go(self, goal: GoalCommand, sender: int, now: float) -> str:
        """Begin to go to points, or end what is under way if there are none.

        Returns:
            Why not; empty if it is done.
        """
        why = refusal(goal)
        if not why:
            self.errand.go(goal, sender, now)
            # A map from before may be another one by now; the next one is on its way.
            self._map, self._whole, self._planned_for = None, False, self.errand.goal
        return why

    def turn(self, command: TurnCommand, sender: int, now: float) -> str:
        """Begin to turn on the spot; returns why not, empty if it does."""
        if not abs(command.angle) <= LARGEST_TURN:
            return "nobody turns by so much"
        self.errand.turn(command, sender, self.pose, now)
        return ""

    def correct(self, landmark: LandmarkCorrection, now: float) -> str:
        """Correct the pose; returns what was done, for people."""
        if self._drive is None:
            return "refused: nobody knows where the robot is"
        x, y, theta = _odom(self._drive)
        before = self.correction.odom
        said = self.correction.correct(landmark, Pose(x=x, y=y, theta=theta), now)
        if self.correction.odom is not before:
            self._drift.met_landmark()
        return said

    @property
    def window(self) -> MapRequest | None:
        """Which part of the map is wanted now; None: nothing of it."""
        goal = self.errand.goal
        if goal is None:
            return None
        if self._whole:
            return MapRequest()
        here = self.pose
        return MapRequest(
            x=(here.x + goal[0]) / 2.0,
            y=(here.y + goal[1]) / 2.0,
            width=abs(goal[0] - here.x) + 2.0 * DETOUR,
            height=abs(goal[1] - here.y) + 2.0 * DETOUR,
        )

    def mapped(self, grid: Grid | None, now: float) -> None:
        """A map has come; None: there is none."""
        self._map = None if grid is None else known_part(grid)
        if self._drive is not None:
            x, y, theta = _odom(self._drive)
            self._drift.mapped(self._map, Pose(x=x, y=y, theta=theta), now)
        self._plan(now)

    def assist(self, assistance: Assistance, now: float) -> None:
        """Somebody switches the holding back."""
        self._switch.switch(assistance, now)

    def assistance(self, now: float) -> Assistance:
        """Whether the operator is held back now."""
        return self._switch.state(now)

    def _heading_for(self, aim: Aim, drive: DriveState) -> Velocity:
        carrot = self.pose.inward(aim.x, aim.y)
        points = self._obstacles.points(*_odom(drive), GOAL_REACH)
        fastest = min(aim.limit, math.sqrt(2.0 * SLOW_DOWN * aim.left))
        return self._window.to_goal((drive.linear, drive.angular), carrot, fastest, points)

    def _look_for_hindrances(
        self, aim: Aim, drive: DriveState, given: Velocity, now: float
    ) -> None:
        """Plan anew round what keeps the robot from going where it looks already."""
        bearing = math.atan2(*reversed(self.pose.inward(aim.x, aim.y)))
        still = given[0] == 0.0 and abs(bearing) < HINDERS_ASIDE / 2.0
        if not self._hindrances.held(still=still, now=now) or self._map is None:
            return
        x, y = self._obstacles.points(*_odom(drive), HINDERS)
        ahead = np.abs(each_wrapped(np.arctan2(y, x) - bearing)) < HINDERS_ASIDE
        here = self.pose
        self._hindrances.note(*here.outward(x[ahead], y[ahead]), now)
        self._plan(now)
        self.errand.goes_round(here, now)

    def _plan(self, now: float) -> None:
        """Plan the way to the present point on the map, if there is one."""
        goal = self.errand.goal
        self._planned_at, self._planned_for = now, goal
        if goal is None or self._map is None:
            self.errand.planned(None)
            return
        here = self.pose
        radius = self._body.radius + self._body.margin
        grid = self._hindrances.onto(self._map, now)
        way = plan(grid, (here.x, here.y), goal, radius=radius)
        if way is None and grid is not self._map:
            self._hindrances.forget()
            way = plan(self._map, (here.x, here.y), goal, radius=radius)
        if way is not None:
            self.errand.planned(way)
        elif self._whole:
            self.errand.planned(None, "the map shows no way there")
        else:
            # There may be one around the window; the next map that is asked for is the whole one.
            self._whole = True


def known_part(grid: Grid) -> Grid | None:
    """The smallest part of a map that holds all cells that are known; None: there are none.

    Planning takes time with every cell, and most of a map is still unknown.
    """
    known = ~grid.unknown
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        return None
    top, left = int(rows[0]), int(columns[0])
    return Grid(
        cells=grid.cells[top : rows[-1] + 1, left : columns[-1] + 1],
        resolution=grid.resolution,
        origin_x=grid.origin_x + left * grid.resolution,
        origin_y=grid.origin_y + top * grid.resolution,
    )


def _odom(drive: DriveState) -> tuple[float, float, float]:
    return drive.x, drive.y, drive.theta


def _share_taken(wanted: Velocity, given: Velocity, body: BodyLimits) -> float:
    """How much of a velocity is taken away, both of their limits counting alike; 0 to 1."""
    limits = body.linear_limit, body.angular_limit
    taken = math.hypot(
        *((a - b) / limit for a, b, limit in zip(wanted, given, limits, strict=True))
    )
    whole = math.hypot(*(a / limit for a, limit in zip(wanted, limits, strict=True)))
    return min(1.0, taken / whole) if whole else 0.0
