"""The action of the simulated robot's own navigation, behind the bridge: Nav2's or move_base's.

This file needs the extra "tools". Nav2's own service `get_result` answers at the end of a goal.
This one refuses to answer before, as the server of foxglove-sdk would wait in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

import foxglove
import numpy as np

from hub.errors import RosMessageError
from hub.gcm.geometry import Point3D, Pose3D, Quaternion, Twist
from hub.gcm.orientation import roll_pitch_yaw
from hub.gcm.standard import MAP, Header, Time
from hub.robots.simulated_ros.flavour import RosFlavour
from hub.robots.simulated_ros.own_navigation import PERIOD, SimulatedNavigation
from hub.robots.simulated_ros.robot import SimulatedRosRobot
from hub.ros import goal_messages as wire
from hub.ros.goal_messages import GoalPlace, GoalStatus, goal_reader, goal_text, goal_writer
from hub.ros.schema import full_name
from hub.ros.values import RosValue

NAV2: Final = "/navigate_to_pose"
MOVE_BASE: Final = "/move_base"
_NODES: Final = {NAV2: "/bt_navigator", MOVE_BASE: "/move_base"}
_FEEDBACK_S: Final = 0.1
_OLD_LIST_S: Final = 0.2
"""Time between two messages of feedback, and of the list in ROS 1 [s]."""
_NEW: Final = {
    GoalStatus.WAITS: 1,
    GoalStatus.DRIVES: 2,
    GoalStatus.CANCELS: 3,
    GoalStatus.REACHED: 4,
    GoalStatus.CANCELLED: 5,
    GoalStatus.ABORTED: 6,
}
_OLD: Final = {
    GoalStatus.WAITS: 0,
    GoalStatus.DRIVES: 1,
    GoalStatus.CANCELLED: 2,
    GoalStatus.REACHED: 3,
    GoalStatus.ABORTED: 4,
    GoalStatus.REFUSED: 5,
    GoalStatus.CANCELS: 6,
}


class GoalServer:
    """The action of one robot.

    Attributes:
        name: Its name.
        services: Its services, for the server of the bridge.
    """

    def __init__(
        self,
        robot: SimulatedRosRobot,
        flavour: RosFlavour,
        context: foxglove.Context,
        clock: Callable[[], float],
    ) -> None:
        """Offer the action.

        Args:
            robot: Its wheels, its map and its place.
            flavour: Its ROS.
            context: Where its topics are.
            clock: The time by the robot's clock [s since the epoch].
        """
        self._old = flavour.encoding == "ros1"
        self.name = MOVE_BASE if self._old else NAV2
        self._robot, self._flavour, self._clock = robot, flavour, clock
        self._navigation: SimulatedNavigation = robot.navigation(old=self._old)
        self._listed: object = None
        self._list_at = self._feedback_at = self._drive_at = -math.inf
        self._context = context
        kinds = self._kinds()
        self._channels = {topic: self._opened(topic, kind) for topic, kind in kinds.items()}
        self.services = (
            [] if self._old else [self._sending(), self._cancelling(), self._explaining()]
        )

    @property
    def topics(self) -> Mapping[str, str]:
        """The nodes that publish its topics, by their names."""
        return dict.fromkeys((self._status, self._feedback), _NODES[self.name])

    @property
    def taken(self) -> Mapping[str, str]:
        """The nodes that subscribe to its topics."""
        names = (f"{self.name}/goal", f"{self.name}/cancel") if self._old else ()
        return dict.fromkeys(names, _NODES[self.name])

    @property
    def goal(self) -> str:
        """The name of the goal that the robot drives to; empty: none."""
        return self._navigation.present

    def subscribed(self, topic: str) -> None:
        """Send a latched list again, for who has subscribed."""
        if topic == self._status:
            self._listed = None

    def received(self, topic: str, payload: bytes) -> None:
        """Take a message of a client; only ROS 1 has topics for that."""
        try:
            if topic == f"{self.name}/goal" and self._old:
                value = goal_reader(wire.OLD_GOAL, "ros1").decode(payload)
                self._begin(value.get("goal_id.id"), value.get("goal.target_pose"))
            elif topic == f"{self.name}/cancel" and self._old:
                value = goal_reader(wire.OLD_CANCEL, "ros1").decode(payload)
                self._navigation.cancel(value.get("id"))
        except RosMessageError:
            return

    def velocity(self, now: float) -> Twist | None:
        """The velocity that its node publishes now [s, monotonic]; None: none is due."""
        if now < self._drive_at:
            return None
        self._drive_at = now + PERIOD
        return self._navigation.velocity(self._robot.pose, self._robot.odom, PERIOD)

    def publish(self, now: float) -> None:
        """Publish the list of goals and the feedback that are due [s, monotonic]."""
        goals = self._navigation.goals
        if goals != self._listed or (self._old and now >= self._list_at):
            self._listed, self._list_at = goals, now + _OLD_LIST_S
            self._log(self._status, {"status_list": [self._state(each) for each in goals]})
        if self.goal and now >= self._feedback_at:
            self._feedback_at = now + _FEEDBACK_S
            self._log(self._feedback, self._feedback_values())

    @property
    def _status(self) -> str:
        return f"{self.name}/status" if self._old else f"{self.name}/_action/status"

    @property
    def _feedback(self) -> str:
        return f"{self.name}/feedback" if self._old else f"{self.name}/_action/feedback"

    def _kinds(self) -> dict[str, str]:
        """Its topics and their types, as ROS 2 writes them."""
        if not self._old:
            return {self._status: wire.STATUS, self._feedback: wire.FEEDBACK}
        return {
            self._status: wire.OLD_STATUS,
            self._feedback: wire.OLD_FEEDBACK,
            f"{self.name}/goal": wire.OLD_GOAL,
            f"{self.name}/cancel": wire.OLD_CANCEL,
        }

    def _opened(self, topic: str, kind: str) -> foxglove.Channel:
        flavour = self._flavour
        schema = foxglove.Schema(
            name=flavour.type_name(kind),
            encoding=flavour.schema_encoding,
            data=goal_text(kind, flavour.encoding).encode(),
        )
        return foxglove.Channel(
            topic, schema=schema, message_encoding=flavour.encoding, context=self._context
        )

    def _log(self, topic: str, values: Mapping[str, Any]) -> None:
        kind = full_name(self._kinds()[topic])
        payload = goal_writer(kind, self._flavour.encoding).encode(values)
        self._channels[topic].log(payload, log_time=int(self._clock() * 1e9))

    def _state(self, goal: wire.KnownGoal) -> dict[str, Any]:
        if self._old:
            return {"goal_id": {"id": goal.name}, "status": _OLD[goal.status], "text": goal.text}
        return {"goal_info": {"goal_id": _uuid(goal.name)}, "status": _NEW[goal.status]}

    def _feedback_values(self) -> dict[str, Any]:
        pose = self._robot.pose
        place = Pose3D(
            position=Point3D(x=pose.x, y=pose.y), orientation=Quaternion.of(0.0, 0.0, pose.theta)
        )
        here = {"header": Header(stamp=Time.of(self._clock()), frame_id=MAP), "pose": place}
        if self._old:
            status = {"goal_id": {"id": self.goal}, "status": _OLD[GoalStatus.DRIVES]}
            return {"status": status, "feedback": {"base_position": here}}
        left = self._navigation.left
        return {
            "goal_id": _uuid(self.goal),
            "current_pose": here,
            "distance_remaining": left if math.isfinite(left) else 0.0,
        }

    def _sending(self) -> foxglove.Service:
        def send(request: foxglove.ServiceRequest) -> bytes:
            value = goal_reader(f"{wire.SEND_GOAL}_Request", "cdr").decode(request.payload)
            name = bytes(value.get("goal_id.uuid")).hex()
            accepted = self._begin(name, value.get("pose"))
            answer = {"accepted": accepted, "stamp": Time.of(self._clock())}
            return goal_writer(f"{wire.SEND_GOAL}_Response", "cdr").encode(answer)

        return self._service("send_goal", wire.SEND_GOAL, send)

    def _cancelling(self) -> foxglove.Service:
        def cancel(request: foxglove.ServiceRequest) -> bytes:
            value = goal_reader(f"{wire.CANCEL_GOAL}_Request", "cdr").decode(request.payload)
            name = bytes(value.get("goal_info.goal_id.uuid"))
            found = self._navigation.cancel(name.hex() if any(name) else wire.EVERY_GOAL)
            answer = {"return_code": found.value, "goals_canceling": ()}
            return goal_writer(f"{wire.CANCEL_GOAL}_Response", "cdr").encode(answer)

        return self._service("cancel_goal", wire.CANCEL_GOAL, cancel)

    def _explaining(self) -> foxglove.Service:
        def explain(request: foxglove.ServiceRequest) -> bytes:
            value = goal_reader(f"{wire.GET_RESULT}_Request", "cdr").decode(request.payload)
            name = bytes(value.get("goal_id.uuid")).hex()
            found = self._navigation.end_of(name)
            if found is None:
                text = f"goal {name} has not ended"
                raise RosMessageError(text)
            status, failure = found
            answer = {
                "status": _NEW[status],
                "error_code": failure.code,
                "error_msg": failure.text,
            }
            return goal_writer(f"{wire.GET_RESULT}_Response", "cdr").encode(answer)

        return self._service("get_result", wire.GET_RESULT, explain)

    def _service(
        self, part: str, kind: str, handler: Callable[[foxglove.ServiceRequest], bytes]
    ) -> foxglove.Service:
        def message(name: str) -> foxglove.MessageSchema:
            schema = foxglove.Schema(
                name=name, encoding="ros2msg", data=goal_text(name, "cdr").encode()
            )
            return foxglove.MessageSchema(encoding="cdr", schema=schema)

        named = foxglove.ServiceSchema(
            name=kind, request=message(f"{kind}_Request"), response=message(f"{kind}_Response")
        )
        return foxglove.Service(f"{self.name}/_action/{part}", schema=named, handler=handler)

    def _begin(self, name: str, pose: RosValue) -> bool:
        turn = pose.get("pose.orientation")
        theta = roll_pitch_yaw(*(float(turn.get(part)) for part in "wxyz"))[2]
        place = GoalPlace(
            frame=pose.get("header.frame_id"),
            x=float(pose.get("pose.position.x")),
            y=float(pose.get("pose.position.y")),
            theta=theta,
        )
        return self._navigation.begin(name, place)


def _uuid(name: str) -> dict[str, Any]:
    """The UUID of a goal; zeros for a name that is none, which another client may give."""
    try:
        found = bytes.fromhex(name)
    except ValueError:
        found = b""
    return {"uuid": np.frombuffer(found if len(found) == 16 else bytes(16), np.uint8)}
