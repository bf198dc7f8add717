"""Draws a height map into a camera's frame, with no loop over pixels.

A row of samples runs outward for each of many azimuths. The elevation of the ground at a sample
grows to its running maximum, the horizon. For every azimuth and elevation, a histogram of these
maxima, summed up, gives the first sample that reaches so high; a pixel looks up its own.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.camera.faces import GROUND_SIDES
from hub.sim.camera.ground_light import ground_light
from hub.sim.camera.view import CameraFrame, View
from hub.sim.ground.height_field import HeightField

_NEAREST = 0.04
"""Distance of the first sample [m]."""
_FARTHEST = 15.0
"""Distance of the last sample [m]; beyond, the ground looks like the floor."""
_CELLS_A_SAMPLE = 0.6
_GROWTH = 0.014
"""Distance to the next sample: a share of a cell, or this share of the way so far."""
_MORE_AZIMUTHS = 96
_MORE_ELEVATIONS = 80
"""Azimuths: columns of the picture and these more; elevations: two a row, and these more."""
_MOST_AZIMUTHS = 2.5
"""Most azimuths, as a multiple: a camera that looks down sees all around, and not far."""
_SIDE_HEIGHT = 0.02
"""Least step between two samples that is drawn as a side [m]; smaller ones are a slope."""
_STEEPEST = 0.8
"""Steepest slope that is drawn as one: with distance, samples are apart by more than a cell."""
_BEYOND = 1.02
_IN_PLANE = 0.9999

_Floats = npt.NDArray[np.float32]
_Integers = npt.NDArray[np.int32]


class TerrainView:
    """Draws one height map."""

    def __init__(self, ground: HeightField, first_thing: int) -> None:
        """Prepare it.

        Args:
            ground: The height map.
            first_thing: Number of the thing for tops of the first surface, see `faces.Faces`.
        """
        # Samples beyond the map fall on the cells around it, which have no height.
        padded = np.pad(ground.heights, 1)
        self._columns = padded.shape[1]
        self._rows = padded.shape[0]
        self._height = np.ascontiguousarray(padded, dtype=np.float32).ravel()
        self._top = float(padded.max())
        appearance = np.pad(ground.appearance, 1).ravel().astype(np.int32)
        # Level cells with the floor's own surface are left to the floor.
        self._drawn = (self._height > 0.0) | (appearance > 0)
        self._top_thing = first_thing + GROUND_SIDES * appearance
        self._per_metre = np.float32(1.0 / ground.cell)
        self._origin = (ground.origin[0] - ground.cell, ground.origin[1] - ground.cell)
        distances = []
        distance = _NEAREST
        while distance < _FARTHEST:
            distances.append(distance)
            distance += max(_CELLS_A_SAMPLE * ground.cell, _GROWTH * distance)
        self._distance = np.array(distances, dtype=np.float32)
        self.light = np.pad(
            ground_light(ground.heights, ground.cell), 1, constant_values=1.0
        ).ravel()
        """Share of light that each cell gets, shape (cells,)."""

    def draw(self, view: View, frame: CameraFrame) -> None:
        """Draw the ground where it is nearer than what the frame shows."""
        level = np.hypot(frame.ray_x, frame.ray_y)
        sight = _Sight(frame, level)
        distance = self._distances_in(sight, view.z)
        sight.divide(frame, distance.size / self._distance.size)
        cells, first = self._first_reached(view, sight, distance)
        count = len(distance)
        azimuth, elevation = sight.bins()
        at = first.take(azimuth * (sight.elevations + 1) + elevation)
        seen = at < count
        np.minimum(at, count - 1, out=at)
        azimuth *= count
        azimuth += at
        cell = cells.take(azimuth)
        height = self._height.take(cell)
        seen &= self._drawn.take(cell)
        azimuth -= at > 0
        before = cells.take(azimuth)
        near = distance.take(np.maximum(at - 1, 0))
        far = distance.take(at)
        ray_z = frame.ray_z.astype(np.float32, copy=False)
        with np.errstate(divide="ignore", invalid="ignore"):
            way: _Floats = (height - np.float32(view.z)) * level / ray_z
        beside = ~((way >= near) & (way <= far * np.float32(_BEYOND)))
        # Where a slope is made of small steps, the top's plane may be met a little beside.
        np.clip(way, near, far, out=way, where=beside)
        rise = height - self._height.take(before)
        beside &= rise > np.maximum((far - near) * np.float32(_STEEPEST), _SIDE_HEIGHT)
        beside &= seen
        things = self._top_thing.take(cell)
        sides = np.flatnonzero(beside)
        if len(sides):
            ways, kinds = self._sides(view, frame, level, sides, cell, before)
            way.ravel()[sides] = np.clip(ways, near.ravel()[sides], far.ravel()[sides])
            things.ravel()[sides] += kinds
        inverse = np.divide(level, way, out=way)
        # A level cell with a surface of its own lies in the plane of the floor.
        seen &= inverse > frame.inverse_depth * np.float32(_IN_PLANE)
        np.copyto(frame.inverse_depth, inverse, where=seen)
        np.copyto(frame.thing, things, where=seen)
        frame.cell = cell

    def _sides(
        self,
        view: View,
        frame: CameraFrame,
        level: _Floats,
        pixels: npt.NDArray[np.intp],
        cell: _Integers,
        before: _Integers,
    ) -> tuple[_Floats, _Integers]:
        """Where the sides of cells are met.

        Args:
            view: The camera.
            frame: Its frame.
            level: Length of each ray seen from above, shape (height, width).
            pixels: Those that show a side, n numbers.
            cell: Cell of each pixel, shape (height, width).
            before: Cell of the sample before, shape (height, width).

        Returns:
            The way to each side [m], and 1 for a side that faces x, 2 for one that faces y, n each.
        """
        level = level.ravel()[pixels]
        row, column = np.divmod(cell.ravel()[pixels], self._columns)
        row_before = before.ravel()[pixels] // self._columns
        # A side faces x where the step is met on the way along x; else it faces y.
        corner = self._height.take(row_before * self._columns + column)
        facing_y = self._height.take(row * self._columns + column) - corner > _SIDE_HEIGHT
        with np.errstate(divide="ignore", invalid="ignore"):
            ways = [
                ((number + (rays < 0.0)) / self._per_metre - np.float32(eye - origin))
                * level
                / rays
                for number, rays, eye, origin in (
                    (column, frame.ray_x.ravel()[pixels], view.x, self._origin[0]),
                    (row, frame.ray_y.ravel()[pixels], view.y, self._origin[1]),
                )
            ]
        return np.where(facing_y, ways[1], ways[0]), 1 + facing_y

    def _distances_in(self, sight: _Sight, eye_z: float) -> _Floats:
        """The samples at which the rays can meet ground of any height."""
        first, end = 0, len(self._distance)
        if sight.highest < 0.0:
            end = int(np.searchsorted(self._distance, _way_to(sight.highest, eye_z))) + 2
        if sight.lowest < 0.0 and eye_z > self._top:
            nearest = _way_to(sight.lowest, eye_z - self._top)
            first = max(0, int(np.searchsorted(self._distance, nearest)) - 2)
        return self._distance[min(first, len(self._distance) - 2) : end]

    def _first_reached(
        self, view: View, sight: _Sight, distance: _Floats
    ) -> tuple[_Integers, _Integers]:
        """What each azimuth meets.

        Returns:
            The cell of each sample, shape (azimuths, samples); the first sample that reaches each
            elevation, shape (azimuths, elevations + 1).
        """
        angle = sight.angles()
        outward = distance * self._per_metre
        column, cells = (
            (direction[:, None] * outward + np.float32((eye - origin) * self._per_metre)).astype(
                np.int32
            )
            for direction, eye, origin in (
                (np.cos(angle), view.x, self._origin[0]),
                (np.sin(angle), view.y, self._origin[1]),
            )
        )
        np.clip(column, 0, self._columns - 1, out=column)
        np.clip(cells, 0, self._rows - 1, out=cells)
        cells *= self._columns
        cells += column
        rise = self._height.take(cells)
        rise -= np.float32(view.z)
        reached = rise / (np.abs(rise) + distance)
        np.maximum.accumulate(reached, axis=1, out=reached)
        reached -= np.float32(sight.lowest)
        reached *= np.float32(1.0 / sight.elevation_step)
        # A sample reaches the elevations whose middle it reaches.
        reached += np.float32(0.5)
        bins = np.clip(reached, 0.0, sight.elevations, out=reached).astype(np.int32)
        width = sight.elevations + 1
        bins += (np.arange(sight.azimuths, dtype=np.int32) * width)[:, None]
        counts = np.bincount(bins.ravel(), minlength=sight.azimuths * width)
        return cells, counts.reshape(sight.azimuths, width).cumsum(axis=1, dtype=np.int32)


def _way_to(elevation: float, depth: float) -> float:
    """Way at which a ray of this elevation, below 0, is so deep below its start [m]."""
    return depth * (1.0 / -elevation - 1.0)


class _Sight:
    """Azimuths and elevations of a frame's pixels, in bins of equal size.

    Elevations are rise / (|rise| + way), which lies between -1 and 1.

    Attributes:
        azimuths: Number of azimuths.
        elevations: Number of elevations.
        lowest: Least elevation.
        highest: Greatest elevation.
        elevation_step: Difference from one elevation to the next.
    """

    def __init__(self, frame: CameraFrame, level: _Floats) -> None:
        self._middle = math.atan2(float(frame.ray_y.mean()), float(frame.ray_x.mean()))
        cos, sin = np.float32(math.cos(self._middle)), np.float32(math.sin(self._middle))
        self._azimuth = np.arctan2(
            cos * frame.ray_y - sin * frame.ray_x, cos * frame.ray_x + sin * frame.ray_y
        )
        ray_z = frame.ray_z.astype(np.float32, copy=False)
        self._elevation = ray_z / (level + np.abs(ray_z))
        self._first, self._last = float(self._azimuth.min()), float(self._azimuth.max())
        self.lowest, self.highest = float(self._elevation.min()), float(self._elevation.max())
        self.divide(frame, 1.0)

    def divide(self, frame: CameraFrame, share_of_samples: float) -> None:
        """Make the bins, more for azimuths that need less than all samples."""
        more = min(1.0 / share_of_samples, _MOST_AZIMUTHS)
        self.azimuths = int((frame.width + _MORE_AZIMUTHS) * more)
        self.elevations = 2 * frame.height + _MORE_ELEVATIONS
        self._step = (self._last - self._first) / self.azimuths + 1e-9
        self.elevation_step = (self.highest - self.lowest) / self.elevations + 1e-9

    def angles(self) -> _Floats:
        """Direction of each azimuth's middle from x [rad], shape (azimuths,)."""
        numbers = np.arange(self.azimuths, dtype=np.float32) + np.float32(0.5)
        return np.float32(self._middle + self._first) + numbers * np.float32(self._step)

    def bins(self) -> tuple[_Integers, _Integers]:
        """Azimuth and elevation of each pixel, as numbers, each of shape (height, width)."""
        azimuth, elevation = (
            ((values - np.float32(first)) * np.float32(1.0 / step)).astype(np.int32)
            for values, first, step in (
                (self._azimuth, self._first, self._step),
                (self._elevation, self.lowest, self.elevation_step),
            )
        )
        np.minimum(azimuth, self.azimuths - 1, out=azimuth)
        np.minimum(elevation, self.elevations - 1, out=elevation)
        return azimuth, elevation
