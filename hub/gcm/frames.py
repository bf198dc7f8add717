"""The frames of a body as matrices; axes and angles as in `hub.gcm.body`; pure."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm.body import BodyFrame
from hub.gcm.orientation import angles, rotation

Floats: TypeAlias = npt.NDArray[np.float64]


def poses_of(frames: tuple[BodyFrame, ...]) -> dict[str, tuple[Floats, Floats]]:
    """The pose of each frame in `base_link`: rotation, shape (3, 3), and origin [m], shape (3,).

    A frame whose parent is not among the frames before it counts from `base_link`.
    """
    poses: dict[str, tuple[Floats, Floats]] = {}
    for frame in frames:
        turn, origin = poses.get(frame.parent, (np.eye(3), np.zeros(3)))
        own = turn @ rotation(frame.roll, frame.pitch, frame.yaw)
        poses[frame.name] = own, origin + turn @ (frame.x, frame.y, frame.z)
    return poses


def in_base(frames: tuple[BodyFrame, ...], name: str) -> BodyFrame | None:
    """A frame as a child of `base_link`; None: there is none of that name."""
    found = poses_of(frames).get(name)
    if found is None:
        return None
    (roll, pitch, yaw), (x, y, z) = angles(found[0]), found[1].tolist()
    return BodyFrame(name=name, x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw)
