"""Velocities of panels: Foxglove's JSON, CDR as tools of ROS 2 write it, and what is none."""

from __future__ import annotations

import json
import random

import pytest
from rosbags.typesys import Stores, get_typestore

from hub.doors.panels.panel_twist import twist_of
from hub.errors import CodecError, RosMessageError
from hub.gcm.geometry import Twist

TYPES = get_typestore(Stores.ROS2_JAZZY)
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
PLAIN = {"linear": {"x": 0.5, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": -1.5}}
WANTED = Twist.planar(0.5, -1.5)


def cdr(kind: str) -> bytes:
    """A velocity as rosbags writes it."""
    vector, twist = TYPES.types["geometry_msgs/msg/Vector3"], TYPES.types[TWIST]
    value = twist(linear=vector(x=0.5, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=-1.5))
    if kind == STAMPED:
        time = TYPES.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
        header = TYPES.types["std_msgs/msg/Header"](stamp=time, frame_id="")
        value = TYPES.types[STAMPED](header=header, twist=value)
    return bytes(TYPES.serialize_cdr(value, kind))


@pytest.mark.parametrize(
    ("encoding", "kind", "data"),
    [
        ("cdr", TWIST, cdr(TWIST)),
        ("cdr", STAMPED, cdr(STAMPED)),
        ("json", "geometry_msgs/Twist", json.dumps(PLAIN).encode()),
        ("json", STAMPED, json.dumps({"header": {}, "twist": PLAIN}).encode()),
    ],
)
def test_velocities_are_read(encoding: str, kind: str, data: bytes) -> None:
    assert twist_of(encoding, kind, data) == WANTED


def test_parts_that_are_missing_are_zero() -> None:
    assert twist_of("json", TWIST, b'{"linear": {}}').neutral


@pytest.mark.parametrize(
    ("encoding", "kind", "data"),
    [
        ("json", "std_msgs/msg/String", b"{}"),
        ("json", "", b"{}"),
        ("protobuf", TWIST, b""),
        ("json", TWIST, b"{"),
        ("json", TWIST, b"[]"),
        ("json", TWIST, b"{}"),
        ("json", STAMPED, json.dumps(PLAIN).encode()),
        ("json", TWIST, b'{"linear": 3}'),
        ("json", TWIST, b'{"linear": {"x": "1"}}'),
        ("json", TWIST, b'{"linear": {"x": true}}'),
        ("json", TWIST, b'{"linear": {"x": NaN}}'),
        ("json", TWIST, b'{"linear": {"x": 1e999}}'),
        ("json", TWIST, b'{"linear": {"x": 1' + b"0" * 400 + b"}}"),
        ("json", TWIST, b'{"linear": {"x": 1e6}}'),
        ("json", TWIST, b"[" * 4000),
        ("cdr", TWIST, b""),
        ("cdr", TWIST, cdr(TWIST)[:-1]),
        ("cdr", TWIST, cdr(TWIST)[:4] + b"\xff" * 48),
        ("cdr", STAMPED, cdr(TWIST)),
    ],
)
def test_what_is_no_velocity_is_refused(encoding: str, kind: str, data: bytes) -> None:
    with pytest.raises((CodecError, RosMessageError)):
        twist_of(encoding, kind, data)


def test_damaged_bytes_raise_errors_of_ours_only() -> None:
    dice = random.Random(3)
    whole = [("cdr", cdr(TWIST)), ("json", json.dumps(PLAIN).encode())]
    for _ in range(2000):
        encoding, data = dice.choice(whole)
        damaged = bytearray(data)
        damaged[dice.randrange(len(damaged))] = dice.randrange(256)
        try:
            twist = twist_of(encoding, TWIST, bytes(damaged))
        except (CodecError, RosMessageError):
            continue
        parts = (twist.linear, twist.angular)
        assert all(abs(each) <= 100.0 for part in parts for each in (part.x, part.y, part.z))
