"""Keys, tokens, attachments and hashes are those of rmw_zenoh; anything else is refused."""

from __future__ import annotations

import random
import struct

import pytest
from rosbags.typesys import Stores, get_typestore

from hub.errors import RosMessageError
from hub.ros import rmw_zenoh
from hub.ros.known_types import known_texts
from hub.ros.rmw_zenoh import Endpoint, Entity, EntityKind, MessageOrigin, QualityOfService
from hub.ros.type_hashes import later_definition, type_hash

STAMPED = "geometry_msgs/msg/TwistStamped"
HASH = f"RIHS01_{'5f' * 32}"
TOKEN = (
    "@ros2_lv/3/a1b2/0/11/MP/%/%rover/camera/%camera%image/sensor_msgs::msg::dds_::Image_/"
    f"{HASH}/2:1:,5:,:,:,,"
)
HOSTILE = 100_000


def test_hashes_are_those_of_ros_2() -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    others = {*store.fielddefs} - {"std_msgs/msg/Char"}  # rosbags takes char for a type of its own
    known = [each for each in known_texts() if each in others and type_hash(each)]
    assert {each: type_hash(each) for each in known} == {
        each: store.hash_rihs01(each) for each in known
    }
    assert len(known) > 130
    assert type_hash(STAMPED).startswith("RIHS01_5f0fcd4f81d5")  # `ros2 topic info -v` prints it
    assert type_hash("rcl_interfaces/msg/ParameterDescriptor") == ""  # has a limited sequence
    assert type_hash("nobodys_msgs/msg/Thing") == ""


def test_a_type_that_got_a_field_is_known_by_its_hash() -> None:
    jazzy = get_typestore(Stores.ROS2_JAZZY).hash_rihs01("sensor_msgs/msg/Range")
    assert later_definition("sensor_msgs/msg/Range", jazzy).endswith("float32 variance\n")
    assert later_definition("sensor_msgs/msg/Range", type_hash("sensor_msgs/msg/Range")) == ""
    assert later_definition("sensor_msgs/msg/Imu", HASH) == ""


def test_a_key_has_domain_name_type_and_hash() -> None:
    stick = Endpoint(name="/rover/cmd_vel", type=STAMPED, hash=HASH)
    assert stick.key(3) == f"3/rover/cmd_vel/geometry_msgs::msg::dds_::TwistStamped_/{HASH}"


def test_a_token_says_who_has_what() -> None:
    entity = rmw_zenoh.parse_token(TOKEN)
    assert entity == Entity(
        session="a1b2",
        number=11,
        kind=EntityKind.PUBLISHER,
        namespace="/rover",
        node_name="camera",
        endpoint=Endpoint(
            name="/camera/image",
            type="sensor_msgs/msg/Image",
            hash=HASH,
            quality=QualityOfService(reliable=False, latched=True, depth=5),
        ),
    )
    assert entity.full_node_name == "/rover/camera"
    assert entity.token(3) == TOKEN


def test_a_node_without_a_namespace_has_a_token_of_nine_parts() -> None:
    node = Entity(session="a1b2", number=0, kind=EntityKind.NODE, node_name="rune")
    assert node.token(0) == "@ros2_lv/0/a1b2/0/0/NN/%/%/rune"
    assert rmw_zenoh.parse_token(node.token(0)) == node
    assert node.full_node_name == "/rune"


def test_attachments_of_both_forms_are_read() -> None:
    origin = MessageOrigin(sequence=7, stamp_ns=1_700_000_000_000_000_001, gid=bytes(range(16)))
    assert len(origin.pack()) == 33
    old = (
        b"\x0fsequence_number" + struct.pack("<q", 7)
        + b"\x10source_timestamp" + struct.pack("<q", origin.stamp_ns)
        + b"\x0asource_gid" + b"\x10" + origin.gid
    )  # fmt: skip
    for raw in (origin.pack(), old):
        assert rmw_zenoh.unpack_origin(raw) == origin
    for bad in (None, b"", origin.pack()[:-1], old[:-1], bytes(33), bytes(77)):
        with pytest.raises(RosMessageError, match="bytes attached"):
            rmw_zenoh.unpack_origin(bad)


def test_tokens_of_unknown_programs_are_refused_at_most() -> None:
    chance = random.Random(7)
    marks = "/%:,@*$?#_ aZ09\x00ä\n"
    refused = 0
    for _ in range(HOSTILE):
        at = chance.randrange(len(TOKEN))
        text = TOKEN[:at] + chance.choice(marks) * chance.choice((0, 1, 1, 900)) + TOKEN[at + 1 :]
        try:
            found = rmw_zenoh.parse_token(text)
        except RosMessageError:
            refused += 1
        else:
            assert found.endpoint is not None
            assert "*" not in found.endpoint.key(3)
            assert rmw_zenoh.parse_token(found.token(3)) == found
    assert refused > HOSTILE / 4
