"""Messages of Foxglove, in any encoding, as those of ROS that say the same.

The types: https://docs.foxglove.dev/docs/sdk/schemas
"""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from hub.errors import RosMessageError
from hub.ros.values import NamedValue, RosValue

_KNOWN_GRID: Final = (1, 2)
"""Types of numbers of a cell that is free, taken or not known: a byte."""
_TYPES: Final = {1: 2, 2: 1, 3: 4, 4: 3, 5: 6, 6: 5, 7: 7, 8: 8}
"""Types of numbers, and what sensor_msgs/PointField calls them."""
_PREFIXES: Final = ("foxglove.", "foxglove_msgs/msg/", "foxglove_msgs/")


def as_ros(name: str, value: RosValue) -> RosValue:
    """The message of ROS that says the same; the value itself: it is none of foxglove.

    Raises:
        RosMessageError: It lacks a field.
    """
    found = _MADE.get(_short(name))
    return value if found is None else NamedValue(found[0], found[1](value))


def ros_name(name: str) -> str:
    """The name of the type of ROS that says the same; the name itself: there is none."""
    found = _MADE.get(_short(name))
    return name if found is None else found[0]


def foxglove_names(name: str) -> tuple[str, ...]:
    """The types of foxglove that become a type of ROS."""
    return tuple(f"foxglove.{each}" for each, (ros, _) in _MADE.items() if ros == name)


def _short(name: str) -> str:
    return next((name[len(each) :] for each in _PREFIXES if name.startswith(each)), "")


def _part(value: RosValue, *names: str) -> float:
    """The first of some fields that is there; 0: none is."""
    return next((float(found) for each in names if (found := value.field(each)) is not None), 0.0)


def _header(value: RosValue, frame: str = "frame_id") -> dict[str, Any]:
    stamp = value.field("timestamp")
    sec = nanosec = 0.0
    if isinstance(stamp, RosValue):  # protobuf, JSON and ROS 2 each have names of their own
        sec = _part(stamp, "seconds", "sec")
        nanosec = _part(stamp, "nanos", "nsec", "nanosec")
    time = {"sec": int(sec), "nanosec": int(nanosec)}
    return {"stamp": time, "frame_id": str(value.field(frame) or "")}


def _data(value: RosValue) -> Any:  # noqa: ANN401 - an array of bytes
    """Bytes; JSON has them as base64."""
    data = value.get("data")
    if isinstance(data, str):
        data = np.frombuffer(base64.b64decode(data), np.uint8)
    return np.asarray(data, np.uint8)


def _pose(value: RosValue) -> dict[str, Any]:
    """A pose; an orientation in which nothing is written is none."""
    turn = value.get("orientation")
    return {"position": _plain(value.get("position"), "xyz"), "orientation": _plain(turn, "xyzw")}


def _plain(value: RosValue, parts: str) -> dict[str, Any]:
    return {each: _part(value, each) for each in parts}


def _image(value: RosValue) -> dict[str, Any]:
    sizes = {each: value.get(each) for each in ("width", "height", "step", "encoding")}
    return {"header": _header(value), "is_bigendian": False, "data": _data(value), **sizes}


def _compressed(value: RosValue) -> dict[str, Any]:
    return {"header": _header(value), "format": value.get("format"), "data": _data(value)}


def _camera(value: RosValue) -> dict[str, Any]:
    matrix = value.field("K") if value.field("K") is not None else value.get("k")
    return {"header": _header(value), "width": value.get("width"), "k": np.asarray(matrix)}


def _scan(value: RosValue) -> dict[str, Any]:
    ranges = np.asarray(value.get("ranges"), np.float64)
    first, last = float(value.get("start_angle")), float(value.get("end_angle"))
    # It has no limits: the scan is drawn to the power of two above its longest beam.
    longest = np.max(ranges[np.isfinite(ranges)], initial=1.0)
    return {
        "header": _header(value),
        "angle_min": first,
        "angle_increment": (last - first) / max(1, len(ranges) - 1),
        "range_min": 0.0,
        "range_max": 2.0 ** math.ceil(math.log2(longest)),
        "ranges": ranges,
    }


def _cloud(value: RosValue) -> dict[str, Any]:
    data, step = _data(value), int(value.get("point_stride"))
    fields = [
        {
            "name": each.get("name"),
            "offset": each.get("offset"),
            "datatype": _TYPES.get(int(each.get("type")), 0),
        }
        for each in value.get("fields")
    ]
    return {
        "header": _header(value),
        "height": 1,
        "width": len(data) // max(1, step),
        "point_step": step,
        "is_bigendian": False,
        "fields": fields,
        "data": data,
    }


def _grid(value: RosValue) -> dict[str, Any]:
    data, width = _data(value), int(value.get("column_count"))
    row, cell = int(value.get("row_stride")), int(value.get("cell_stride"))
    fields, size = value.get("fields"), value.get("cell_size")
    simple = fields and int(fields[0].get("type")) in _KNOWN_GRID and min(width, cell) > 0
    if not simple or row < width * cell or abs(_part(size, "x") - _part(size, "y")) > 1e-9:
        text = "a grid whose cells are no squares of one byte is not shown"
        raise RosMessageError(text)
    height, at = len(data) // row, int(fields[0].get("offset"))
    cells = data[: height * row].reshape(height, row)[:, at : at + width * cell : cell]
    info = {
        "width": width,
        "height": height,
        "resolution": _part(size, "x"),
        "origin": _pose(value.get("pose")),
    }
    return {"header": _header(value), "info": info, "data": cells.reshape(-1).view(np.int8)}


def _transform(value: RosValue) -> dict[str, Any]:
    moved = {
        "translation": _plain(value.get("translation"), "xyz"),
        "rotation": _plain(value.get("rotation"), "xyzw"),
    }
    header = _header(value, "parent_frame_id")
    return {"header": header, "child_frame_id": value.get("child_frame_id"), "transform": moved}


def _transforms(value: RosValue) -> dict[str, Any]:
    return {"transforms": [_transform(each) for each in value.get("transforms")]}


def _path(value: RosValue) -> dict[str, Any]:
    header = _header(value)
    poses = [{"header": header, "pose": _pose(each)} for each in value.get("poses")]
    return {"header": header, "poses": poses}


def _log(value: RosValue) -> dict[str, Any]:
    level = 10 * int(value.get("level"))  # DEBUG is 1 here, and 10 there
    return {"level": level, "name": value.get("name"), "msg": value.get("message")}


_Made = tuple[str, Callable[[RosValue], dict[str, Any]]]
_MADE: Final[Mapping[str, _Made]] = {
    "RawImage": ("sensor_msgs/msg/Image", _image),
    "CompressedImage": ("sensor_msgs/msg/CompressedImage", _compressed),
    "CameraCalibration": ("sensor_msgs/msg/CameraInfo", _camera),
    "PointCloud": ("sensor_msgs/msg/PointCloud2", _cloud),
    "LaserScan": ("sensor_msgs/msg/LaserScan", _scan),
    "Grid": ("nav_msgs/msg/OccupancyGrid", _grid),
    "PosesInFrame": ("nav_msgs/msg/Path", _path),
    "PoseInFrame": (
        "geometry_msgs/msg/PoseStamped",
        lambda value: {"header": _header(value), "pose": _pose(value.get("pose"))},
    ),
    "FrameTransform": (
        "tf2_msgs/msg/TFMessage",
        lambda value: {"transforms": [_transform(value)]},
    ),
    "Log": ("rcl_interfaces/msg/Log", _log),
    "FrameTransforms": ("tf2_msgs/msg/TFMessage", _transforms),
}
