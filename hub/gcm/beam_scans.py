"""New measurements of range sensors, each with the pose of the robot at its time; pure."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.gcm.beams import Beams, beams_of
from hub.gcm.body import RobotBody
from hub.gcm.imu import Imu
from hub.gcm.outline import exits
from hub.gcm.pose_history import UNKNOWN, Moving, PoseHistory
from hub.gcm.ranges import RangeReadings, too_near
from hub.gcm.standard import Time
from hub.pose import Pose
from hub.values import dataclass

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

LARGEST_TILT = math.radians(5.0)
"""Largest angle of a beam, or of the robot, to the ground [rad]: beyond it a beam passes over
obstacles or meets the ground."""
TILTED_REACH = 1.0
"""While the robot is tilted, ranges below this [m] show what stands before it on its own plane."""
TILT_ERROR = math.radians(1.0)
"""Error of a measured tilt that is allowed for [rad]."""
ATTITUDE_S = 1.0
"""An older attitude is not known any more [s]; then the robot counts as level."""
_INSIDE = 0.03
"""A hit farther inside the outline than this is a part of the robot [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeamScan:
    """The newest ranges of all beams.

    Attributes:
        pose: The robot's pose when those that are new were measured, in the frame of the poses
            that the reader was given.
        ranges: From the origin of each beam, along the ground [m], shape (n,); inf: nothing
            within reach, 0: an obstacle nearer than the sensor can measure, NaN: not known.
        fresh: Which of them are new, shape (n,).
        along: The new ranges along all beams, also those that look up or down [m], shape (n,); NaN:
            not new. None: not known.
        roll: Of the robot then [rad]; 0: not known.
        pitch: The same [rad].
        tilted: Whether the robot was tilted too far: only near ranges count, and no map takes them.
    """

    pose: Pose
    ranges: Floats
    fresh: Flags
    along: Floats | None = None
    roll: float = 0.0
    pitch: float = 0.0
    tilted: bool = False


class ScanReader:
    """Keeps the poses and the attitude of the last seconds.

    Attributes:
        beams: The beams of the body.
        tilt: Angle of the robot to the ground while it is too large to use all ranges [rad]; else
            0.
    """

    def __init__(self, body: RobotBody) -> None:
        self.beams: Beams = beams_of(body)
        self.tilt = 0.0
        beams = self.beams
        self._level = np.abs(beams.elevation) <= LARGEST_TILT
        self._flat = np.cos(beams.elevation)
        self._own = exits(body, beams.x, beams.y, beams.bearing) - _INSIDE
        self._poses = PoseHistory()
        self._stamps: dict[str, Time] = {}
        self._attitude = (0.0, 0.0, -math.inf)

    def restart(self) -> None:
        """Forget the poses: their frame is another one now."""
        self._poses = PoseHistory()

    def moved(self, state: Moving, measured: float) -> None:
        """Take a pose, measured at a monotonic time [s]; all poses are in one frame."""
        self._poses.add(state, measured)

    def tilted(self, imu: Imu, measured: float) -> None:
        """Take a tilt, measured at a monotonic time [s]."""
        roll, pitch, _ = imu.roll_pitch_yaw
        if not math.isnan(roll):
            self._attitude = roll, pitch, measured

    def read(self, readings: RangeReadings, measured: float) -> BeamScan | None:
        """The beams of groups that have measured since the last call; None: there are none.

        There are none either while the robot's pose is not known. A range is left out where the
        beam meets the ground, or may meet it.
        """
        new = np.zeros(len(self._level), dtype=np.bool_)
        for scan in readings.scans:
            name, stamp = scan.header.frame_id, scan.header.stamp
            # A driver without a clock stamps all its scans with 0.
            if name in self.beams.groups and (stamp != self._stamps.get(name) or stamp == Time()):
                self._stamps[name] = stamp
                new[self.beams.groups[name]] = True
        roll, pitch, at = self._attitude
        known = measured - at <= ATTITUDE_S
        if not known:
            roll = pitch = 0.0
        upright = math.cos(roll) * math.cos(pitch)
        tilt = math.acos(min(1.0, max(-1.0, upright)))
        self.tilt = tilt if tilt > LARGEST_TILT else 0.0
        pose = self._poses.at(measured)
        if pose is UNKNOWN or not new.any():
            return None
        along: Floats = self.beams.ranges(readings).astype(np.float64)
        # A body that does not use `scan_of` may publish 0 where it did not measure.
        along[along <= 0.0] = np.nan
        ranges = along * self._flat
        near = too_near(along, self.beams.nearest)
        floor = self.beams.to_floor(roll, pitch, TILT_ERROR if known else 0.0)
        ranges[~self._level | (np.minimum(along, self.beams.farthest) >= floor)] = np.nan
        ranges[near & ~np.isnan(ranges)] = 0.0
        ranges[~near & (ranges < self._own)] = np.nan
        if self.tilt:
            ranges[~(ranges < TILTED_REACH)] = np.nan
        return BeamScan(
            pose=pose,
            ranges=ranges,
            fresh=new & ~np.isnan(ranges),
            along=np.where(new, along, np.nan),
            roll=roll,
            pitch=pitch,
            tilted=bool(self.tilt),
        )
