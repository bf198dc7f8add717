"""The drift of dead reckoning, from a match of recent points with the map; pure.

Correlative scan matching (E. Olson, Real-Time Correlative Scan Matching, 2009). It tries small
turns and shifts of the points. The likelihood of each is the fit of the points to the map's walls,
times the likelihood of such an error of dead reckoning. The mean of all is the correction; their
spread is its uncertainty.

The mean is used because sensors with wide cones measure a heading badly: the most likely value
alone would jump. A part that dead reckoning knows well stays, such as the heading on a straight
line. The whole pose stays where the points fit nowhere.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import numpy.typing as npt

from hub.gcm.beam_scans import BeamScan
from hub.grids.clearance import clearance
from hub.grids.grid import Grid
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.pose_uncertainty import Spread
from hub.pose import Pose
from hub.values import dataclass

FEWEST = 40
"""Least number of points on known ground."""
FARTHEST = 1e6
"""Poses farther from the origin than this are not valid [m]."""

_MOST = 300
_NEAR_WALL = 0.09
"""Standard deviation of points and walls of the map [m]."""
_CAP = 0.25
"""All points farther from all walls than this fit equally badly [m]."""
_ON_UNKNOWN = 0.2
"""The fit of a point on unknown ground."""
_EVIDENCE = 100.0
"""Weight of a fit of all points [log-likelihood]; small, because their errors correlate."""
_REACH = 2.5
"""The search covers this number of standard deviations."""
_TURNS = np.linspace(-_REACH, _REACH, 11)
_SHIFT_Y, _SHIFT_X = (
    part.ravel() for part in np.meshgrid(*[np.linspace(-_REACH, _REACH, 9)] * 2, indexing="ij")
)

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Match:
    """A correction of the pose.

    Attributes:
        moved: From the assumed pose to the real one: a shift in `map` [m] and a turn about the
            robot [rad].
        spread: Its uncertainty.
    """

    moved: Pose
    spread: Spread


def drift(grid: Grid, x: Floats, y: Floats, robot: Pose, before: Spread) -> Match | None:
    """The correction that lays the points onto the walls of a map.

    Args:
        grid: The map; the points must not be part of it.
        x: Points in `map`, by dead reckoning [m], shape (n,).
        y: The same [m].
        robot: The pose around which they turn, in `map`.
        before: The uncertainty of the pose.

    Returns:
        None: the map shows no correction, or the pose or its spread is not finite.
    """
    observed = (robot.x, robot.y, robot.theta, before.turn, before.way)
    if not all(abs(each) < FARTHEST for each in observed):
        return None
    near = (np.abs(x) < FARTHEST) & (np.abs(y) < FARTHEST)  # false for NaN
    x, y = x[near], y[near]
    fits = _fits(grid)
    rows, columns = _cells(grid, x, y)
    if np.count_nonzero(fits[rows, columns] != _ON_UNKNOWN) < FEWEST:
        return None
    if len(x) > _MOST:
        picked = np.linspace(0, len(x) - 1, _MOST).astype(np.intp)
        x, y = x[picked], y[picked]
    turns = _TURNS * before.turn
    shift_x, shift_y = _SHIFT_X * before.way, _SHIFT_Y * before.way
    fit = np.empty((len(turns), len(shift_x)))
    along, aside = x - robot.x, y - robot.y
    for index, turn in enumerate(turns.tolist()):
        turned_x, turned_y = Pose(x=robot.x, y=robot.y, theta=turn).outward(along, aside)
        rows, columns = _cells(grid, turned_x + shift_x[:, None], turned_y + shift_y[:, None])
        fit[index] = fits[rows, columns].mean(axis=1)
    unlikely = 0.5 * (np.square(_TURNS)[:, None] + np.square(_SHIFT_X) + np.square(_SHIFT_Y))
    likely = _EVIDENCE * len(x) / _MOST * fit - unlikely
    likely = np.exp(likely - likely.max())
    likely /= likely.sum()
    return _mean(likely, turns, shift_x, shift_y)


def _mean(likely: Floats, turns: Floats, shift_x: Floats, shift_y: Floats) -> Match:
    """Mean and spread of the search, shape of `likely` (turns, shifts)."""
    of_turns, of_shifts = likely.sum(axis=1), likely.sum(axis=0)
    turn = float(of_turns @ turns)
    x, y = float(of_shifts @ shift_x), float(of_shifts @ shift_y)
    way = of_shifts @ (np.square(shift_x - x) + np.square(shift_y - y)) / 2.0
    return Match(
        moved=Pose(x=x, y=y, theta=turn),
        spread=Spread(
            turn=math.sqrt(of_turns @ np.square(turns - turn)),
            way=math.sqrt(way),
        ),
    )


def _fits(grid: Grid) -> Floats:
    """How well a point in each cell fits a wall, 0 to 1, with a frame of unknown cells."""
    away = clearance(np.pad(grid.occupied, 1), grid.resolution, _CAP)
    fits: Floats = np.exp(-0.5 * np.square(away / _NEAR_WALL)).astype(np.float64)
    unknown = np.pad(grid.unknown, 1, constant_values=True)
    fits[unknown] = np.maximum(fits[unknown], _ON_UNKNOWN)
    return fits


def _cells(grid: Grid, x: Floats, y: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Rows and columns in the framed map; points outside go into the frame."""
    rows = np.floor((y - grid.origin_y) / grid.resolution) + 1.0
    columns = np.floor((x - grid.origin_x) / grid.resolution) + 1.0
    rows = np.clip(rows, 0.0, grid.height_cells + 1.0)
    columns = np.clip(columns, 0.0, grid.width_cells + 1.0)
    return rows.astype(np.intp), columns.astype(np.intp)


class Sightings:
    """Collects the points that range sensors measure, in `odom`."""

    LONGEST_ARC = 1.42
    """Echoes on a longer arc of their cone are not used [m]."""
    KEPT_S = 4.0
    """Older points are dropped [s]: dead reckoning has drifted since."""

    def __init__(self, rules: BeamRules) -> None:
        self._rules = rules
        self._scans: deque[tuple[float, Floats, Floats]] = deque()

    def scanned(self, scan: BeamScan, now: float) -> None:
        """Take new ranges."""
        while self._scans and self._scans[0][0] < now - self.KEPT_S:
            self._scans.popleft()
        rules, beams = self._rules, self._rules.beams
        used = np.flatnonzero(scan.fresh & np.isfinite(scan.ranges) & (scan.ranges > rules.blind))
        arcs = scan.ranges[used] * np.where(rules.narrow, 0.0, beams.opening)[used]
        used = used[arcs < self.LONGEST_ARC]
        if len(used):
            used = used[:: 1 + len(used) // _MOST]
            self._scans.append((now, *scan.pose.outward(*beams.hits(used, scan.ranges))))

    def since(self, start: float) -> tuple[Floats, Floats]:
        """The points measured after that time [s] that are still kept [m], shapes (n,)."""
        scans = [(x, y) for at, x, y in self._scans if at > start]
        if not scans:
            return np.empty(0), np.empty(0)
        return np.concatenate([x for x, _ in scans]), np.concatenate([y for _, y in scans])
