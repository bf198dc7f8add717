"""Sonars, infrared sensors and lasers as rays, wherever a body has them.

Rays are in the plane. Those of light are in space where the arena's solids are given with their
heights.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hub.gcm.beams import Beams
from hub.gcm.body import RangeKind
from hub.pose import Pose
from hub.sim.arena import Footprints
from hub.sim.ground.beams import ground_echoes
from hub.sim.ground.height_field import HeightField
from hub.sim.plane_rays import NO_COMPONENT, first_hits
from hub.sim.solids import Solids
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass

Floats = npt.NDArray[np.float64]

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
INFRARED_NOISE = 0.02
"""Standard deviation of a range on a bright surface, as a share of the distance from the rim."""

LASER_NOISE = 0.01
"""Standard deviation of a near range [m]; our assumption, after small indoor scanners."""
LASER_NOISE_SHARE = 0.002
"""What each metre of a range adds to it."""

_RAYS_PER_CONE = 13
_AHEAD = np.zeros(1)
_DARKEST = 0.15
"""A surface less bright than this [share] counts as this bright."""
_FULL_BRIGHTNESS = 0.5
"""From this brightness on a surface is seen at the full distance."""
_EDGE_CLEARANCE = 0.005
"""Largest distance between a ray's hit and an edge that count as the same [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Group:
    """The sensors of one group in `base_link`, each array of shape (n,).

    Attributes:
        x: Origin of the ranges [m].
        y: Origin of the ranges [m].
        z: Origin of the ranges [m].
        bearing: Direction [rad].
        elevation: Angle above the xy-plane [rad].
        opening: Whole angle of a cone [rad].
        ring: Distance of the sensors from the origin of their ranges [m].
        nearest: Least range [m].
        farthest: Largest range [m].
    """

    x: Floats
    y: Floats
    z: Floats
    bearing: Floats
    elevation: Floats
    opening: float
    ring: float
    nearest: float
    farthest: float

    def placed(self, pose: Pose) -> tuple[Floats, Floats, Floats]:
        """Directions [rad], their unit vectors, and places of the sensors [m] at a pose."""
        bearing = self.bearing + pose.theta
        towards = _unit(bearing)
        x, y = pose.outward(self.x, self.y)
        return bearing, towards, towards * self.ring + np.stack((x, y), axis=1)

    def leaning(self, lean: SpatialPose, aside: Floats = _AHEAD) -> tuple[Floats, Floats]:
        """Places of the sensors [m] and rays of each at a pose in space.

        Args:
            lean: The pose.
            aside: Angle of each ray of a sensor from its axis [rad], shape (m,), m odd.

        Returns:
            Each of shape (n m, 3).
        """
        rotation, level = lean.rotation(), np.cos(self.elevation).repeat(len(aside))
        bearing = (self.bearing[:, None] + aside).ravel()
        rise = np.sin(self.elevation).repeat(len(aside))
        rays = rotation @ (np.cos(bearing) * level, np.sin(bearing) * level, rise)
        mounts = rotation @ (self.x, self.y, self.z)
        mounts += rays[:, len(aside) // 2 :: len(aside)] * self.ring
        places = mounts.T + np.array((lean.x, lean.y, lean.z))
        return places.repeat(len(aside), axis=0), rays.T

    def reach(self) -> float:
        """The farthest point that a sensor can meet, from the robot's centre [m]."""
        return self.farthest + float(np.hypot(self.x, self.y).max(initial=0.0))


class _Sensors(Protocol):
    """The sensors of one group."""

    def look(self, obstacles: Footprints, pose: Pose) -> tuple[Floats, ...]:
        """What they meet from a pose, without noise; the obstacles are those within reach."""

    def ranges(self, met: tuple[Floats, ...]) -> Floats:
        """One measurement: range of each from its origin [m], shape (n,); inf: nothing there."""


class RangeSensors:
    """All range sensors of one robot among the obstacles of one arena."""

    def __init__(
        self,
        obstacles: Footprints,
        beams: Beams,
        seed: np.random.SeedSequence,
        ground: HeightField | None = None,
        solids: Solids | None = None,
    ) -> None:
        """Take the sensors that a body has.

        Args:
            obstacles: All obstacles of the arena.
            beams: The body's beams; for obstacles their elevations count as 0.
            seed: Of the noise.
            ground: The height map of rough ground; None: the floor is level.
            solids: The same obstacles in space, for beams of light; None: these are in the plane.
        """
        self._obstacles = obstacles
        self._solids = solids
        self._ground = ground
        edges = _upright_edges(obstacles)
        self._groups: dict[str, tuple[_Group, _Sensors]] = {}
        seeds = seed.spawn(len(beams.groups))
        for (name, place), own in zip(beams.groups.items(), seeds, strict=True):
            group = _Group(
                x=beams.x[place],
                y=beams.y[place],
                z=beams.z[place],
                bearing=beams.bearing[place],
                elevation=beams.elevation[place],
                opening=float(beams.opening[place][0]),
                ring=float(beams.ring[place][0]),
                nearest=float(beams.nearest[place][0]),
                farthest=float(beams.farthest[place][0]),
            )
            noise = np.random.default_rng(own)
            kind = RangeKind(int(beams.kind[place][0]))
            sensors: _Sensors
            if kind is RangeKind.INFRARED:
                sensors = _InfraredSensors(group, noise)
            elif kind is RangeKind.LASER:
                sensors = _Laser(group, noise)
            else:
                sensors = _Sonars(group, noise, edges)
            self._groups[name] = group, sensors
        self._met: dict[str, tuple[tuple[Pose, SpatialPose | None], tuple[Floats, ...]]] = {}

    def measure(
        self, name: str, pose: Pose, lean: SpatialPose | None = None
    ) -> npt.NDArray[np.float32]:
        """Range of each sensor of a group from its origin [m], shape (n,); inf: nothing there.

        A robot that stands casts no rays again.

        Args:
            name: The group.
            pose: The robot's pose, seen from above.
            lean: The same in space, from which the sensors meet the ground; None: they do not.
        """
        group, sensors = self._groups[name]
        known = self._met.get(name)
        if known is None or known[0] != (pose, lean):
            if self._solids is not None and isinstance(sensors, _InfraredSensors | _Laser):
                met = self._look_in_space(self._solids, group, sensors, lean or _level(pose))
            else:
                met = sensors.look(_within(self._obstacles, pose, group.reach()), pose)
            if lean is not None and self._ground is not None:
                met = np.minimum(met[0], self._to_ground(name, self._ground, lean)), *met[1:]
            known = self._met[name] = (pose, lean), met
        ranges = sensors.ranges(known[1]).astype(np.float32)
        ranges.flags.writeable = False  # many read it
        return ranges

    def _look_in_space(
        self,
        solids: Solids,
        group: _Group,
        sensors: _InfraredSensors | _Laser,
        lean: SpatialPose,
    ) -> tuple[Floats, ...]:
        """What beams of light meet from a pose in space, except a height map."""
        origins, rays = group.leaning(lean)
        heights = np.concatenate((origins[:, 2], origins[:, 2] + group.farthest * rays[:, 2]))
        span = float(heights.min()), float(heights.max())
        solids = solids.around(lean.x, lean.y, group.reach(), *span)
        distance, number = solids.hits(origins, rays)
        brightness = np.append(solids.brightness, 1.0)[number]
        if self._ground is None:
            fall = np.maximum(-rays[:, 2], NO_COMPONENT)
            distance = np.minimum(distance, np.maximum(origins[:, 2], 0.0) / fall)
        return sensors.meet(distance, brightness)

    def _to_ground(self, name: str, ground: HeightField, lean: SpatialPose) -> Floats:
        """Distance of the ground before each sensor of a group [m], inf for none.

        A sonar measures the nearest part of its cone that sends sound back.
        """
        group, sensors = self._groups[name]
        is_sonar = isinstance(sensors, _Sonars)
        opening = group.opening / 2 if is_sonar else 0.0
        aside = np.linspace(-opening, opening, _RAYS_PER_CONE if is_sonar else 1)
        distance = ground_echoes(
            ground,
            *group.leaning(lean, aside),
            group.farthest - group.ring,
            SONAR_INCIDENCE if is_sonar else math.pi / 2,
        )
        nearest: Floats = distance.reshape(-1, len(aside)).min(axis=1)
        return nearest


class _Sonars:
    """Sonars: the nearest ray of a cone that meets a surface squarely makes the echo.

    An edge that is nearer still makes it instead.
    """

    def __init__(self, group: _Group, noise: np.random.Generator, edges: Floats) -> None:
        self._group = group
        self._noise = noise
        self._edges = edges
        within = np.linspace(-group.opening / 2, group.opening / 2, _RAYS_PER_CONE)
        self._cone: Floats = (group.bearing[:, None] + within).ravel()

    def look(self, obstacles: Footprints, pose: Pose) -> tuple[Floats, ...]:
        """Distance of the nearest echo of each sonar [m], inf for none."""
        group = self._group
        bearing, _, mounts = group.placed(pose)
        origins = mounts.repeat(_RAYS_PER_CONE, axis=0)
        distance, squareness, _ = first_hits(obstacles, origins, _unit(self._cone + pose.theta))
        reach = group.farthest - group.ring
        echoes = (squareness >= math.cos(SONAR_INCIDENCE)) & (distance <= reach)
        distance = np.where(echoes, distance, np.inf).reshape(-1, _RAYS_PER_CONE).min(axis=1)
        return (np.minimum(distance, self._nearest_edges(obstacles, pose, bearing, mounts)),)

    def ranges(self, met: tuple[Floats, ...]) -> Floats:
        """One measurement."""
        group, (distance,) = self._group, met
        noise = self._noise.standard_normal(len(group.bearing))
        ranges = np.maximum((distance + group.ring) * (1.0 + SONAR_NOISE * noise), group.nearest)
        return np.where(ranges <= group.farthest, ranges, np.inf)

    def _nearest_edges(
        self, obstacles: Footprints, pose: Pose, bearing: Floats, mounts: Floats
    ) -> Floats:
        """Distance of the nearest edge that each sonar detects [m], inf for none, shape (n,)."""
        nearest = np.full(len(bearing), np.inf)
        reach = self._group.reach() - self._group.farthest + self._group.ring + SONAR_EDGE_FARTHEST
        near = np.hypot(*(self._edges - (pose.x, pose.y)).T) <= reach
        ways = self._edges[near] - mounts[:, None]
        away = np.hypot(ways[..., 0], ways[..., 1])
        off = np.arctan2(ways[..., 1], ways[..., 0]) - bearing[:, None]
        heard = (away <= SONAR_EDGE_FARTHEST) & (np.cos(off) >= math.cos(self._group.opening / 2))
        sonar, edge = np.nonzero(heard & (away > 0.0))
        if len(sonar):
            length = away[sonar, edge]
            before, _, _ = first_hits(obstacles, mounts[sonar], ways[sonar, edge] / length[:, None])
            clear = before >= length - _EDGE_CLEARANCE
            np.minimum.at(nearest, sonar[clear], length[clear])
        return nearest


class _InfraredSensors:
    """Infrared sensors: dark surfaces are seen less far and less exactly."""

    def __init__(self, group: _Group, noise: np.random.Generator) -> None:
        self._group = group
        self._noise = noise

    def look(self, obstacles: Footprints, pose: Pose) -> tuple[Floats, ...]:
        """Distance of the surface before each sensor [m], and how well it reflects."""
        _, towards, mounts = self._group.placed(pose)
        distance, _, number = first_hits(obstacles, mounts, towards)
        return self.meet(distance, np.append(obstacles.brightness, 1.0)[number])

    def meet(self, distance: Floats, brightness: Floats) -> tuple[Floats, ...]:
        """What they meet, from its distance [m] and brightness, shape (n,) each."""
        strength = np.sqrt(np.clip(brightness, _DARKEST, _FULL_BRIGHTNESS) / _FULL_BRIGHTNESS)
        return distance, strength

    def ranges(self, met: tuple[Floats, ...]) -> Floats:
        """One measurement."""
        group, (distance, strength) = self._group, met
        noise = self._noise.standard_normal(len(group.bearing))
        seen = distance <= (group.farthest - group.ring) * strength
        measured = np.where(seen, distance, 0.0) * (1.0 + INFRARED_NOISE / strength * noise)
        ranges = np.clip(measured + group.ring, group.nearest, group.farthest)
        return np.where(seen, ranges, np.inf)


class _Laser:
    """A laser scanner: narrow beams, and an error that grows little with the range."""

    def __init__(self, group: _Group, noise: np.random.Generator) -> None:
        self._group = group
        self._noise = noise

    def look(self, obstacles: Footprints, pose: Pose) -> tuple[Floats, ...]:
        """Distance of the surface before each beam [m], inf for none."""
        _, towards, mounts = self._group.placed(pose)
        distance, _, _ = first_hits(obstacles, mounts, towards)
        return (distance,)

    def meet(self, distance: Floats, _brightness: Floats) -> tuple[Floats, ...]:
        """What they meet, from its distance [m] and brightness, shape (n,) each."""
        return (distance,)

    def ranges(self, met: tuple[Floats, ...]) -> Floats:
        """One measurement."""
        group, (distance,) = self._group, met
        noise = self._noise.standard_normal(len(group.bearing))
        ranges = distance + group.ring
        error = (
            LASER_NOISE + LASER_NOISE_SHARE * np.where(np.isfinite(ranges), ranges, 0.0)
        ) * noise
        within = (ranges >= group.nearest) & (ranges <= group.farthest)
        return np.where(within, np.maximum(ranges + error, group.nearest), np.inf)


def _upright_edges(obstacles: Footprints) -> Floats:
    """Positions of the upright edges of all boxes [m], shape (n, 2)."""
    low, high = obstacles.low, obstacles.high
    across = np.stack((low[:, 0], high[:, 0], low[:, 0], high[:, 0]), axis=1)
    along = np.stack((low[:, 1], low[:, 1], high[:, 1], high[:, 1]), axis=1)
    return np.stack((across.ravel(), along.ravel()), axis=1)


def _level(pose: Pose) -> SpatialPose:
    """The pose of a body that stands level on the floor."""
    return SpatialPose(x=pose.x, y=pose.y, yaw=pose.theta)


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
