"""The body of a robot with ROS whose own navigation drives to goals, on a line in memory."""

import struct
from collections import Counter

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.gcm.geometry import (
    Point3D,
    Pose3D,
    PoseWithCovariance,
    Quaternion,
    Twist,
)
from hub.gcm.odometry import Odometry
from hub.gcm.own_navigation import DriveGoal, OwnGoal
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import Transform, Transforms, TransformStamped, Translation
from hub.robots.interfaces import BodyNavigates
from hub.robots.ros.body import RosBody
from hub.robots.ros.line import RosService
from hub.ros import goal_messages as wire
from hub.ros.goal_messages import goal_reader, goal_writer
from tests.support.memory_ros_line import MemoryLine, cdr, ros_robot

ZERO, AHEAD = Twist(), Twist.planar(0.4, 0.0)
GOAL = DriveGoal(number=7, x=2.0, y=1.0, theta=0.5)
NAV2, MOVE_BASE = "/navigate_to_pose", "/move_base"
ACTION = f"{NAV2}/_action/"
DRIVES, CANCELLED, ABORTED = 2, 5, 6
OTHER = "ff" * 16


class NavigatingRobot:
    """A body with the key `navigation`, its line, and the time."""

    def __init__(self, tmp_path, name=NAV2, more="", encoding="cdr"):
        self.now = 100.0
        self.line = MemoryLine(encodings=encoding)
        self.line.topic("/cmd_vel", "geometry_msgs/msg/Twist")
        if encoding == "cdr":
            self.line.topic("/odom", "nav_msgs/msg/Odometry")
        text = f'[ros]\naddress = "ws://127.0.0.1:8765"\nnavigation = "{name}"\n{more}'
        self.body = RosBody(ros_robot(tmp_path, text), self.line, lambda: self.now)
        self.run(0.1)

    def has_nav2(self):
        for part, kind in (("status", wire.STATUS), ("feedback", wire.FEEDBACK)):
            self.line.topic(f"{ACTION}{part}", kind)
        for part, kind in (("send_goal", wire.SEND_GOAL), ("cancel_goal", wire.CANCEL_GOAL)):
            self.line.services[f"{ACTION}{part}"] = RosService(name=f"{ACTION}{part}", type=kind)
        self.run(0.05)

    def has_result(self, kind=wire.GET_RESULT):
        service = f"{ACTION}get_result"
        self.line.services[service] = RosService(name=service, type=kind)
        self.run(0.05)

    def explains(self, payload):
        """Answer why a goal failed."""
        asked = (each for each in self.line.called[::-1] if each[0].endswith("get_result"))
        _, _, answered = next(asked)
        answered(payload, "" if payload is not None else "no answer")

    def run(self, seconds, tick=0.01):
        for _ in range(round(seconds / tick)):
            self.now += tick
            self.body.advance(tick)

    def drive(self, goal=GOAL):
        """Take a goal, as Nav2 does."""
        self.body.command(ZERO)
        self.run(2.0)
        self.line.sent("/cmd_vel")
        self.body.go(goal)
        self.answer("send_goal", {"accepted": True})
        self.lists((self.name, DRIVES))

    @property
    def calls(self):
        return [(name.removeprefix(ACTION), payload) for name, payload, _ in self.line.called]

    @property
    def name(self):
        sent = [payload for part, payload in self.calls if part == "send_goal"]
        return self.goal_of(sent[-1], "SendGoal_Request", "goal_id.uuid")

    def cancels(self):
        """The names of the goals that were cancelled; empty: of all."""
        sent = [payload for part, payload in self.calls if part == "cancel_goal"]
        kind = f"{wire.CANCEL_GOAL}_Request"
        found = [goal_reader(kind, "cdr").decode(each) for each in sent]
        names = [bytes(each.get("goal_info.goal_id.uuid")).hex() for each in found]
        return ["" if each == "00" * 16 else each for each in names]

    def goal_of(self, payload, kind, field):
        kind = wire.SEND_GOAL.replace("SendGoal", kind)
        return bytes(goal_reader(kind, "cdr").decode(payload).get(field)).hex()

    def answer(self, part, values):
        kind = {"send_goal": wire.SEND_GOAL, "cancel_goal": wire.CANCEL_GOAL}[part]
        _, _, answered = next(each for each in self.line.called[::-1] if each[0].endswith(part))
        answered(goal_writer(f"{kind}_Response", "cdr").encode(values), "")

    def lists(self, *goals):
        infos = [
            {
                "goal_info": {"goal_id": {"uuid": np.frombuffer(bytes.fromhex(name), np.uint8)}},
                "status": status,
            }
            for name, status in goals
        ]
        payload = goal_writer(wire.STATUS, "cdr").encode({"status_list": infos})
        self.line.give(f"{ACTION}status", payload, self.now)
        self.run(0.02)

    def goes_on(self, left=1.5):
        uuid = np.frombuffer(bytes.fromhex(self.name), np.uint8)
        values = {"goal_id": {"uuid": uuid}, "distance_remaining": left}
        payload = goal_writer(wire.FEEDBACK, "cdr").encode(values)
        self.line.give(f"{ACTION}feedback", payload, self.now)

    @property
    def velocities(self):
        """What was sent since the last look: how many zeros, and how many others."""
        sent = self.line.sent("/cmd_vel")
        return Counter("zero" if not any(each[4:]) else "moves" for each in sent)

    @property
    def report(self):
        return self.body.own_navigation()

    @property
    def problems(self):
        found = self.body.sensors(1e9).diagnostics
        return [each.message for each in found if each.name == "own navigation"]


@pytest.fixture(autouse=True)
def runtime_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def robot(tmp_path):
    made = NavigatingRobot(tmp_path)
    made.has_nav2()
    return made


def test_without_the_action_goals_stay_with_rune_and_the_operator_learns_why(tmp_path):
    robot = NavigatingRobot(tmp_path)
    assert isinstance(robot.body, BodyNavigates)
    robot.run(3.0)
    assert not robot.report.available
    assert "include_hidden:=true; goals go to Rune's own navigation" in robot.problems[0]
    robot.line.services[f"{ACTION}send_goal"] = RosService(
        name=f"{ACTION}send_goal", type=wire.SEND_GOAL
    )
    robot.run(0.1)
    assert f"lacks {ACTION}cancel_goal, {ACTION}status" in robot.problems[0]
    robot.has_nav2()
    assert robot.report.available
    assert not robot.problems


def test_without_the_key_nothing_of_it_is_asked_for(tmp_path):
    robot = NavigatingRobot(tmp_path, name="")
    robot.has_nav2()
    assert not any("_action" in each or "move_base" in each for each in robot.line.takers)
    assert not robot.report.available
    assert not robot.problems


def test_no_velocity_is_sent_while_the_robot_drives_itself(robot):
    robot.drive()
    for _ in range(20):
        robot.run(0.2)
        robot.goes_on()
        robot.body.go(GOAL)
    assert not robot.velocities
    assert robot.body.sensors(1e9).vehicle.activity == "navigates"
    report = robot.report
    assert (report.number, report.goal, report.distance_left) == (7, OwnGoal.DRIVES, 1.5)
    assert [part for part, _ in robot.calls] == ["send_goal"]


def test_a_command_cancels_first_and_then_zeros_for_a_second(robot):
    robot.drive()
    before = len(robot.line.published)
    robot.body.command(ZERO)
    assert robot.cancels() == [robot.name]
    assert len(robot.line.published) == before + 1
    robot.run(3.0)
    assert robot.velocities == {"zero": 21}


def test_a_stick_moves_the_robot_once_the_goal_has_ended(robot):
    robot.drive()
    robot.body.command(AHEAD)
    assert robot.cancels() == [robot.name]
    robot.run(0.2)
    robot.body.command(AHEAD)
    assert set(robot.velocities) == {"zero"}
    robot.lists((robot.name, CANCELLED))
    robot.body.command(AHEAD)
    robot.run(0.2)
    assert set(robot.velocities) == {"moves"}


def test_a_stick_is_not_held_up_for_ever_by_a_robot_that_does_not_acknowledge(robot):
    robot.drive()
    robot.body.command(AHEAD)
    robot.run(1.1)
    assert "not acknowledged: the robot may still drive to it" in robot.problems[0]
    assert robot.report.unanswered
    robot.velocities  # noqa: B018 - those so far
    robot.body.command(AHEAD)
    robot.run(0.1)
    assert set(robot.velocities) == {"moves"}
    assert robot.cancels() == [robot.name] * 2


def test_a_stop_cancels_every_goal_and_goals_of_others_are_named_before(robot):
    robot.lists((OTHER, DRIVES))
    assert "another node sent the robot to 1 goal" in robot.problems[0]
    assert robot.report.others == 1
    robot.body.command(ZERO)
    assert not robot.cancels()
    robot.body.stop()
    assert robot.cancels() == [""]
    robot.lists((OTHER, CANCELLED))
    assert not robot.problems


def test_a_robot_that_falls_silent_about_its_goal_is_said_and_then_cancelled(robot):
    robot.drive()
    robot.run(2.0)
    assert "silent for 2 s about its goal" in robot.problems[0]
    assert not robot.velocities
    robot.run(1.2)
    assert robot.report.goal is OwnGoal.LOST
    assert robot.cancels() == [robot.name]
    assert set(robot.velocities) == {"zero"}


def test_after_a_lost_line_the_goal_is_cancelled_by_its_name_and_not_sent_again(robot):
    robot.drive()
    robot.line.lose()
    robot.run(2.0)
    assert robot.report.goal is OwnGoal.LOST
    assert not robot.report.available
    assert any("not acknowledged" in each for each in robot.problems)
    robot.body.go(GOAL)
    robot.line.find()
    robot.run(0.1)
    assert robot.cancels() == [robot.name]
    robot.body.go(GOAL)
    robot.run(0.5)
    assert [part for part, _ in robot.calls].count("send_goal") == 1
    assert robot.report.goal is OwnGoal.LOST


def test_agoal_of_the_process_before_is_cancelled_by_the_next_one(robot, tmp_path):
    robot.drive()
    following = NavigatingRobot(tmp_path)
    following.has_nav2()
    following.lists((robot.name, DRIVES))
    assert following.cancels() == [robot.name]


def test_messages_that_make_no_sense_are_said_and_end_nothing(robot):
    robot.drive()
    for part in ("status", "feedback"):
        robot.line.give(f"{ACTION}{part}", b"\0\1\0\0\xff\xff\xff\xff", robot.now)
        robot.run(0.1)
        assert any("cannot be used" in each for each in robot.problems)
    _, _, answered = robot.line.called[-1]
    answered(b"\0", "")
    assert robot.report.goal is OwnGoal.DRIVES


def result(code=208, text="no path"):
    values = {"status": ABORTED, "error_code": code, "error_msg": text}
    return goal_writer(f"{wire.GET_RESULT}_Response", "cdr").encode(values)


GAVE_UP = "the robot's own navigation gave up"


def test_nav2_says_why_it_gave_up(robot):
    robot.has_result()
    robot.drive()
    name = robot.name
    robot.lists((name, ABORTED))
    assert (robot.report.goal, robot.report.why) == (OwnGoal.ABORTED, GAVE_UP)
    (asked,) = [payload for part, payload in robot.calls if part == "get_result"]
    assert robot.goal_of(asked, "GetResult_Request", "goal_id.uuid") == name
    robot.explains(result())
    assert robot.report.why == f"{GAVE_UP}: no path (error 208)"
    robot.body.command(ZERO)
    robot.run(3.0)
    assert robot.report.why == f"{GAVE_UP}: no path (error 208)"
    assert not robot.cancels()


HUMBLE = b"\0\1\0\0\x06\0"
UNKNOWN = b"\0\1\0\0\0\0\0\0\0\0\0\0"


@pytest.mark.parametrize(
    "answer",
    [None, HUMBLE, UNKNOWN, b"", b"\0", result(code=0, text=""), result(text="x") + bytes(99)],
)
def test_a_robot_that_gives_no_reason_is_as_one_without_that_service(robot, answer):
    robot.has_result()
    robot.drive()
    robot.lists((robot.name, ABORTED))
    robot.explains(answer)
    robot.run(0.1)
    assert (robot.report.goal, robot.report.why) == (OwnGoal.ABORTED, GAVE_UP)
    assert not robot.problems


@pytest.mark.parametrize("kind", ["", "other_msgs/action/Go_GetResult"])
def test_a_robot_without_that_service_is_not_asked(robot, kind):
    if kind:
        robot.has_result(kind)
    robot.drive()
    robot.lists((robot.name, ABORTED))
    robot.run(0.1)
    assert [part for part, _ in robot.calls] == ["send_goal"]


def test_a_stop_and_the_next_goal_do_not_wait_for_a_reason(robot):
    robot.has_result()
    robot.drive()
    robot.lists((robot.name, ABORTED))
    robot.body.go(DriveGoal(number=8, x=1.0, y=1.0, theta=0.0))
    assert [part for part, _ in robot.calls] == ["send_goal", "get_result", "send_goal"]
    robot.body.stop()
    assert robot.cancels() == [robot.name, ""]
    robot.answer("send_goal", {"accepted": True})
    robot.lists((robot.name, ABORTED))
    assert [part for part, _ in robot.calls].count("get_result") == 1


def test_the_reason_of_a_robot_is_plain_and_short(robot):
    robot.has_result()
    robot.drive()
    robot.lists((robot.name, ABORTED))
    robot.explains(result(code=7, text="\x1b[2J\n" + "x" * 1000))
    why = robot.report.why
    assert why.isprintable()
    assert len(why) < 260
    assert "xx (error 7)" in why


def test_a_code_without_a_text_has_words():
    assert wire.failure_of(result(206, "")) == "an obstacle is at the place (error 206)"
    assert wire.failure_of(result(4711, "")) == "it failed (error 4711)"
    assert wire.failure_of(result(0, "some text")) == "some text"


def test_a_goal_is_in_the_frame_of_the_robots_map_once_its_place_is_known(tmp_path):
    robot = NavigatingRobot(tmp_path, more='map = "/map"\n')
    robot.has_nav2()
    robot.line.topic("/tf", "tf2_msgs/msg/TFMessage")

    def framed():
        sent = next(payload for part, payload in robot.calls[::-1] if part == "send_goal")
        pose = goal_reader(f"{wire.SEND_GOAL}_Request", "cdr").decode(sent).get("pose")
        return pose.get("header.frame_id"), pose.get("pose.position.x")

    robot.drive()
    assert framed() == ("odom", 2.0)
    moved = Transform(translation=Translation(x=5.0), rotation=Quaternion.of(0.0, 0.0, 0.0))
    header = Header(stamp=Time.of(robot.now), frame_id="map")
    frames = TransformStamped(header=header, child_frame_id="odom", transform=moved)
    robot.line.give("/tf", cdr(Transforms(transforms=(frames,))), robot.now)
    pose = PoseWithCovariance(pose=Pose3D(position=Point3D(x=1.0)))
    robot.line.give("/odom", cdr(Odometry(header=Header(stamp=header.stamp), pose=pose)), robot.now)
    assert robot.body.sensors(1e9).x == 6.0
    robot.lists((robot.name, CANCELLED))
    robot.drive(DriveGoal(number=8, x=2.0, y=1.0, theta=0.0))
    assert framed() == ("map", 2.0)


def test_move_base_gets_the_same_by_its_topics(tmp_path):
    robot = NavigatingRobot(tmp_path, name=MOVE_BASE, encoding="ros1")
    status, feedback = f"{MOVE_BASE}/status", f"{MOVE_BASE}/feedback"
    robot.line.topic(status, wire.OLD_STATUS)
    robot.line.topics[feedback] = robot.line.topics[status].__class__(
        name=feedback, schema_name="move_base_msgs/MoveBaseActionFeedback", encoding="ros1"
    )
    robot.run(0.1)
    assert robot.report.available
    assert robot.line.advertised[f"{MOVE_BASE}/goal"] == wire.OLD_GOAL

    def lists(*goals):
        values = [{"goal_id": {"id": name}, "status": status} for name, status in goals]
        payload = goal_writer(wire.OLD_STATUS, "ros1").encode({"status_list": values})
        robot.line.give(status, payload, robot.now)
        robot.run(0.2)

    lists((OTHER, 3))
    robot.body.go(GOAL)
    goal = goal_reader(wire.OLD_GOAL, "ros1").decode(robot.line.sent(f"{MOVE_BASE}/goal")[0])
    name = goal.get("goal_id.id")
    assert goal.get("goal.target_pose.pose.position.x") == 2.0
    lists((name, 1))
    assert robot.report.goal is OwnGoal.DRIVES
    robot.body.stop()
    names = [
        goal_reader(wire.OLD_CANCEL, "ros1").decode(each).get("id")
        for each in robot.line.sent(f"{MOVE_BASE}/cancel")
    ]
    assert names == [name, ""]
    lists((name, 2))
    assert not robot.report.ending
    assert robot.report.goal is OwnGoal.CANCELLED
    robot.run(4.0)
    assert any("/move_base is silent" in each for each in robot.problems)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    payload=st.binary(max_size=120),
    what=st.sampled_from(["status", "feedback", "answer", "result"]),
)
def test_no_bytes_of_the_robot_end_the_driver(tmp_path, payload, what):
    robot = NavigatingRobot(tmp_path)
    robot.has_nav2()
    robot.has_result()
    robot.drive()
    if what == "result":
        robot.lists((robot.name, ABORTED))
        robot.explains(payload)
    elif what == "answer":
        robot.body.stop()
        for _, _, answered in robot.line.called:
            answered(payload, "")
    else:
        robot.line.give(f"{ACTION}{what}", b"\0\1\0\0" + payload, robot.now)
    robot.run(1.2, tick=0.1)
    assert robot.report.number == GOAL.number
    robot.body.command(ZERO)
    robot.body.stop()
    assert robot.problems is not None


@given(name=st.binary(max_size=40))
def test_names_of_goals_of_others_in_ros_1_may_be_any_bytes(name):
    """They are cancelled at a stop, so they have to go back."""
    size = struct.pack("<I", len(name))
    listed = bytes(16) + struct.pack("<I", 1) + bytes(8) + size + name + b"\1" + bytes(4)
    try:
        (goal,) = wire.known_goals(listed, "ros1")
    except RosMessageError:
        return
    assert isinstance(wire.old_cancel(goal.name), bytes)
