"""Messages to and from a robot's own navigation: the action of Nav2, and move_base; pure.

| what | ROS 2, action NAME | ROS 1, action NAME |
| --- | --- | --- |
| send a goal | service NAME/_action/send_goal | topic NAME/goal |
| cancel one goal, or all | service NAME/_action/cancel_goal | topic NAME/cancel |
| the states of all goals | topic NAME/_action/status, at each change | topic NAME/status, 5 Hz |
| a goal goes on | topic NAME/_action/feedback | topic NAME/feedback |
| why a goal failed | service NAME/_action/get_result | in its state |

A goal has a name of 32 hexadecimal digits: the bytes of its UUID in ROS 2, its `id` in ROS 1.
Times are 0: ROS 1 ends goals with older times at a cancel, and clocks differ.
"""

from __future__ import annotations

import contextlib
import enum
import functools
import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from hub.errors import RosMessageError
from hub.gcm.geometry import Point3D, Pose3D, Quaternion
from hub.gcm.standard import Header, Time
from hub.plain_text import plain
from hub.ros.decoding import RosDecoder
from hub.ros.definition_texts import definition_text
from hub.ros.encoding import RosEncoder, encoder_of
from hub.values import dataclass

SEND_GOAL: Final = "nav2_msgs/action/NavigateToPose_SendGoal"
CANCEL_GOAL: Final = "action_msgs/srv/CancelGoal"
GET_RESULT: Final = "nav2_msgs/action/NavigateToPose_GetResult"
FEEDBACK: Final = "nav2_msgs/action/NavigateToPose_FeedbackMessage"
STATUS: Final = "action_msgs/msg/GoalStatusArray"
OLD_GOAL: Final = "move_base_msgs/msg/MoveBaseActionGoal"
OLD_CANCEL: Final = "actionlib_msgs/msg/GoalID"
OLD_FEEDBACK: Final = "move_base_msgs/msg/MoveBaseActionFeedback"
OLD_RESULT: Final = "move_base_msgs/msg/MoveBaseActionResult"
OLD_STATUS: Final = "actionlib_msgs/msg/GoalStatusArray"
"""Types of ROS 2, then of ROS 1."""
EVERY_GOAL: Final = ""
"""Stands for the name of a goal where all are cancelled."""
MOST_GOALS: Final = 1000
"""Most goals that are read of one message."""
TYPES: Final[Mapping[str, str]] = {
    f"{SEND_GOAL}_Request": "unique_identifier_msgs/UUID goal_id\ngeometry_msgs/PoseStamped pose\n"
    "string behavior_tree\n",
    f"{SEND_GOAL}_Response": "bool accepted\nbuiltin_interfaces/Time stamp\n",
    f"{CANCEL_GOAL}_Request": "action_msgs/GoalInfo goal_info\n",
    f"{CANCEL_GOAL}_Response": "int8 return_code\naction_msgs/GoalInfo[] goals_canceling\n",
    f"{GET_RESULT}_Request": "unique_identifier_msgs/UUID goal_id\n",
    f"{GET_RESULT}_Response": "int8 status\nuint16 error_code\nstring error_msg\n",
    FEEDBACK: "unique_identifier_msgs/UUID goal_id\ngeometry_msgs/PoseStamped current_pose\n"
    "builtin_interfaces/Duration navigation_time\n"
    "builtin_interfaces/Duration estimated_time_remaining\n"
    "int16 number_of_recoveries\nfloat32 distance_remaining\n",
    OLD_GOAL: "std_msgs/Header header\nactionlib_msgs/GoalID goal_id\n"
    "move_base_msgs/MoveBaseGoal goal\n",
    "move_base_msgs/msg/MoveBaseGoal": "geometry_msgs/PoseStamped target_pose\n",
    OLD_FEEDBACK: "std_msgs/Header header\nactionlib_msgs/GoalStatus status\n"
    "move_base_msgs/MoveBaseFeedback feedback\n",
    "move_base_msgs/msg/MoveBaseFeedback": "geometry_msgs/PoseStamped base_position\n",
    OLD_RESULT: "std_msgs/Header header\nactionlib_msgs/GoalStatus status\n"
    "move_base_msgs/MoveBaseResult result\n",
    "move_base_msgs/msg/MoveBaseResult": "# nothing\n",
}
"""Fields of the types that `known_types` lacks; of action types the parts stand in one."""


class GoalStatus(enum.Enum):
    """The state of a goal at the robot's own navigation."""

    WAITS = "waits"
    DRIVES = "drives"
    CANCELS = "is being cancelled"
    REACHED = "reached"
    CANCELLED = "cancelled"
    ABORTED = "aborted"
    REFUSED = "refused"

    @property
    def ended(self) -> bool:
        """Whether the robot drives to it no more."""
        return self not in (GoalStatus.WAITS, GoalStatus.DRIVES, GoalStatus.CANCELS)


_NEW_STATUS: Final = {
    1: GoalStatus.WAITS,
    2: GoalStatus.DRIVES,
    3: GoalStatus.CANCELS,
    4: GoalStatus.REACHED,
    5: GoalStatus.CANCELLED,
    6: GoalStatus.ABORTED,
}
_OLD_STATUS: Final = {
    0: GoalStatus.WAITS,
    1: GoalStatus.DRIVES,
    2: GoalStatus.CANCELLED,
    3: GoalStatus.REACHED,
    4: GoalStatus.ABORTED,
    5: GoalStatus.REFUSED,
    6: GoalStatus.CANCELS,
    7: GoalStatus.CANCELS,
    8: GoalStatus.CANCELLED,
    9: GoalStatus.ABORTED,
}
"""Numbers of action_msgs/GoalStatus, and of actionlib_msgs/GoalStatus."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownGoal:
    """A goal in the states that the robot's own navigation publishes.

    Attributes:
        name: Its name.
        status: Its state.
        text: What is said of it, in plain text.
    """

    name: str
    status: GoalStatus
    text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalPlace:
    """Where a robot has to stand.

    Attributes:
        frame: Name of its frame.
        x: Position there [m].
        y: Position there [m].
        theta: Heading there [rad].
    """

    frame: str
    x: float
    y: float
    theta: float


class CancelAnswer(enum.Enum):
    """The answer of ROS 2 to a cancel: it begins, it is refused, there is nothing to cancel."""

    BEGINS = 0
    REFUSED = 1
    UNKNOWN = 2
    ENDED = 3


def send_request(name: str, place: GoalPlace) -> bytes:
    """The request of ROS 2 to drive to a place."""
    return _writer(f"{SEND_GOAL}_Request", "cdr").encode(
        {"goal_id": _uuid(name), "pose": _pose(place), "behavior_tree": ""}
    )


def was_accepted(payload: bytes | memoryview) -> bool:
    """Whether ROS 2 takes a goal, by the answer to `send_request`."""
    return bool(_reader(f"{SEND_GOAL}_Response", "cdr").decode(payload).get("accepted"))


def cancel_request(name: str) -> bytes:
    """The request of ROS 2 to cancel a goal, or `EVERY_GOAL`."""
    return _writer(f"{CANCEL_GOAL}_Request", "cdr").encode({"goal_info": {"goal_id": _uuid(name)}})


def cancel_answer(payload: bytes | memoryview) -> CancelAnswer:
    """The answer to `cancel_request`."""
    code = int(_reader(f"{CANCEL_GOAL}_Response", "cdr").decode(payload).get("return_code"))
    if code not in {each.value for each in CancelAnswer}:
        text = f"the answer to a cancel has the unknown code {code}"
        raise RosMessageError(text)
    return CancelAnswer(code)


def result_request(name: str) -> bytes:
    """The request of ROS 2 to say how a goal ended; the answer comes after its end."""
    return _writer(f"{GET_RESULT}_Request", "cdr").encode({"goal_id": _uuid(name)})


def failure_of(payload: bytes | memoryview) -> str:
    """Why a goal failed, by the answer to `result_request`, in plain text; empty: it is not said.

    Raises:
        RosMessageError: The answer is none of Nav2 from Jazzy on; before, it says nothing.
    """
    value = _reader(f"{GET_RESULT}_Response", "cdr").decode(payload)
    code, said = int(value.get("error_code")), plain(value.get("error_msg").strip())
    if not code:
        return said[:_LONGEST_TEXT]
    return f"{(said or _FAILURES.get(code, 'it failed'))[:_LONGEST_TEXT]} (error {code})"


def old_goal(name: str, place: GoalPlace) -> bytes:
    """The message of ROS 1 to drive to a place."""
    return _writer(OLD_GOAL, "ros1").encode(
        {"goal_id": {"id": name}, "goal": {"target_pose": _pose(place)}}
    )


def old_cancel(name: str) -> bytes:
    """The message of ROS 1 to cancel a goal, or `EVERY_GOAL`."""
    return _writer(OLD_CANCEL, "ros1").encode({"id": name})


def known_goals(payload: bytes | memoryview, encoding: str) -> tuple[KnownGoal, ...]:
    """The goals in a message of states, "cdr" or "ros1"; states that are not known are left out."""
    old = encoding == "ros1"
    value = _reader(OLD_STATUS if old else STATUS, encoding).decode(payload)
    numbers, found = (_OLD_STATUS if old else _NEW_STATUS), []
    for each in value.get("status_list")[:MOST_GOALS]:
        status = numbers.get(int(each.get("status")))
        if status is not None:
            name = each.get("goal_id.id") if old else _name(each.get("goal_info.goal_id.uuid"))
            text = plain(each.get("text"))[:_LONGEST_TEXT] if old else ""
            found.append(KnownGoal(name=name, status=status, text=text))
    return tuple(found)


def feedback_of(payload: bytes | memoryview, encoding: str) -> tuple[str, float]:
    """The name of the goal in a feedback, and the way that is left [m]; NaN: it is not said."""
    if encoding == "ros1":
        return _reader(OLD_FEEDBACK, encoding).decode(payload).get("status.goal_id.id"), math.nan
    name = bytes(payload[4:20])  # before all fields that versions of Nav2 have or lack
    if len(name) < _UUID_BYTES:
        text = "a feedback is too short for the name of its goal"
        raise RosMessageError(text)
    for later in (0, _LATER_BYTES):
        with contextlib.suppress(RosMessageError):
            value = _reader(FEEDBACK, "cdr").decode(payload[: len(payload) - later])
            left = float(value.get("distance_remaining"))
            return name.hex(), left if 0.0 <= left <= _FARTHEST_M else math.nan
    return name.hex(), math.nan


def goal_text(name: str, encoding: str) -> str:
    """The definition of a type of this file, or of a known one."""
    return definition_text(name, _SCHEMAS[encoding], TYPES)


def goal_writer(name: str, encoding: str) -> RosEncoder:
    """Writes messages of a type of this file, or of a known one, "cdr" or "ros1"."""
    return _writer(name, encoding)


def goal_reader(name: str, encoding: str) -> RosDecoder:
    """Reads messages of a type of this file, or of a known one, "cdr" or "ros1"."""
    return _reader(name, encoding)


_SCHEMAS: Final = {"cdr": "ros2msg", "ros1": "ros1msg"}
_UUID_BYTES: Final = 16
_LATER_BYTES: Final = 8
"""Of the two errors of tracking with which later versions of Nav2 end a feedback."""
_FARTHEST_M: Final = 1e6
_LONGEST_TEXT: Final = 200
_FAILURES: Final = {
    102: "its controller does not know where it is",
    103: "its controller cannot follow the path",
    104: "no velocity was possible for too long",
    105: "it made no headway",
    106: "no velocity was possible",
    202: "its planner does not know where it is",
    203: "it stands outside of its map",
    204: "the place is outside of its map",
    205: "an obstacle is where it stands",
    206: "an obstacle is at the place",
    207: "its planner needed too long",
    208: "there is no path to the place",
    9002: "it does not know where it is",
    9003: "it needed too long",
}
"""Error codes of Nav2 from Jazzy on: FollowPath, ComputePathToPose, NavigateToPose."""


@dataclass(frozen=True, slots=True)
class _DescribedGoal:
    """A type as `RosDecoder.of` takes it."""

    schema_name: str
    encoding: str

    @property
    def schema_encoding(self) -> str:
        return _SCHEMAS[self.encoding]

    @property
    def schema(self) -> bytes:
        return goal_text(self.schema_name, self.encoding).encode()


@functools.cache
def _writer(name: str, encoding: str) -> RosEncoder:
    return encoder_of(name, encoding, goal_text(name, encoding))


@functools.cache
def _reader(name: str, encoding: str) -> RosDecoder:
    return RosDecoder.of(_DescribedGoal(name, encoding))


def _pose(place: GoalPlace) -> dict[str, Any]:
    pose = Pose3D(
        position=Point3D(x=place.x, y=place.y), orientation=Quaternion.of(0.0, 0.0, place.theta)
    )
    return {"header": Header(stamp=Time(), frame_id=place.frame), "pose": pose}


def _uuid(name: str) -> dict[str, Any]:
    """The UUID of a goal's name; zeros stand for every goal."""
    found = bytes.fromhex(name) if name else bytes(_UUID_BYTES)
    return {"uuid": np.frombuffer(found, np.uint8)}


def _name(uuid: npt.NDArray[np.uint8]) -> str:
    return uuid.tobytes().hex()
