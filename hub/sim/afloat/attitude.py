"""Attitudes in space as unit quaternions, and the vectors that they turn; pure scalars.

A quaternion (w, x, y, z) turns vectors of the body into vectors of the world. The body's axes are x
forward, y left, z up; the world's are x east, y north, z up. Roll, pitch and yaw are about x, y and
z as in ROS REP 103: a positive pitch lowers the nose.
"""

from __future__ import annotations

import math

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

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


def roll_pitch_yaw(attitude: Quaternion) -> Vector:
    """Roll, pitch and yaw [rad]."""
    w, x, y, z = attitude
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The attitude with this roll, pitch and yaw [rad]."""
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    cp, sp = math.cos(pitch / 2.0), math.sin(pitch / 2.0)
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


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
