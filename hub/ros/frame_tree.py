"""The tree of frames of a recording, from its transforms (REP 105)."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.gcm.orientation import angles
from hub.ros.values import RosValue

_MOST_FRAMES: Final = 10_000
_MOST_STEPS: Final = 100
"""Longest way from a frame to the root; frames may also form a ring."""
_FARTHEST: Final = 1e12
"""Farthest origin of a frame in another [m]; the sum of many is still a number."""

Floats = npt.NDArray[np.float64]


class FramePlace(NamedTuple):
    """The pose of a frame in another one.

    Attributes:
        turn: Its axes, shape (3, 3).
        origin: Its origin [m], shape (3,).
    """

    turn: Floats
    origin: Floats

    def after(self, outer: FramePlace) -> FramePlace:
        """The same pose, seen from the frame around that of `outer`."""
        return FramePlace(outer.turn @ self.turn, outer.origin + outer.turn @ self.origin)

    @property
    def inverse(self) -> FramePlace:
        """The pose of the other frame in this one."""
        return FramePlace(self.turn.T, -self.turn.T @ self.origin)

    @property
    def roll_pitch_yaw(self) -> tuple[float, float, float]:
        """Its angles [rad]."""
        return angles(self.turn)


HERE: Final = FramePlace(np.eye(3), np.zeros(3))


class FrameTree:
    """Newest pose of each frame in its parent."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, FramePlace]] = {}

    @property
    def names(self) -> Collection[str]:
        """All frames that have a parent."""
        return self._parents.keys()

    def take(self, message: RosValue) -> None:
        """Take a tf2_msgs/TFMessage; a frame whose place makes no sense is known no more."""
        for each in message.get("transforms"):
            parent, child = (
                plain_frame(each.get("header.frame_id")),
                plain_frame(each.get("child_frame_id")),
            )
            known = child in self._parents or len(self._parents) < _MOST_FRAMES
            moved = each.get("transform")
            place = place_of(moved.get("translation"), moved.get("rotation"))
            if place is None:
                self._parents.pop(child, None)
            elif child and child != parent and known:
                self._parents[child] = parent, place

    def place(self, frame: str, within: str) -> FramePlace | None:
        """The pose of a frame in another; None: they are not joined."""
        up, around = self._to_root(plain_frame(frame)), self._to_root(plain_frame(within))
        for name, place in up.items():
            if name in around:
                return place.after(around[name].inverse)
        return None

    def _to_root(self, frame: str) -> dict[str, FramePlace]:
        """The pose of a frame in each frame above it, the nearest first."""
        found, at, place = {frame: HERE}, frame, HERE
        while at in self._parents and len(found) < _MOST_STEPS:
            at, step = self._parents[at]
            place = place.after(step)
            if at in found:
                break
            found[at] = place
        return found


def plain_frame(name: str) -> str:
    """The name of a frame without the slash of ROS 1."""
    return name.removeprefix("/")


def turn_of(orientation: RosValue) -> Floats | None:
    """The matrix of a quaternion, shape (3, 3); None: it is no rotation.

    Drivers that know none leave it 0. Another size than about 1 is no rounding error.
    """
    x, y, z, w = (float(orientation.get(part)) for part in "xyzw")
    norm = x * x + y * y + z * z + w * w if max(map(abs, (x, y, z, w))) < 1e3 else 0.0
    if not 0.5**2 < norm < 2.0**2:
        return None
    scale = 2.0 / norm
    return np.array(
        (
            (1 - scale * (y * y + z * z), scale * (x * y - z * w), scale * (x * z + y * w)),
            (scale * (x * y + z * w), 1 - scale * (x * x + z * z), scale * (y * z - x * w)),
            (scale * (x * z - y * w), scale * (y * z + x * w), 1 - scale * (x * x + y * y)),
        )
    )


def place_of(position: RosValue, orientation: RosValue) -> FramePlace | None:
    """The pose of a position and a quaternion; None: it is too far away, or no rotation."""
    origin = np.array([float(position.get(part)) for part in "xyz"])
    turn = turn_of(orientation)
    near = bool((abs(origin) <= _FARTHEST).all())
    return FramePlace(turn, origin) if near and turn is not None else None


def pose_of(pose: RosValue) -> FramePlace:
    """The pose of a geometry_msgs/Pose.

    Raises:
        RosMessageError: It is none.
    """
    place = place_of(pose.get("position"), pose.get("orientation"))
    if place is None:
        text = "a pose is not finite, or has no orientation"
        raise RosMessageError(text)
    return place
