"""From the robot's reports and its commands to the velocity of the wheels; pure.

It keeps the obstacles around the robot, its pose in `map`, the task, the map, and the switch of
assistance consistent. Every method gets the present monotonic time [s].
"""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beam_scans import ScanReader
from hub.gcm.body import RobotBody
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.imu import Imu
from hub.gcm.mapping import MapRequest
from hub.gcm.navigation import (
    Assistance,
    Cause,
    DriveState,
    GoalCommand,
    LandmarkCorrection,
    TurnCommand,
)
from hub.gcm.ranges import RangeReadings
from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.modules.navigation.assistance import AssistanceSwitch
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.drift_watch import DriftWatch
from hub.modules.navigation.dynamic_window import BodyLimits, DynamicWindow, Floats
from hub.modules.navigation.ground_memory import GroundMemory
from hub.modules.navigation.obstacle_memory import ObstacleMemory
from hub.modules.navigation.pose_uncertainty import Spread
from hub.modules.navigation.range_watch import RangeWatch
from hub.modules.navigation.route import Way
from hub.modules.navigation.task import LARGEST_TURN, Aim, NavigationTask, refusal
from hub.modules.navigation.trail import Trail
from hub.modules.navigation.unmapped_obstacles import UnmappedObstacles, with_obstacles
from hub.pose import Pose, each_wrapped

REACH = 0.5
"""Obstacles within this distance of the rim limit an operator's velocity [m]; farther ones do where
the robot needs longer to stop."""
GOAL_REACH = 1.6
"""Obstacles within this distance of the rim limit the velocity to a goal [m]."""
SLOW_DOWN = 0.5
"""Deceleration before a goal [m/s^2]."""
DETOUR = 5.0
"""The first request for a map reaches this far beyond robot and goal [m]."""
BLOCKS = 0.4
"""A point blocks the robot within this distance of the rim [m], and within the angle
BLOCKS_ASIDE."""
BLOCKS_ASIDE = math.radians(60.0)
_SPARE = 0.1
"""Obstacles count from this distance before the robot must slow down [m]."""
CAREFUL_SPEED = 0.2
"""Largest velocity of an assisted robot that does not see all around [m/s]: it is tilted too far,
or a range sensor is silent."""
PLAN_AGAIN_S = 1.0
"""Least time before the path is planned again after the robot left it [s]."""
EDGE_AGAIN_S = 0.3
"""The same after an edge was found [s]: soon, while there is room to turn."""

Velocity = tuple[float, float]


class PathFollower:
    """Decides on the velocity of one robot.

    Attributes:
        task: The present task, or the last one.
        correction: The transform from `odom` to `map`.
        held_back: The share by which the last command was reduced, 0 to 1.
        senses: The range sensors that are silent.
    """

    def __init__(self, limits: BodyLimits, body: RobotBody) -> None:
        self.task = NavigationTask()
        self.correction = PoseCorrection()
        self.held_back = 0.0
        self._limits = limits
        fastest = limits.fastest
        stopping = limits.margin + limits.margin_s * fastest + limits.stopping(fastest)
        self._reach = limits.radius + max(REACH, stopping + _SPARE)
        self._goal_reach = max(self._reach, limits.radius + GOAL_REACH)
        self._body = body
        self._window = DynamicWindow(limits)
        self._reader = ScanReader(body)
        self._rules = BeamRules(body, self._reader.beams)
        self.senses = RangeWatch(body.ranges, self._reader.beams)
        self._obstacles = ObstacleMemory(body, self._rules, self._goal_reach, self.senses.beams)
        self._ground = GroundMemory(body, self._reader.beams, limits.step)
        self._trail = Trail(self._reader.beams)
        self._was_tilted = False
        self._unmapped = UnmappedObstacles()
        self._drift = DriftWatch(self.correction, self._rules)
        self._switch = AssistanceSwitch()
        self._drive: DriveState | None = None
        self._map: Grid | None = None
        self._map_is_whole = False
        self._planned_at = -math.inf
        self._planned_for: tuple[float, float] | None = None
        self._planned_with = 0

    @property
    def pose(self) -> Pose:
        """The robot's pose in `map`; the origin before its first report."""
        drive = self._drive
        return self.correction.odom if drive is None else self.correction.pose(*_odom(drive))

    @property
    def spread(self) -> Spread:
        """The uncertainty of the pose."""
        return self._drift.spread

    @property
    def tilt(self) -> float:
        """Angle to the ground at which only near ranges are used [rad]; 0: all are used."""
        return self._reader.tilt

    @property
    def edges(self) -> tuple[Floats, Floats]:
        """The known edges in `base_link` [m]; shapes (n,)."""
        if self._drive is None:
            return np.empty(0), np.empty(0)
        x, y, theta = _odom(self._drive)
        return self._ground.edges(Pose(x=x, y=y, theta=theta))

    def away(self, x: Floats, y: Floats) -> Floats:
        """Distances of points in `base_link` from the robot's body [m], shape (n,)."""
        outline = self._limits.outline
        if outline is None:
            return np.asarray(np.hypot(x, y) - self._limits.radius)
        return outline.distances(x, y)

    def reported(self, drive: DriveState, measured: float, now: float) -> None:
        """Take a report of the hardware, measured at a monotonic time [s]."""
        self._drive = drive
        self._reader.moved(drive, measured)
        self.senses.look(now)
        self._obstacles.moved(drive, now)
        self._trail.moved(Pose(x=drive.x, y=drive.y, theta=drive.theta))
        self._drift.moved(drive, now)

    def scanned(self, readings: RangeReadings, measured: float, now: float) -> None:
        """Take the ranges of the sensors, measured at a monotonic time [s]."""
        scan = self._reader.read(readings, measured)
        self.senses.heard(readings, now)
        if scan is None:
            return
        if scan.tilted and not self._was_tilted:
            # What was seen from another plane may be the ramp that the robot is on now.
            self._obstacles.forget()
        self._was_tilted = scan.tilted
        self._obstacles.scanned(scan, now)
        self._ground.scanned(scan, now)
        self._ground.age(scan.pose, now)
        if not scan.tilted:
            self._drift.scanned(scan, now)

    def tilted(self, imu: Imu, measured: float) -> None:
        """Take the tilt of the robot, measured at a monotonic time [s]."""
        self._reader.tilted(imu, measured)

    def restart(self, odom: Pose) -> None:
        """Start again with a new dead reckoning, given its origin in `map`."""
        self.correction.restart(odom)
        self._drift.restart()
        self._reader.restart()
        self._obstacles = ObstacleMemory(
            self._body, self._rules, self._goal_reach, self.senses.beams
        )
        self._ground = GroundMemory(self._body, self._reader.beams, self._limits.step)
        self._trail = Trail(self._reader.beams)
        self._unmapped.forget()
        self._map = None

    def assisted(self, wanted: Twist, now: float) -> Twist:
        """The admissible part of the velocity that an operator commands."""
        if not wanted.neutral:
            self._switch.moved(now)
        given = wanted
        if self._drive is not None and self.assistance(now) is Assistance.ON:
            given = self._admissible(wanted, self._drive)
        self.held_back = _share_taken(wanted, given, self._limits)
        return given

    def _admissible(self, wanted: Twist, drive: DriveState) -> Twist:
        """The admissible part of a velocity; what leads up or down and tilts is not held back."""
        surge, sway = wanted.linear.x, wanted.linear.y
        axis = math.atan2(sway, surge) if sway else 0.0
        speed = math.hypot(surge, sway) if sway else surge
        along, aside = Pose(theta=axis).inward(drive.linear, drive.velocity.linear.y)
        fastest = CAREFUL_SPEED if self.tilt or self.senses.silent else math.inf
        speed = max(-fastest, min(fastest, speed))
        points = self._points(drive, self._reach)
        speed, turn = self._window.towards(
            (along, drive.angular), (speed, wanted.angular.z), points, axis=axis, aside=aside
        )
        ahead, left = (speed * math.cos(axis), speed * math.sin(axis)) if sway else (speed, 0.0)
        return Twist(
            linear=Vector3(x=ahead, y=left, z=wanted.linear.z),
            angular=Vector3(x=wanted.angular.x, y=wanted.angular.y, z=turn),
        )

    def rest(self) -> None:
        """Note that no velocity is commanded."""
        self.held_back = 0.0

    def steered(self, now: float) -> Velocity | None:
        """The velocity for the active task [m/s, rad/s]; None: no task is active."""
        self.rest()
        if self.tilt:
            why = f"tilted by {math.degrees(self.tilt):.0f} degrees, it does not see all around"
            self.task.hold(Cause.TILTED, why, now)
        elif self.senses.blind:
            self.task.hold(Cause.BLIND, "all its range sensors are silent", now)
        if self.tilt or self.senses.blind:
            return (0.0, 0.0) if self.task.active else None
        drive = self._drive
        aim = None if drive is None else self.task.aim(self.pose, now)
        if drive is None or aim is None:
            return None
        if aim.stay:
            return 0.0, 0.0
        if aim.turn is not None:
            points = self._points(drive, self._reach)
            return 0.0, self._window.turn((drive.linear, drive.angular), aim.turn, points)
        waited = now - self._planned_at
        if (
            self.task.goal != self._planned_for
            or (self.task.has_left_path(self.pose) and waited > PLAN_AGAIN_S)
            or (self._ground.found != self._planned_with and waited > EDGE_AGAIN_S)
        ):
            self._plan(now)
        given = self._heading_for(aim, drive)
        self.task.followed(by_driver=not any(given) or not drive.commanded.neutral)
        self._check_for_blockage(aim, drive, given, now)
        return given

    def go(self, goal: GoalCommand, sender: int, now: float) -> str:
        """Begin to go to points, or end the task if there are none.

        Returns:
            Why the goal is refused; empty if it is not.
        """
        why = refusal(goal)
        if not why:
            self.task.go(goal, sender, now)
            # The old map may be outdated; a new one is requested.
            self._map, self._map_is_whole, self._planned_for = None, False, self.task.goal
        return why

    def turn(self, command: TurnCommand, sender: int, now: float) -> str:
        """Begin to turn on the spot; returns why that is refused, or an empty string."""
        if not abs(command.angle) <= LARGEST_TURN:
            return "the angle is too large"
        self.task.turn(command, sender, self.pose, now)
        return ""

    def correct(self, landmark: LandmarkCorrection, now: float) -> str:
        """Correct the pose; returns the result, for people."""
        if self._drive is None:
            return "refused: the robot's pose is not known"
        x, y, theta = _odom(self._drive)
        before = self.correction.odom
        said = self.correction.correct(landmark, Pose(x=x, y=y, theta=theta), now)
        if self.correction.odom is not before:
            self._drift.met_landmark()
        return said

    @property
    def window(self) -> MapRequest | None:
        """The part of the map that the task needs now; None: nothing."""
        goal = self.task.goal
        if goal is None:
            return None
        if self._map_is_whole:
            return MapRequest()
        here = self.pose
        return MapRequest(
            x=(here.x + goal[0]) / 2.0,
            y=(here.y + goal[1]) / 2.0,
            width=abs(goal[0] - here.x) + 2.0 * DETOUR,
            height=abs(goal[1] - here.y) + 2.0 * DETOUR,
        )

    def mapped(self, grid: Grid | None, now: float) -> None:
        """Take a map; None: there is none."""
        self._map = None if grid is None else known_part(grid)
        if self._drive is not None:
            x, y, theta = _odom(self._drive)
            self._drift.mapped(self._map, Pose(x=x, y=y, theta=theta), now)
        self._plan(now)

    def assist(self, assistance: Assistance, now: float) -> None:
        """Switch assistance."""
        self._switch.switch(assistance, now)

    def assistance(self, now: float) -> Assistance:
        """Whether assistance is on now."""
        return self._switch.state(now)

    def _points(self, drive: DriveState, reach: float) -> tuple[Floats, Floats]:
        """The obstacles and edges around the robot, in `base_link` [m]; shapes (n,)."""
        x, y = self._obstacles.points(*_odom(drive), reach)
        more_x, more_y = self._ground.points(*_odom(drive), reach)
        return np.concatenate((x, more_x)), np.concatenate((y, more_y))

    def _heading_for(self, aim: Aim, drive: DriveState) -> Velocity:
        carrot = self.pose.inward(aim.x, aim.y)
        points = self._points(drive, self._goal_reach)
        limit = min(aim.limit, CAREFUL_SPEED) if self.senses.silent else aim.limit
        fastest = min(limit, math.sqrt(2.0 * SLOW_DOWN * aim.left))
        here, now = Pose(x=drive.x, y=drive.y, theta=drive.theta), (drive.linear, drive.angular)
        # A round body always has room to turn.
        way_back = self._trail.way_back(here, carrot) if self._limits.outline else None
        return self._window.to_goal(now, carrot, fastest, points, way_back=way_back)

    def _check_for_blockage(self, aim: Aim, drive: DriveState, given: Velocity, now: float) -> None:
        """Plan again round obstacles that block a robot which heads for its path already."""
        bearing = math.atan2(*reversed(self.pose.inward(aim.x, aim.y)))
        still = given[0] == 0.0 and abs(bearing) < BLOCKS_ASIDE / 2.0
        if not self._unmapped.blocked(still=still, now=now) or self._map is None:
            return
        x, y = self._points(drive, self._limits.radius + BLOCKS)
        ahead = np.abs(each_wrapped(np.arctan2(y, x) - bearing)) < BLOCKS_ASIDE
        here = self.pose
        self._unmapped.note(*here.outward(x[ahead], y[ahead]), now)
        self._plan(now)
        self.task.goes_round(here, now)

    def _plan(self, now: float) -> None:
        """Plan the path to the next point on the map, if there is a map."""
        goal = self.task.goal
        self._planned_at, self._planned_for = now, goal
        self._planned_with = self._ground.found
        if goal is None or self._map is None or self.task.by_robot:
            self.task.planned(None)
            return
        here = self.pose
        known = with_obstacles(self._map, *here.outward(*self.edges))
        grid = self._unmapped.onto(known, now)
        way = self._way(grid, (here.x, here.y), goal)
        if way is None and grid is not known:
            self._unmapped.forget()
            way = self._way(known, (here.x, here.y), goal)
        if way is not None:
            self.task.planned(way)
        elif self._map_is_whole:
            self.task.planned(None, "the map shows no way there")
        else:
            # A path may lead round the window; so request the whole map next.
            self._map_is_whole = True

    def _way(self, grid: Grid, start: Velocity, goal: Velocity) -> Way | None:
        """A path on which the robot can turn everywhere, or else one that is wide enough."""
        limits = self._limits
        radii = sorted({limits.radius, max(limits.inner_radius, 0.0) or limits.radius})
        ways = (plan(grid, start, goal, radius=each + limits.margin) for each in radii[::-1])
        return next((way for way in ways if way is not None), None)


def known_part(grid: Grid) -> Grid | None:
    """The smallest part of a map with all known cells; None: no cell is known.

    Planning takes time for every cell, and most cells of a map are unknown.
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


def _share_taken(wanted: Twist, given: Twist, limits: BodyLimits) -> float:
    """The share by which a velocity was reduced, 0 to 1; its parts are scaled by their limits."""

    def scaled(twist: Twist) -> tuple[float, float, float]:
        surge, yaw = limits.share(twist.linear.x, twist.angular.z)
        sway, _ = limits.share(twist.linear.y, 0.0)
        return surge, sway, yaw

    whole = math.hypot(*scaled(wanted))
    return min(1.0, math.dist(scaled(wanted), scaled(given)) / whole) if whole else 0.0
