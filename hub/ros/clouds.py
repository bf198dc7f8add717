"""Clouds of points, sensor_msgs/PointCloud2, as a picture from above."""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.ros.images import Pixels
from hub.ros.values import RosValue

SIDE: Final = 240
"""Width and height of the picture [pixels]."""
_TYPES: Final = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""Types of numbers, as sensor_msgs/PointField numbers them."""
_MOST_POINTS: Final = 200_000
"""More points than that are thinned."""
_LEAST_SIDE_M: Final = 4.0


def points_of(cloud: RosValue) -> npt.NDArray[np.float32]:
    """The finite points of a cloud [m], shape (n, 3); of very many some.

    Raises:
        RosMessageError: It has no x, y, z, or its sizes do not match its data.
    """
    step, data = int(cloud.get("point_step")), cloud.get("data")
    order = "<>"[bool(cloud.get("is_bigendian"))]
    count = int(cloud.get("width")) * int(cloud.get("height"))
    fields = {str(each.get("name")): each for each in cloud.get("fields")}
    if not 0 < step <= 1 << 16 or not {"x", "y", "z"} <= fields.keys():
        text = "a cloud has no x, y and z"
        raise RosMessageError(text)
    count = min(count, len(data) // step)
    every = max(1, -(-count // _MOST_POINTS))
    columns = []
    for name in "xyz":
        kind, at = _TYPES.get(int(fields[name].get("datatype"))), int(fields[name].get("offset"))
        if kind is None or at + int(kind[1]) > step:
            text = f"the {name} of a cloud is not within its points"
            raise RosMessageError(text)
        if not count:
            return np.empty((0, 3), np.float32)
        column = np.ndarray((count,), order + kind, data, at, (step,))[::every]
        columns.append(column.astype(np.float32))
    points = np.stack(columns, axis=1)
    finite: npt.NDArray[np.float32] = points[np.isfinite(points).all(axis=1)]
    return finite


def from_above(points: npt.NDArray[np.float32]) -> Pixels:
    """The picture of points from above, x up and y to the left; blue is low, red is high.

    The robot is in the middle, and the picture reaches to nearly all points.

    Args:
        points: [m], shape (n, 3).
    """
    picture = np.zeros((SIDE, SIDE, 3), np.uint8)
    picture[SIDE // 2 - 1 : SIDE // 2 + 1, SIDE // 2 - 1 : SIDE // 2 + 1] = 255
    if not len(points):
        return picture
    away = np.abs(points[:, :2]).max(axis=1)
    reach = max(_LEAST_SIDE_M / 2.0, float(np.percentile(away, 98.0)))
    places = (SIDE / 2.0 - points[:, :2] * (SIDE / 2.0 / reach))[away < reach].astype(np.intp)
    height = points[:, 2][away < reach]
    if not len(height):
        return picture
    low, high = np.percentile(height, (2.0, 98.0))
    share = np.clip((height - low) / max(float(high - low), 0.1), 0.0, 1.0)
    colours = np.stack(
        (80 + 175 * share, 230 - 360 * np.abs(share - 0.5), 255 - 200 * share), axis=1
    )
    order = np.argsort(height, kind="stable")
    inside = np.clip(places, 0, SIDE - 1)[order]
    picture[inside[:, 0], inside[:, 1]] = colours[order].astype(np.uint8)
    return picture
