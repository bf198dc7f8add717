"""What Rune writes of ROS 1 and ROS 2 is what others read."""

import re

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hub.errors import RosMessageError
from hub.robots.simulated_ros.flavour import ROS_1, ROS_2
from hub.robots.simulated_ros.robot import TOPICS, SimulatedRosRobot
from hub.ros.definition_texts import definition_text
from hub.ros.encoding import encoder_of

ROS_1_STORE = get_typestore(Stores.ROS1_NOETIC)
TYPES = sorted({each.type for each in TOPICS} | {"geometry_msgs/msg/TwistStamped"})
STAMP = 1_700_000_000.25


@pytest.fixture(scope="module")
def robot():
    made = SimulatedRosRobot("yellow", timeout=0.5)
    for _ in range(20):
        made.advance(0.01, STAMP)
    return made


def plain(value):
    """A message of rosbags as mappings, lists and numbers."""
    if hasattr(value, "__msgtype__"):
        return {
            name.lower(): plain(each)
            for name, each in vars(value).items()
            if not name.startswith("__")
        }
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def without_numbers(values):
    """The same without the number that each header of ROS 1 has."""
    if isinstance(values, dict):
        kept = {name: without_numbers(each) for name, each in values.items() if name != "seq"}
        return {{"secs": "sec", "nsecs": "nanosec"}.get(name, name): kept[name] for name in kept}
    return [without_numbers(each) for each in values] if isinstance(values, list) else values


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_others_read_each_message_of_both_versions_alike(topic, robot):
    message = robot.message(topic.name)
    newer, older = get_typestore(Stores.EMPTY), get_typestore(Stores.EMPTY)
    newer.register(get_types_from_msg(definition_text(topic.type, "ros2msg"), topic.type))
    older.register(get_types_from_msg(definition_text(topic.type, "ros1msg"), topic.type))
    of_ros_2 = newer.deserialize_cdr(ROS_2.encoder(topic.type).encode(message), topic.type)
    of_ros_1 = older.deserialize_ros1(ROS_1.encoder(topic.type).encode(message), topic.type)
    np.testing.assert_equal(without_numbers(plain(of_ros_1)), plain(of_ros_2))
    found = plain(of_ros_2)
    found = found["transforms"][0] if "transforms" in found else found
    if topic.name != "/tf_static":
        assert found["header"]["stamp"] == {"sec": 1_700_000_000, "nanosec": 250_000_000}


@pytest.mark.parametrize("kind", [each for each in TYPES if each in ROS_1_STORE.types])
def test_definitions_of_ros_1_have_the_sums_that_ros_1_compares(kind):
    """Its types have other sums where a field is spelt in another way."""
    ours = get_typestore(Stores.EMPTY)
    ours.register(get_types_from_msg(definition_text(kind, "ros1msg"), kind))
    _, sum_of_ours = ours.generate_msgdef(kind, ros_version=1)
    text, _ = ROS_1_STORE.generate_msgdef(kind, ros_version=1)
    fields = re.sub(r"^[^\n=]*=(?!=)[^\n]*\n", "", text, flags=re.MULTILINE)  # constants
    without = get_typestore(Stores.EMPTY)
    without.register(get_types_from_msg(fields, kind))
    assert sum_of_ours == without.generate_msgdef(kind, ros_version=1)[1]


def test_a_field_that_a_message_lacks_is_zero():
    payload = encoder_of("geometry_msgs/Twist", "ros1").encode({"linear": {"x": 0.5}})
    assert payload == np.array([0.5, 0, 0, 0, 0, 0]).tobytes()


def test_what_does_not_fit_is_refused():
    with pytest.raises(RosMessageError, match="Twist"):
        encoder_of("geometry_msgs/Twist", "ros1").encode({"linear": {"x": "fast"}})
    with pytest.raises(RosMessageError, match="json"):
        encoder_of("geometry_msgs/Twist", "json")
    with pytest.raises(RosMessageError, match="Twisted"):
        definition_text("geometry_msgs/msg/Twisted", "ros2msg")
