"""What Rune writes to Nav2 and move_base others read, and the other way round.

The oracle is rosbags. It knows the types of action_msgs and actionlib_msgs; those of nav2_msgs and
move_base_msgs are registered from their packages' definitions, with parts within parts.
"""

import math

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hub.errors import RosMessageError
from hub.ros import goal_messages as wire
from hub.ros.goal_messages import CancelAnswer, GoalPlace, GoalStatus, KnownGoal
from hub.ros.type_hashes import type_hash
from tests.support.cases import for_each

NAME = "72756e650123456789abcdef00112233"
UUID = np.frombuffer(bytes.fromhex(NAME), np.uint8)
PLACE = GoalPlace(frame="map", x=1.5, y=-2.0, theta=math.pi / 2)
NAV2 = "nav2_msgs/action/NavigateToPose_"
NEW_PARTS = {
    "Goal": "geometry_msgs/PoseStamped pose\nstring behavior_tree",
    "SendGoal_Request": f"unique_identifier_msgs/UUID goal_id\n{NAV2}Goal goal",
    "SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp",
    "Feedback": "geometry_msgs/PoseStamped current_pose\n"
    "builtin_interfaces/Duration navigation_time\n"
    "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\n"
    "float32 distance_remaining",
    "FeedbackMessage": f"unique_identifier_msgs/UUID goal_id\n{NAV2}Feedback feedback",
    "GetResult_Request": "unique_identifier_msgs/UUID goal_id",
    "Result": "uint16 error_code\nstring error_msg",
    "GetResult_Response": f"int8 status\n{NAV2}Result result",
    "HumbleResult": "std_msgs/Empty result",
    "HumbleGetResult_Response": f"int8 status\n{NAV2}HumbleResult result",
}
CANCEL = "action_msgs/msg/CancelGoal_"  # a store of rosbags has no services
OLD_PARTS = {
    "MoveBaseGoal": "geometry_msgs/PoseStamped target_pose",
    "MoveBaseActionGoal": "Header header\nactionlib_msgs/GoalID goal_id\nMoveBaseGoal goal",
    "MoveBaseFeedback": "geometry_msgs/PoseStamped base_position",
    "MoveBaseActionFeedback": "Header header\nactionlib_msgs/GoalStatus status\n"
    "MoveBaseFeedback feedback",
}


@pytest.fixture(scope="module")
def new():
    store = get_typestore(Stores.ROS2_JAZZY)
    for part, text in NEW_PARTS.items():
        store.register(get_types_from_msg(text, f"{NAV2}{part}"))
    store.register(get_types_from_msg("action_msgs/GoalInfo goal_info", f"{CANCEL}Request"))
    answer = "int8 return_code\naction_msgs/GoalInfo[] goals_canceling"
    store.register(get_types_from_msg(answer, f"{CANCEL}Response"))
    return store


@pytest.fixture(scope="module")
def old():
    store = get_typestore(Stores.ROS1_NOETIC)
    for part, text in OLD_PARTS.items():
        store.register(get_types_from_msg(text, f"move_base_msgs/msg/{part}"))
    return store


def the(store, name, **fields):
    """A message with these fields; all others are as their type begins."""

    def empty(kind, inner):
        if kind == 2:
            return the(store, inner)
        if kind == 1:
            return "" if inner[0] == "string" else 0
        (element, of), count = inner
        if kind == 4 and element == 2:
            return []
        return np.zeros(count if kind == 3 else 0, np.dtype(of[0] if element == 1 else "u1"))

    members = store.fielddefs[name][1]
    values = [fields.pop(field) if field in fields else empty(*kind) for field, kind in members]
    assert not fields
    return store.types[name](*values)


def new_goal(store, status, uuid=UUID):
    info = the(store, "action_msgs/msg/GoalInfo", goal_id=the_uuid(store, uuid))
    return the(store, "action_msgs/msg/GoalStatus", goal_info=info, status=status)


def the_uuid(store, uuid=UUID):
    return the(store, "unique_identifier_msgs/msg/UUID", uuid=uuid)


def old_goal(store, status, name=NAME, text=""):
    named = the(store, "actionlib_msgs/msg/GoalID", id=name)
    return the(store, "actionlib_msgs/msg/GoalStatus", goal_id=named, status=status, text=text)


def test_a_goal_of_ros_2_is_read_by_others(new):
    found = new.deserialize_cdr(wire.send_request(NAME, PLACE), f"{NAV2}SendGoal_Request")
    assert bytes(found.goal_id.uuid).hex() == NAME
    pose = found.goal.pose
    assert pose.header.frame_id == "map"
    assert (pose.header.stamp.sec, pose.header.stamp.nanosec) == (0, 0)
    assert (pose.pose.position.x, pose.pose.position.y) == (1.5, -2.0)
    assert (pose.pose.orientation.z, pose.pose.orientation.w) == pytest.approx((0.5**0.5,) * 2)
    assert found.goal.behavior_tree == ""


def test_a_result_of_nav2_says_why_a_goal_failed(new):
    asked = new.deserialize_cdr(wire.result_request(NAME), f"{NAV2}GetResult_Request")
    assert bytes(asked.goal_id.uuid).hex() == NAME
    kind = f"{NAV2}GetResult_Response"
    for code, text, why in (
        (208, "no path to the goal", "no path to the goal (error 208)"),
        (206, "", "an obstacle is at the place (error 206)"),
        (0, "", ""),
    ):
        result = the(new, f"{NAV2}Result", error_code=code, error_msg=text)
        answer = the(new, kind, status=6, result=result)
        assert wire.failure_of(bytes(new.serialize_cdr(answer, kind))) == why
    older = f"{NAV2}HumbleGetResult_Response"
    nothing = the(new, f"{NAV2}HumbleResult", result=the(new, "std_msgs/msg/Empty"))
    with pytest.raises(RosMessageError):
        wire.failure_of(bytes(new.serialize_cdr(the(new, older, status=6, result=nothing), older)))


def test_a_cancel_of_ros_2_names_one_goal_or_all(new):
    for name, uuid in ((NAME, NAME), (wire.EVERY_GOAL, "00" * 16)):
        found = new.deserialize_cdr(wire.cancel_request(name), f"{CANCEL}Request")
        assert bytes(found.goal_info.goal_id.uuid).hex() == uuid
        assert found.goal_info.stamp.sec == 0


def test_answers_of_ros_2_are_read(new):
    for accepted in (True, False):
        answer = the(new, f"{NAV2}SendGoal_Response", accepted=accepted)
        payload = bytes(new.serialize_cdr(answer, f"{NAV2}SendGoal_Response"))
        assert wire.was_accepted(payload) is accepted
    info = the(new, "action_msgs/msg/GoalInfo", goal_id=the_uuid(new))
    for code, wanted in enumerate(CancelAnswer):
        answer = the(new, f"{CANCEL}Response", return_code=code, goals_canceling=[info])
        payload = bytes(new.serialize_cdr(answer, f"{CANCEL}Response"))
        assert wire.cancel_answer(payload) is wanted
    answer = the(new, f"{CANCEL}Response", return_code=9)
    with pytest.raises(RosMessageError, match="unknown code 9"):
        wire.cancel_answer(bytes(new.serialize_cdr(answer, f"{CANCEL}Response")))


def test_states_of_ros_2_are_read_and_unknown_ones_left_out(new):
    other = np.arange(16, dtype=np.uint8)
    goals = [new_goal(new, status) for status in range(8)] + [new_goal(new, 2, other)]
    message = the(new, wire.STATUS, status_list=goals)
    found = wire.known_goals(bytes(new.serialize_cdr(message, wire.STATUS)), "cdr")
    assert [each.status for each in found] == [
        GoalStatus.WAITS,
        GoalStatus.DRIVES,
        GoalStatus.CANCELS,
        GoalStatus.REACHED,
        GoalStatus.CANCELLED,
        GoalStatus.ABORTED,
        GoalStatus.DRIVES,
    ]
    assert {each.name for each in found} == {NAME, bytes(other).hex()}


def test_feedback_says_whose_it_is_also_where_nav2_has_other_fields(new):
    feedback = the(new, f"{NAV2}Feedback", distance_remaining=2.5, number_of_recoveries=1)
    message = the(new, f"{NAV2}FeedbackMessage", goal_id=the_uuid(new), feedback=feedback)
    payload = bytes(new.serialize_cdr(message, f"{NAV2}FeedbackMessage"))
    assert wire.feedback_of(payload, "cdr") == (NAME, pytest.approx(2.5))
    later = (
        f"{NEW_PARTS['Feedback']}\nfloat32 position_tracking_error\nfloat32 heading_tracking_error"
    )
    store, kind = get_typestore(Stores.ROS2_JAZZY), f"{NAV2}FeedbackMessage"
    store.register(get_types_from_msg(later, f"{NAV2}Feedback"))
    store.register(get_types_from_msg(NEW_PARTS["FeedbackMessage"], kind))
    feedback = the(store, f"{NAV2}Feedback", distance_remaining=2.5, heading_tracking_error=0.5)
    message = the(store, kind, goal_id=the_uuid(store), feedback=feedback)
    payload = bytes(store.serialize_cdr(message, kind))
    assert wire.feedback_of(payload, "cdr") == (NAME, pytest.approx(2.5))
    name, left = wire.feedback_of(payload[:60], "cdr")
    assert name == NAME
    assert math.isnan(left)
    with pytest.raises(RosMessageError, match="too short"):
        wire.feedback_of(payload[:12], "cdr")


def test_a_goal_and_a_cancel_of_ros_1_are_read_by_others(old):
    kind = "move_base_msgs/msg/MoveBaseActionGoal"
    found = old.deserialize_ros1(wire.old_goal(NAME, PLACE), kind)
    assert found.goal_id.id == NAME
    pose = found.goal.target_pose
    assert pose.header.frame_id == "map"
    assert (pose.pose.position.x, pose.pose.orientation.w) == pytest.approx((1.5, 0.5**0.5))
    times = (found.goal_id.stamp, found.header.stamp, pose.header.stamp)
    assert all((each.sec, each.nanosec) == (0, 0) for each in times)
    for name in (NAME, wire.EVERY_GOAL):
        found = old.deserialize_ros1(wire.old_cancel(name), wire.OLD_CANCEL)
        assert (found.id, found.stamp.sec) == (name, 0)


def test_states_and_feedback_of_ros_1_are_read(old):
    goals = [old_goal(old, status, text=f"says \x1b{status}") for status in range(11)]
    message = the(old, wire.OLD_STATUS, status_list=goals)
    found = wire.known_goals(bytes(old.serialize_ros1(message, wire.OLD_STATUS)), "ros1")
    assert [each.status for each in found] == [
        GoalStatus.WAITS,
        GoalStatus.DRIVES,
        GoalStatus.CANCELLED,
        GoalStatus.REACHED,
        GoalStatus.ABORTED,
        GoalStatus.REFUSED,
        GoalStatus.CANCELS,
        GoalStatus.CANCELS,
        GoalStatus.CANCELLED,
        GoalStatus.ABORTED,
    ]
    assert found[4] == KnownGoal(name=NAME, status=GoalStatus.ABORTED, text="says \\x1b4")
    kind = "move_base_msgs/msg/MoveBaseActionFeedback"
    feedback = bytes(old.serialize_ros1(the(old, kind, status=old_goal(old, 1)), kind))
    name, left = wire.feedback_of(feedback, "ros1")
    assert name == NAME
    assert math.isnan(left)


@for_each("kind", [wire.STATUS, wire.OLD_STATUS, wire.OLD_CANCEL])
def test_definitions_that_the_oracle_has_are_those_of_rune(kind):
    """By their hash, which is over all fields."""
    assert type_hash(kind) == get_typestore(Stores.ROS2_JAZZY).hash_rihs01(kind)


@for_each("payload", [b"", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\xff" * 40])
def test_messages_that_make_no_sense_are_refused(payload):
    for read in (
        lambda: wire.known_goals(payload, "cdr"),
        lambda: wire.known_goals(payload[4:], "ros1"),
        lambda: wire.cancel_answer(payload),
    ):
        with pytest.raises(RosMessageError):
            read()
