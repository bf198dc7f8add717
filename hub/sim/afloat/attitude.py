"""Attitudes in space as unit quaternions, and the vectors that they turn; pure scalars.

A quaternion turns vectors of the body into vectors of the world; `hub.gcm.orientation` has their
angles. The body's axes are x forward, y left, z up; the world's are x east, y north, z up.
"""

from __future__ import annotations

import math

from hub.gcm.orientation import Quaternion

Vector = tuple[float, float, float]

LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)
_STILL = 1e-12
"""A slower turn than this is computed by its first-order term [rad/s]."""


def into_body(attitude: Quaternion, vector: Vector) -> Vector:
    """A vector of the world in the body's frame."""
    w, x, y, z = attitude
    vx, vy, vz = vector
    tx, ty, tz = 2.0 * (z * vy - y * vz), 2.0 * (x * vz - z * vx), 2.0 * (y * vx - x * vy)
    return (
        vx + w * tx - y * tz + z * ty,
        vy + w * ty - z * tx + x * tz,
        vz + w * tz - x * ty + y * tx,
    )


def into_world(attitude: Quaternion, vector: Vector) -> Vector:
    """A vector of the body in the world's frame."""
    w, x, y, z = attitude
    return into_body((w, -x, -y, -z), vector)


def up_in_body(attitude: Quaternion) -> Vector:
    """The upward unit vector in the body's frame."""
    w, x, y, z = attitude
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


def turned(attitude: Quaternion, rates: Vector, seconds: float) -> Quaternion:
    """The attitude after a turn at constant rates about the body's axes [rad/s]."""
    ox, oy, oz = rates
    rate = math.sqrt(ox * ox + oy * oy + oz * oz)
    half = 0.5 * rate * seconds
    scale = math.sin(half) / rate if rate > _STILL else 0.5 * seconds
    c = math.cos(half)
    bx, by, bz = ox * scale, oy * scale, oz * scale
    w, x, y, z = attitude
    nw, nx = w * c - x * bx - y * by - z * bz, w * bx + x * c + y * bz - z * by
    ny, nz = w * by - x * bz + y * c + z * bx, w * bz + x * by - y * bx + z * c
    norm = 1.0 / math.sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
    return nw * norm, nx * norm, ny * norm, nz * norm
