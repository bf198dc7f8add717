"""Sonars and infrared sensors on the robot's rim, as rays in the plane."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import SENSOR_COUNT
from hub.pose import Pose
from hub.sim.arena import BODY_RADIUS, Footprints

Floats = npt.NDArray[np.float64]

SONAR_RING = 0.200
"""Radius of the ring of transducers [m], Player config/magellan.cfg."""
SONAR_FARTHEST = 5.1
"""Farthest echo, from the robot's centre [m]: 30 ms at the speed of sound."""
SONAR_CONE = math.radians(27.0)
"""Opening angle of a transducer's beam [rad]."""
SONAR_INCIDENCE = math.radians(25.0)
"""A smooth wall hit at a larger angle than this sends no echo back [rad]."""
SONAR_EDGE_FARTHEST = 1.0
"""Farthest upright edge or inner corner that is heard from any side, from the transducer [m].

Edges diffract: they echo in all directions, but weaker than a flat wall, and less
with the distance (Kuc and Siegel 1987, IEEE PAMI 9).
The limit is our assumption; it keeps to the weak side.
"""
SONAR_NOISE = 0.01
"""Standard deviation of a range, as a share of it."""
INFRARED_NEAREST = 0.10
"""Least range from the rim [m]."""
INFRARED_FARTHEST = 0.80
"""Largest range from the rim, even on a bright surface [m]."""
INFRARED_NOISE = 0.02
"""Standard deviation of a range on a bright surface, as a share of the distance from the rim."""

_RAYS_PER_CONE = 13
_DARKEST = 0.15
"""A surface less bright than this [share] counts as this bright."""
_FULL_BRIGHTNESS = 0.5
"""From this brightness on a surface is seen at the full distance."""
_NO_COMPONENT = 1e-12
_EDGE_CLEARANCE = 0.005
"""Largest distance between a ray's hit and an edge that count as the same [m]."""


class RangeSensors:
    """All range sensors of one robot among the obstacles of one arena."""

    def __init__(self, obstacles: Footprints, seed: np.random.SeedSequence) -> None:
        self._obstacles = obstacles
        sonar_seed, infrared_seed = seed.spawn(2)
        self._sonar_noise = np.random.default_rng(sonar_seed)
        self._infrared_noise = np.random.default_rng(infrared_seed)
        axes: Floats = np.arange(SENSOR_COUNT, dtype=np.float64)
        axes *= 2 * math.pi / SENSOR_COUNT
        within = np.linspace(-SONAR_CONE / 2, SONAR_CONE / 2, _RAYS_PER_CONE)
        self._axes = axes
        self._cone: Floats = (axes[:, None] + within).ravel()
        self._edges = _upright_edges(obstacles)
        # Without noise; a robot that stands casts no rays again.
        self._seen_at: Pose | None = None
        self._echoes: Floats = np.empty(0)
        self._reflections: tuple[Floats, Floats] = (np.empty(0), np.empty(0))

    def sonar(self, pose: Pose) -> npt.NDArray[np.float32]:
        """Range of every sonar from the centre [m], shape (16,); inf where no echo returns.

        The nearest ray of a cone that meets a surface squarely enough makes the echo, or an edge
        that is nearer still.
        """
        noise = self._sonar_noise.standard_normal(SENSOR_COUNT)
        self._look(pose)
        ranges = (self._echoes + SONAR_RING) * (1.0 + SONAR_NOISE * noise)
        return np.where(ranges <= SONAR_FARTHEST, ranges, np.inf).astype(np.float32)

    def _look(self, pose: Pose) -> None:
        """Cast the rays of all sensors, unless they were cast from this pose last time."""
        if pose != self._seen_at:
            self._seen_at = pose
            self._echoes = self._nearest_echoes(pose)
            self._reflections = self._infrared_hits(pose)

    def _nearest_echoes(self, pose: Pose) -> Floats:
        """Distance of the nearest echo of each sonar [m], inf for none, shape (16,)."""
        directions = _unit(self._cone + pose.theta)
        mounts = _unit(self._axes + pose.theta) * SONAR_RING + (pose.x, pose.y)
        origins = mounts.repeat(_RAYS_PER_CONE, axis=0)
        reach = SONAR_FARTHEST - SONAR_RING
        obstacles = _within(self._obstacles, pose, SONAR_FARTHEST)
        distance, squareness, _ = first_hits(obstacles, origins, directions)
        echoes = (squareness >= math.cos(SONAR_INCIDENCE)) & (distance <= reach)
        distance = np.where(echoes, distance, np.inf).reshape(SENSOR_COUNT, -1).min(axis=1)
        nearest: Floats = np.minimum(distance, self._nearest_edges(obstacles, pose))
        return nearest

    def _nearest_edges(self, obstacles: Footprints, pose: Pose) -> Floats:
        """Distance of the nearest edge that each sonar detects [m], inf for none, shape (16,)."""
        nearest = np.full((SENSOR_COUNT,), np.inf)
        reach = SONAR_RING + SONAR_EDGE_FARTHEST
        near = np.hypot(*(self._edges - (pose.x, pose.y)).T) <= reach
        mounts = _unit(self._axes + pose.theta) * SONAR_RING + (pose.x, pose.y)
        ways = self._edges[near] - mounts[:, None]
        away = np.hypot(ways[..., 0], ways[..., 1])
        off = np.arctan2(ways[..., 1], ways[..., 0]) - self._axes[:, None] - pose.theta
        heard = (away <= SONAR_EDGE_FARTHEST) & (np.cos(off) >= math.cos(SONAR_CONE / 2))
        sonar, edge = np.nonzero(heard & (away > 0.0))
        if len(sonar):
            length = away[sonar, edge]
            before, _, _ = first_hits(obstacles, mounts[sonar], ways[sonar, edge] / length[:, None])
            clear = before >= length - _EDGE_CLEARANCE
            np.minimum.at(nearest, sonar[clear], length[clear])
        return nearest

    def infrared(self, pose: Pose) -> npt.NDArray[np.float32]:
        """Range of every infrared sensor from the centre [m], shape (16,); inf: nothing seen.

        Dark surfaces send little light back: they are seen less far and less exactly.
        """
        noise = self._infrared_noise.standard_normal(SENSOR_COUNT)
        self._look(pose)
        distance, strength = self._reflections
        seen = distance <= INFRARED_FARTHEST * strength
        measured = np.where(seen, distance, 0.0) * (1.0 + INFRARED_NOISE / strength * noise)
        measured = np.clip(measured, INFRARED_NEAREST, INFRARED_FARTHEST)
        return np.where(seen, measured + BODY_RADIUS, np.inf).astype(np.float32)

    def _infrared_hits(self, pose: Pose) -> tuple[Floats, Floats]:
        """Distance of the surface before each infrared sensor [m], and how well it reflects."""
        directions = _unit(self._axes + pose.theta)
        origins = directions * BODY_RADIUS + (pose.x, pose.y)
        obstacles = _within(self._obstacles, pose, BODY_RADIUS + INFRARED_FARTHEST)
        distance, _, number = first_hits(obstacles, origins, directions)
        brightness = np.append(obstacles.brightness, 1.0)[number]
        strength = np.sqrt(np.clip(brightness, _DARKEST, _FULL_BRIGHTNESS) / _FULL_BRIGHTNESS)
        return distance, strength


def first_hits(
    obstacles: Footprints, origins: Floats, directions: Floats
) -> tuple[Floats, Floats, npt.NDArray[np.intp]]:
    """The first hits of rays in the plane.

    Args:
        obstacles: The obstacles.
        origins: Where the rays begin, outside of all obstacles [m], shape (n, 2).
        directions: Unit vectors, shape (n, 2).

    Returns:
        Distance to the first hit [m], inf for none; cosine of the angle between the ray and the
        surface's normal there; number of the obstacle, -1 for none; each of shape (n,).
    """
    count = len(directions)
    distance = np.full((count,), np.inf)
    squareness = np.zeros(count)
    number = np.full((count,), -1, dtype=np.intp)
    rays = np.arange(count)
    if len(obstacles.low):
        hits, cosines = _box_hits(obstacles, origins, directions)
        number = hits.argmin(axis=0)
        distance, squareness = hits[number, rays], cosines[number, rays]
        number = np.where(np.isfinite(distance), number, -1)
    if len(obstacles.radius):
        hits, cosines = _cylinder_hits(obstacles, origins, directions)
        nearest = hits.argmin(axis=0)
        nearer = hits[nearest, rays] < distance
        distance = np.where(nearer, hits[nearest, rays], distance)
        squareness = np.where(nearer, cosines[nearest, rays], squareness)
        number = np.where(nearer, nearest + len(obstacles.low), number)
    return distance, squareness, number


def _box_hits(obstacles: Footprints, origins: Floats, directions: Floats) -> tuple[Floats, Floats]:
    """Distance (inf: none) and cosine of the incidence, both of shape (boxes, rays).

    Slab method (Kay and Kajiya 1986).
    """
    x_in, x_out = _slab(obstacles.low[:, :1], obstacles.high[:, :1], origins, directions, 0)
    y_in, y_out = _slab(obstacles.low[:, 1:], obstacles.high[:, 1:], origins, directions, 1)
    enter = np.maximum(x_in, y_in)
    met = (enter <= np.minimum(x_out, y_out)) & (enter >= 0.0)
    cosines = np.where(x_in > y_in, np.abs(directions[:, 0]), np.abs(directions[:, 1]))
    return np.where(met, enter, np.inf), cosines


def _slab(
    low: Floats, high: Floats, origins: Floats, directions: Floats, axis: int
) -> tuple[Floats, Floats]:
    """Where rays enter and leave the space between two planes, each of shape (boxes, rays)."""
    component = directions[:, axis]
    component = np.where(np.abs(component) < _NO_COMPONENT, _NO_COMPONENT, component)
    inverse = 1.0 / component
    first = (low - origins[:, axis]) * inverse
    second = (high - origins[:, axis]) * inverse
    return np.minimum(first, second), np.maximum(first, second)


def _cylinder_hits(
    obstacles: Footprints, origins: Floats, directions: Floats
) -> tuple[Floats, Floats]:
    """Distance (inf: none) and cosine of the incidence, both of shape (cylinders, rays)."""
    to_x = obstacles.centre[:, :1] - origins[:, 0]
    to_y = obstacles.centre[:, 1:] - origins[:, 1]
    along = to_x * directions[:, 0] + to_y * directions[:, 1]
    passing = to_x * directions[:, 1] - to_y * directions[:, 0]
    radius = obstacles.radius[:, None]
    under = radius * radius - passing * passing
    depth = np.sqrt(np.maximum(under, 0.0))
    hit = along - depth
    return np.where((under >= 0.0) & (hit >= 0.0), hit, np.inf), depth / radius


def _upright_edges(obstacles: Footprints) -> Floats:
    """Positions of the upright edges of all boxes [m], shape (n, 2)."""
    low, high = obstacles.low, obstacles.high
    across = np.stack((low[:, 0], high[:, 0], low[:, 0], high[:, 0]), axis=1)
    along = np.stack((low[:, 1], low[:, 1], high[:, 1], high[:, 1]), axis=1)
    return np.stack((across.ravel(), along.ravel()), axis=1)


def _unit(angles: Floats) -> Floats:
    """Unit vectors, shape (n, 2)."""
    return np.stack((np.cos(angles), np.sin(angles)), axis=1)


def _within(obstacles: Footprints, pose: Pose, reach: float) -> Footprints:
    """The obstacles that are near enough to matter."""
    near = obstacles.distances(pose.x, pose.y) <= reach
    boxes, cylinders = near[: len(obstacles.low)], near[len(obstacles.low) :]
    return Footprints(
        low=obstacles.low[boxes],
        high=obstacles.high[boxes],
        centre=obstacles.centre[cylinders],
        radius=obstacles.radius[cylinders],
        brightness=obstacles.brightness[near],
        origin=(),
    )
