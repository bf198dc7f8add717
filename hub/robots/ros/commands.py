"""Messages to a robot with ROS, in the encoding of its topics and services; pure."""

from __future__ import annotations

import struct
from typing import Final

from hub.gcm.geometry import Twist, TwistStamped
from hub.ipc.definition import MessageDefinition
from hub.robots.ros_table import CommandType

CDR: Final = "cdr"
ROS1: Final = "ros1"
TYPES: Final = {
    CommandType.TWIST: "geometry_msgs/msg/Twist",
    CommandType.STAMPED: "geometry_msgs/msg/TwistStamped",
}
"""Names of the types of velocities."""
_HEAD: Final = b"\0\1\0\0"
"""The encapsulation of CDR, little-endian."""
_FLAT: Final = MessageDefinition(name="Ros_Twist", type=Twist)
_STAMPED: Final = MessageDefinition(name="Ros_TwistStamped", type=TwistStamped)
_REQUESTS: Final = {
    "Trigger": b"",
    "Empty": b"",
    "SetBool": b"\1",
    "EStop": b"\1",
}
"""Bodies of requests to stop, by the last part of their type."""


def velocity_payload(velocity: Twist, kind: CommandType, encoding: str) -> bytes:
    """A velocity as a message, with stamp 0 where it has one.

    Controllers take the time of arrival for a stamp of 0. With any other stamp, a robot whose clock
    differs would ignore velocities, or follow old ones.
    """
    if kind is CommandType.TWIST:
        whole = b"".join(_FLAT.encode(velocity))
        return whole[len(_HEAD) :] if encoding == ROS1 else whole
    stamped = TwistStamped.of(velocity)
    if encoding != ROS1:
        return b"".join(_STAMPED.encode(stamped))
    frame = stamped.header.frame_id.encode()
    numbers = b"".join(_FLAT.encode(velocity))[len(_HEAD) :]
    return struct.pack(f"<4I{len(frame)}s", 0, 0, 0, len(frame), frame) + numbers


def stop_request(type_name: str, encoding: str) -> bytes | None:
    """The request to a service that stops a robot; None: it is of another type."""
    body = _REQUESTS.get(type_name.rpartition("/")[2])
    if body is None:
        return None
    # CDR has no empty messages: there it is one byte.
    return body if encoding == ROS1 else _HEAD + (body or b"\0")


def refusal(type_name: str, payload: bytes | memoryview, encoding: str) -> str:
    """Why a service of `stop_request` did not do it, in its own words; empty: it did."""
    answer = bytes(payload) if encoding == ROS1 else bytes(payload)[len(_HEAD) :]
    if type_name.endswith("/Empty") or answer[:1] != b"\0":
        return ""
    at = 1 if encoding == ROS1 else 4
    length = int.from_bytes(answer[at : at + 4], "little")
    words = answer[at + 4 : at + 4 + min(length, 200)].rstrip(b"\0").decode("utf-8", "replace")
    return words or "it gives no reason"


def setting_payload(type_name: str, value: float, encoding: str) -> bytes | None:
    """A message of std_msgs with one number; None: it is of another type."""
    made = {
        "Float64": lambda: struct.pack("<d", value),
        "Float32": lambda: struct.pack("<f", value),
        "Bool": lambda: bytes((value > 0.0,)),
        "Float64MultiArray": lambda: struct.pack(
            "<3Id" if encoding == ROS1 else "<3I4xd", 0, 0, 1, value
        ),
    }.get(type_name.rpartition("/")[2])
    if made is None:
        return None
    return made() if encoding == ROS1 else _HEAD + made()


def switch_request(encoding: str, *, on: bool) -> bytes:
    """The request of a std_srvs/SetBool."""
    return (b"" if encoding == ROS1 else _HEAD) + bytes((on,))
