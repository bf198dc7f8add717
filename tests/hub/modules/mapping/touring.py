"""Tours of a simulated robot through an arena, the map made on them, and how true it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import ScanReader
from hub.gcm.beams import beams_of
from hub.gcm.body import RobotBody
from hub.gcm.geometry import Twist
from hub.gcm.navigation import DriveState, GroundTruth, MotionState, RobotState
from hub.gcm.ranges import RangeReadings
from hub.grids.grid import Grid
from hub.modules.mapping.grid import OccupancyGrid
from hub.modules.mapping.scans import ScanSelector
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.correction import PoseCorrection
from hub.modules.navigation.drift_watch import DriftWatch
from hub.pose import Pose, wrapped
from hub.sim.arena import Arena
from hub.sim.plane_rays import first_hits
from tests.support.footprints import distances
from tests.support.magellan import SimulatedMagellan, magellan_body

Floats = npt.NDArray[np.float64]

BEAMS = beams_of(magellan_body())
PERIOD = 0.05
"""Time between two reports, as navigation gives them [s]."""
MAP_PERIOD = 1.5
"""Time between two maps that come to navigation [s]."""
TOLERANCE = 0.1
"""How far from the truth a mark on the map may be [m]."""
OCCUPIED = math.log(0.65 / 0.35)
"""From these log-odds on a map's reader takes a cell for occupied."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What there is to know at one moment of a tour."""

    time: float
    truth: GroundTruth
    drive: DriveState
    ranges: RangeReadings | None


def tour(robot: SimulatedMagellan, points: Sequence[tuple[float, float]]) -> Iterator[Report]:
    """Drive from point to point, knowing where the robot really is; reports at 20 Hz."""
    now = 0.0
    for goal_x, goal_y in points:
        while True:
            truth = robot.ground_truth()
            left = math.hypot(goal_x - truth.x, goal_y - truth.y)
            if left < 0.03:
                break
            direction = math.atan2(goal_y - truth.y, goal_x - truth.x)
            error = wrapped(direction - truth.theta)
            if abs(error) > 0.25:
                velocity = 0.0, math.copysign(min(0.7, 2.0 * abs(error) + 0.1), error)
            else:
                velocity = min(0.4, 1.5 * left + 0.03), 2.0 * error
            robot.command(Twist.planar(*velocity))
            robot.advance(PERIOD)
            now += PERIOD
            scans = robot.ranges(now)
            yield Report(
                time=now,
                truth=robot.ground_truth(),
                drive=robot.drive_state(now),
                ranges=None if scans is None else RangeReadings(scans=scans),
            )


def from_start(truth: GroundTruth, start: Pose) -> Pose:
    """Where the robot is, seen from where it started: its true pose in `map`."""
    return Pose(x=truth.x, y=truth.y, theta=truth.theta).seen_from(start)


class PoseSource:
    """The pose that navigation would tell: dead reckoning, put right now and then.

    A landmark corrects it by a jump: `map` is `odom` moved and turned so that the pose is true.
    """

    def __init__(self, start: Pose, correct_every: float) -> None:
        self._start = start
        self._every = correct_every
        self._due = correct_every
        self._odom = Pose()

    def __call__(self, report: Report) -> Pose:
        thought = Pose(x=report.drive.x, y=report.drive.y, theta=report.drive.theta)
        if report.time >= self._due:
            self._due += self._every
            true = from_start(report.truth, self._start)
            self._odom = true.then(Pose().seen_from(thought))
        return self._odom.then(thought)


class MatchedPose:
    """The pose that navigation tells when maps come to it, as they do while it has a goal."""

    def __init__(self, grid: OccupancyGrid, body: RobotBody | None = None) -> None:
        self._grid = grid
        self._correction = PoseCorrection()
        self._reader = ScanReader(body or magellan_body())
        rules = BeamRules(body or magellan_body(), self._reader.beams)
        self._watch = DriftWatch(self._correction, rules)
        self._due = MAP_PERIOD

    def __call__(self, report: Report) -> Pose:
        drive = report.drive
        self._watch.moved(drive, report.time)
        self._reader.moved(drive, report.time)
        if report.ranges is not None:
            scan = self._reader.read(report.ranges, report.time)
            if scan is not None:
                self._watch.scanned(scan, report.time)
        if report.time >= self._due:
            self._due += MAP_PERIOD
            picture = self._grid.whole()
            grid = Grid(
                cells=picture.cells,
                resolution=picture.resolution,
                origin_x=picture.origin_x,
                origin_y=picture.origin_y,
            )
            here = Pose(x=drive.x, y=drive.y, theta=drive.theta)
            self._watch.mapped(grid, here, report.time)
        return self._correction.pose(drive.x, drive.y, drive.theta)


def true_pose(start: Pose) -> Callable[[Report], Pose]:
    """The pose of a navigation that never errs."""
    return lambda report: from_start(report.truth, start)


def state_of(report: Report, pose: Pose) -> RobotState:
    """What navigation reports with this pose."""
    drive = report.drive
    return RobotState(
        stamp=drive.odometry.header.stamp.seconds,
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        linear=drive.linear,
        angular=drive.angular,
        commanded_linear=0.0,
        commanded_angular=0.0,
        bumpers=0,
        battery_voltage=math.nan,
        battery_fraction=math.nan,
        motion=MotionState.MOVING,
        refused=0,
    )


def mapped(
    reports: Sequence[Report],
    pose: Callable[[Report], Pose],
    grid: OccupancyGrid,
    body: RobotBody | None = None,
) -> OccupancyGrid:
    """The grid after all reports of a tour."""
    reader = ScanReader(body or magellan_body())
    scans = ScanSelector(reader.beams)
    for report in reports:
        reader.moved(state_of(report, pose(report)), report.time)
        scan = report.ranges and reader.read(report.ranges, report.time)
        evidence = scan and scans.evidence(scan)
        if scan is not None and evidence is not None:
            grid.add(scan.pose, evidence)
    return grid


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """How true a map is.

    Attributes:
        precision: Share of the occupied cells that are near to something.
        recall: Share of the surfaces in sight that are near to an occupied cell.
        wall_error: Mean distance of the occupied cells from something [m].
    """

    precision: float
    recall: float
    wall_error: float

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.precision + self.recall
        return 2.0 * self.precision * self.recall / both if both else 0.0


def score(grid: OccupancyGrid, arena: Arena, surfaces: Floats) -> Score:
    """Compare a map with the arena.

    Args:
        grid: The map; the robot started at its origin.
        arena: The truth.
        surfaces: From `surfaces_in_sight`.
    """
    rows, columns = np.nonzero(grid.log_odds >= OCCUPIED)
    cells = np.stack((columns, rows), axis=1) * grid.resolution + grid.low + grid.resolution / 2
    cells = np.stack(arena.start.outward(cells[:, 0], cells[:, 1]), axis=1)
    errors = distances(arena.footprints, *cells.T)
    gaps = np.concatenate(
        [
            np.hypot(*(part[:, None, :] - cells).transpose(2, 0, 1)).min(axis=1)
            for part in np.array_split(surfaces, 1 + len(surfaces) // 500)
        ]
    )
    return Score(
        precision=float((errors <= TOLERANCE).mean()),
        recall=float((gaps <= TOLERANCE).mean()),
        wall_error=float(errors.mean()),
    )


def surfaces_in_sight(reports: Sequence[Report], arena: Arena, *, reach: float = 3.0) -> Floats:
    """Points on all that was in line of sight within the mapped range, every 5 cm, shape (n, 2).

    Also what sensors could not see because it was met at a slant.
    """
    angles = np.linspace(0.0, 2.0 * math.pi, 360, endpoint=False)
    rays = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    found: set[tuple[int, int]] = set()
    for report in reports[::6]:
        origins = np.repeat([[report.truth.x, report.truth.y]], len(rays), axis=0)
        away, _, _ = first_hits(arena.footprints, origins, rays)
        met = away < reach
        points = origins[met] + rays[met] * away[met, None]
        found.update(map(tuple, np.rint(points / 0.05).astype(int).tolist()))
    return np.array(sorted(found), dtype=np.float64).reshape(-1, 2) * 0.05
