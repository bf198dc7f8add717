"""Orientations in space as rotation matrices, unit quaternions, and roll, pitch and yaw; pure.

Axes and angles after ROS REP 103: x forward, y left, z up; yaw turns first, then pitch, then roll.
Roll is positive with the right side down, pitch with the nose down, yaw counter-clockwise.
A quaternion (w, x, y, z) turns vectors of the turned axes into those of the frame around them.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Quaternion: TypeAlias = tuple[float, float, float, float]
"""w, x, y, z."""
Angles: TypeAlias = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""

_UPRIGHT = 1.0 - 1e-12
"""Sine of the pitch beyond which roll and yaw are the same turn."""
_LEAST_LEVEL = 1e-9
"""Cosine of the pitch below which they are."""


def rotation(roll: float, pitch: float, yaw: float) -> npt.NDArray[np.float64]:
    """The matrix of these angles [rad], shape (3, 3); its columns are the turned axes."""
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )
    )


def angles(turn: npt.NDArray[np.float64]) -> Angles:
    """The angles of a rotation matrix, shape (3, 3) [rad]; straight up or down the roll is 0."""
    (ahead_x, left_x, _), (ahead_y, left_y, _), (ahead_z, left_z, up_z) = turn.tolist()
    level = math.hypot(ahead_x, ahead_y)
    pitch = math.atan2(-ahead_z, level)
    if level < _LEAST_LEVEL:
        return 0.0, pitch, math.atan2(-left_x, left_y)
    return math.atan2(left_z, up_z), pitch, math.atan2(ahead_y, ahead_x)


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The unit quaternion of these angles [rad]."""
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    if roll == pitch == 0.0:  # most robots
        return cy, 0.0, 0.0, sy
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    cp, sp = math.cos(pitch / 2.0), math.sin(pitch / 2.0)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def roll_pitch_yaw(w: float, x: float, y: float, z: float) -> Angles:
    """The angles of a quaternion [rad], of any length but 0; 0 for that.

    Where the robot stands on its nose or tail, the roll is 0 and the yaw has all of the turn.
    """
    ww, xx, yy, zz = w * w, x * x, y * y, z * z
    norm = ww + xx + yy + zz
    sine = 2.0 * (w * y - z * x) / norm if norm else 0.0
    if abs(sine) >= _UPRIGHT:
        turn = 2.0 * math.atan2(z, w)
        return 0.0, math.copysign(math.pi / 2.0, sine), math.remainder(turn, math.tau)
    return (
        math.atan2(2.0 * (w * x + y * z), ww - xx - yy + zz),
        math.asin(sine),
        math.atan2(2.0 * (w * z + x * y), ww + xx - yy - zz),
    )
