"""The shapes of the ground's elements: height and slopes at points of an element's rectangle."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.geometry import Side
from hub.sim.ground.specs import (
    TILE,
    ElementSpec,
    PipeSpec,
    RampFieldSpec,
    RampSpec,
    StairsSpec,
    StepfieldSpec,
)
from hub.values import dataclass

Floats = npt.NDArray[np.float64]

_ROUNDING = 1e-9
_STEEPEST = 3.0
"""Largest slope of a pipe's side in one cell [m/m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Relief:
    """The shape of an element.

    Attributes:
        heights: Height of points [m], shape (rows, columns).
        east: Slope towards east [m/m], same shape.
        north: Slope towards north [m/m], same shape.
    """

    heights: Floats
    east: Floats
    north: Floats


def relief_of(spec: ElementSpec, x: Floats, y: Floats) -> Relief:
    """The shape at points of its rectangle.

    Args:
        spec: The element.
        x: East of its south-west corner [m], shape (columns,).
        y: North of that corner [m], shape (rows,).
    """
    match spec:
        case RampSpec():
            return _ramp(spec, x, y)
        case RampFieldSpec():
            return _ramp_field(spec, x, y)
        case StepfieldSpec():
            return _stepfield(spec, x, y)
        case StairsSpec():
            return _stairs(spec, x, y)
        case PipeSpec():
            return _pipe(spec, x, y)


def _ramp(spec: RampSpec, x: Floats, y: Floats) -> Relief:
    slope = (spec.high - spec.low) / spec.size[spec.rises.axis]
    heights = spec.low + slope * _uphill(spec.rises, spec.size, x, y)
    tilt = slope * spec.rises.sign
    return _relief(heights, *((tilt, 0.0) if spec.rises.axis == 0 else (0.0, tilt)))


def _ramp_field(spec: RampFieldSpec, x: Floats, y: Floats) -> Relief:
    """Half ramps of 0.6 m; crossing ones rise north or fall east in turn."""
    half, steep = TILE / 2, math.tan(spec.angle)
    column = np.floor(x / half + _ROUNDING)
    row = np.floor(y / half + _ROUNDING)[:, None]
    east, north = x - column * half, y[:, None] - row * half
    if spec.crossing:
        rises = (column + row) % 2 == 1
        return _relief(
            np.where(rises, north, half - east) * steep,
            np.where(rises, 0.0, -steep),
            np.where(rises, steep, 0.0),
        )
    up = column % 2 == 0
    heights = np.where(up, east, half - east) * steep
    return _relief(heights + 0.0 * row, np.where(up, steep, -steep), 0.0)


def _stepfield(spec: StepfieldSpec, x: Floats, y: Floats) -> Relief:
    count = spec.posts
    along, across = np.indices((count, count))
    random = np.random.default_rng(spec.seed)
    if spec.pattern == "flat":
        units = random.integers(1, 3, (count, count))
    else:
        away = np.abs(across - (count // 2 if spec.pattern == "hill" else along))
        units = 4 - np.minimum(away, 4) + random.integers(0, 2, (count, count))
    column, row = (
        np.clip(np.floor(places / spec.post + _ROUNDING).astype(np.intp), 0, count - 1)
        for places in (x, y)
    )
    heights = units[row[:, None], column].astype(np.float64) * spec.unit
    return _relief(heights, 0.0, 0.0)


def _stairs(spec: StairsSpec, x: Floats, y: Floats) -> Relief:
    along = _uphill(spec.rises, spec.extent, x, y)
    step = np.minimum(np.floor(along / spec.run + _ROUNDING) + 1.0, spec.steps)
    return _relief(step * spec.rise, 0.0, 0.0)


def _pipe(spec: PipeSpec, x: Floats, y: Floats) -> Relief:
    off = (y[:, None] + 0.0 * x if spec.along == "x" else x + 0.0 * y[:, None]) - spec.radius
    up = np.sqrt(np.maximum(spec.radius**2 - off**2, 0.0))
    slope: Floats = np.clip(-off / np.maximum(up, _ROUNDING), -_STEEPEST, _STEEPEST)
    heights: Floats = np.maximum(spec.height - spec.radius + up, 0.0)
    return _relief(heights, *((0.0, slope) if spec.along == "x" else (slope, 0.0)))


def _uphill(rises: Side, size: tuple[float, float], x: Floats, y: Floats) -> Floats:
    """Distance of points from the low end [m], shape (rows, columns)."""
    along = x + 0.0 * y[:, None] if rises.axis == 0 else y[:, None] + 0.0 * x
    return along if rises.sign > 0 else size[rises.axis] - along


def _relief(heights: Floats, east: Floats | float, north: Floats | float) -> Relief:
    shape = heights.shape
    return Relief(
        heights=heights, east=np.broadcast_to(east, shape), north=np.broadcast_to(north, shape)
    )
