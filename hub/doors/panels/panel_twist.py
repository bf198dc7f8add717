"""Velocities of panels, from untrusted bytes; pure."""

from __future__ import annotations

import math
from typing import Any, Final

from hub.errors import RosMessageError
from hub.gcm.geometry import Twist, TwistStamped, Vector3
from hub.ipc.definition import MessageDefinition, Plane
from hub.ros.plain_json import json_values
from hub.ros.schema import full_name

_PLAIN: Final = MessageDefinition(name="panel_twist", type=Twist, plane=Plane.COMMAND)
_STAMPED: Final = MessageDefinition(name="panel_stamped", type=TwistStamped, plane=Plane.COMMAND)


def twist_of(encoding: str, schema_name: str, data: bytes) -> Twist:
    """The velocity in a command, a geometry_msgs/Twist or TwistStamped.

    Args:
        encoding: "cdr" or "json".
        schema_name: The type.
        data: The bytes.

    Raises:
        RosMessageError: It is another type, or no velocity.
        CodecError: It is malformed, or a number is out of range.
    """
    kind = full_name(schema_name)
    stamped = kind == TwistStamped.ros_type
    if not stamped and kind != Twist.ros_type:
        text = f"{schema_name!r} is no velocity; send geometry_msgs/Twist or TwistStamped"
        raise RosMessageError(text)
    if encoding == "cdr":
        return _STAMPED.decode(data).twist if stamped else _PLAIN.decode(data)
    if encoding != "json":
        text = f"velocities come as cdr or json, not as {encoding!r}"
        raise RosMessageError(text)
    values: Any = json_values(data)
    twist = values.get("twist") if stamped else values
    if not (isinstance(twist, dict) and twist.keys() & {"linear", "angular"}):
        text = "a velocity in JSON is an object with linear and angular"
        raise RosMessageError(text)
    found = Twist(linear=_vector(twist, "linear"), angular=_vector(twist, "angular"))
    return _PLAIN.decode(b"".join(_PLAIN.encode(found)))


def _vector(twist: dict[str, Any], name: str) -> Vector3:
    part = twist.get(name, {})
    if not isinstance(part, dict):
        text = f"{name} of a velocity in JSON is an object"
        raise RosMessageError(text)
    return Vector3(x=_axis(part, "x"), y=_axis(part, "y"), z=_axis(part, "z"))


def _axis(part: dict[str, Any], axis: str) -> float:
    value = part.get(axis, 0.0)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not math.isfinite(value):
        text = f"{axis} of a velocity in JSON is no number"
        raise RosMessageError(text)
    return float(value)
