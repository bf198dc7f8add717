"""The body of a robot with ROS on a line in memory: what it measures, follows and says."""

import math
import struct
from typing import Any

import numpy as np
import pytest

from hub.gcm.battery import BatteryState
from hub.gcm.diagnostics import Diagnostics, DiagnosticStatus, Severity
from hub.gcm.geometry import (
    Quaternion,
    Twist,
)
from hub.gcm.imu import Imu
from hub.gcm.joints import JointState, JointStates
from hub.gcm.ranges import LaserScan
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import Transform, Transforms, TransformStamped, Translation
from hub.robots.interfaces import BodyJoints, BodyLights, BodyStops, BodyWakes
from hub.robots.ros.line import RosService, RosTopic
from tests.support.memory_ros_body import AHEAD, ROBOT, STAMPED, TWIST, ZERO, RobotInMemory
from tests.support.memory_ros_line import ROS1, cdr


@pytest.fixture(autouse=True)
def runtime_folder(tmp_path, monkeypatch):
    """Where the last place is kept."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def robot(tmp_path):
    return RobotInMemory(tmp_path)


def test_it_is_all_that_its_robot_file_may_describe(robot):
    for part in (BodyWakes, BodyStops, BodyLights, BodyJoints):
        assert isinstance(robot.body, part)


def test_a_twist_or_a_stamped_one_is_sent_as_the_robot_takes_it(tmp_path):
    numbers = struct.pack("<6d", 0.4, 0.0, 0.0, 0.0, 0.0, 0.1)
    flat = RobotInMemory(tmp_path)
    flat.drive()
    assert flat.line.sent("/cmd_vel") == [b"\0\1\0\0" + numbers]
    stamped = RobotInMemory(tmp_path, velocities=STAMPED)
    stamped.drive()
    (payload,) = stamped.line.sent("/cmd_vel")
    assert payload[:12] == b"\0\1\0\0" + bytes(8)  # the stamp is 0
    assert payload[-48:] == numbers


@pytest.mark.parametrize("kind", [TWIST, STAMPED])
def test_a_robot_with_ros_1_reads_the_same_velocity(tmp_path, kind):
    robot = RobotInMemory(tmp_path, velocities=kind, encoding="ros1")
    robot.drive()
    (payload,) = robot.line.sent("/cmd_vel")
    read: Any = ROS1.deserialize_ros1(payload, kind)
    twist = read if kind == TWIST else read.twist
    assert (twist.linear.x, twist.angular.z) == (0.4, 0.1)
    if kind == STAMPED:
        assert (read.header.stamp.sec, read.header.stamp.nanosec) == (0, 0)


def test_only_motions_of_the_robot_file_are_sent_and_within_its_limits(robot):
    robot.drive(Twist.planar(5.0, -9.0))
    values = struct.unpack("<6d", robot.line.sent("/cmd_vel")[0][4:])
    assert values == (0.6, 0.0, 0.0, 0.0, 0.0, -1.5)


def test_a_full_line_gets_the_zero_as_soon_as_it_can(robot):
    robot.drive()
    robot.line.full = True
    robot.body.command(ZERO)
    robot.run(0.5)
    robot.line.sent("/cmd_vel")
    robot.line.full = False
    robot.run(0.01)
    assert robot.line.sent("/cmd_vel") == [b"\0\1\0\0" + bytes(48)]


def test_one_zero_follows_what_a_held_line_holds(robot):
    robot.drive()
    robot.line.full = True
    robot.line.sent("/cmd_vel")
    robot.run(0.9)
    assert robot.line.sent("/cmd_vel") == [b"\0\1\0\0" + bytes(48)]
    robot.line.full = False
    robot.drive()
    assert robot.line.sent("/cmd_vel")[-1] != b"\0\1\0\0" + bytes(48)


def test_after_velocities_could_not_leave_for_long_it_moves_only_after_a_zero(robot):
    robot.drive()
    robot.line.full = True
    robot.run(0.5)
    assert any("blocked" in each.message for each in robot.body.sensors(0.0).diagnostics)
    robot.line.sent("/cmd_vel")
    robot.line.full = False
    for _ in range(10):
        robot.body.command(AHEAD)
        robot.run(0.05)
    assert set(robot.line.sent("/cmd_vel")) == {b"\0\1\0\0" + bytes(48)}
    assert not any("blocked" in each.message for each in robot.body.sensors(0.0).diagnostics)
    robot.drive()
    assert robot.line.sent("/cmd_vel")[-1] != b"\0\1\0\0" + bytes(48)


def test_after_a_reconnection_it_moves_only_after_a_zero(robot):
    robot.drive()
    robot.line.lose()
    robot.run(0.1)
    robot.line.sent("/cmd_vel")
    robot.body.command(AHEAD)
    robot.line.find()
    for _ in range(10):
        robot.body.command(AHEAD)
        robot.run(0.05)
    assert set(robot.line.sent("/cmd_vel")) == {b"\0\1\0\0" + bytes(48)}
    robot.drive()
    assert robot.line.sent("/cmd_vel")[-1] != b"\0\1\0\0" + bytes(48)


def test_a_connection_that_was_lost_and_made_between_two_looks_counts_too(robot):
    robot.drive()
    robot.line.find()
    robot.run(0.02)
    robot.line.sent("/cmd_vel")
    robot.body.command(AHEAD)
    assert not robot.line.sent("/cmd_vel")
    assert robot.sensors.commanded == ZERO


def test_it_is_where_its_odometry_says_and_as_old(robot):
    robot.odometry(x=2.0, theta=0.5, speed=0.3, age=0.08, clock=-86400.0)
    sensors = robot.sensors
    assert sensors.known
    assert (sensors.x, sensors.theta) == (2.0, pytest.approx(0.5))
    assert sensors.velocity.linear.x == 0.3
    assert sensors.measured == pytest.approx(robot.now - 0.08)
    assert sensors.reckoning


def test_a_place_without_news_is_not_known_after_half_a_second(robot):
    robot.odometry()
    robot.run(0.49)
    assert robot.sensors.known
    assert not robot.problem("odometry")
    robot.run(0.02)
    assert not robot.sensors.known
    assert robot.problem("odometry") == ["its place is not known: /odom is silent for 1 s"]


def test_places_that_come_late_are_not_taken_for_fresh_ones(robot):
    robot.odometry(age=0.3)
    assert robot.problem("odometry") == [
        "places come 0.3 s late: the line, or a node before it, is too slow"
    ]
    robot.odometry(age=2.0)
    assert not robot.sensors.known
    assert robot.problem("odometry") == ["its place is not known: /odom comes 2.0 s late"]


def test_places_that_were_old_in_the_robot_already_are_no_fresh_ones(robot):
    """Its nodes may run on computers whose clocks differ: the least difference counts as none."""
    robot.odometry(waited=0.02)
    assert robot.sensors.measured == pytest.approx(robot.now)
    robot.odometry(x=0.1, waited=0.32)
    assert robot.sensors.measured == pytest.approx(robot.now - 0.3)
    robot.odometry(x=0.2, waited=0.72)
    assert not robot.sensors.known
    assert robot.problem("odometry") == ["its place is not known: /odom comes 0.7 s late"]
    robot.odometry(x=0.2, clock=-3600.0, waited=0.02)  # the clock of the node is set
    assert robot.sensors.known


def test_payloads_that_make_no_sense_are_named_and_change_nothing(robot):
    robot.odometry(x=1.0)
    assert not robot.problem("/odom")
    robot.line.give("/odom", b"\0\1\0\0abc", robot.now)
    assert robot.sensors.x == 1.0
    assert "cannot be used" in robot.problem("/odom")[0]
    robot.odometry(x=1.0)
    assert not robot.problem("/odom")


def test_a_line_that_is_away_is_a_problem_with_its_reason(robot):
    robot.line.lose("nobody listens at 127.0.0.1:8765")
    assert robot.problem("ros") == [
        "the line to ws://127.0.0.1:8765 is away: nobody listens at 127.0.0.1:8765"
    ]
    assert robot.sensors.vehicle.activity == "gone"


def test_scans_come_in_the_layout_of_the_robot_file(robot):
    before = robot.sensors.scans[0]
    assert math.isnan(robot.sensors.scanned)
    assert np.isnan(before.ranges).all()
    robot.line.topic("/scan", "sensor_msgs/msg/LaserScan")
    ranges = np.full(360, 4.0, np.float32)
    ranges[180] = 1.0
    value = LaserScan(
        header=Header(frame_id="laser"),
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=math.tau / 360,
        range_min=0.1,
        range_max=12.0,
        ranges=ranges,
        intensities=np.empty(0, np.float32),
    )
    robot.line.give("/scan", cdr(value), robot.now, 0.02)
    found = robot.sensors
    assert found.scans[0].ranges[4] == 1.0
    assert found.scans[0].header.frame_id == "lidar"
    assert found.scans[0].header.stamp != before.header.stamp
    assert found.scanned == pytest.approx(robot.now - 0.02)


def test_battery_tilt_and_joints_count_while_they_are_young(robot):
    robot.line.topic("/battery", "sensor_msgs/msg/BatteryState")
    robot.line.topic("/imu", "sensor_msgs/msg/Imu")
    robot.line.topic("/joint_states", "sensor_msgs/msg/JointState")
    robot.line.give("/battery", cdr(BatteryState(voltage=12.5, percentage=0.8)), robot.now)
    robot.line.give("/imu", cdr(Imu.of(roll=0.1, pitch=-0.2, heading=1.0)), robot.now)
    joints = JointStates.of([JointState(name="pan", position=0.4)], Header())
    robot.line.give("/joint_states", cdr(joints), robot.now)
    found = robot.sensors
    assert (found.battery_voltage, found.battery_fraction) == pytest.approx((12.5, 0.8))
    assert (found.roll, found.pitch) == pytest.approx((0.1, -0.2))
    assert math.isnan(found.heading)
    assert found.joints[0].position == pytest.approx(0.4)
    joints = JointStates.of([JointState(name="pan", position=1e9)], Header())
    robot.line.give("/joint_states", cdr(joints), robot.now)
    assert math.isnan(robot.sensors.joints[0].position)
    robot.run(3.1, tick=0.1)
    found = robot.sensors
    assert math.isnan(found.roll)
    assert math.isnan(found.joints[0].position)
    assert found.battery_voltage == pytest.approx(12.5)


def test_problems_of_its_nodes_are_shown_until_they_end_or_are_not_repeated(robot):
    robot.line.topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")

    def say(*levels):
        status = tuple(
            DiagnosticStatus(level=level, name=f"motor{place}", message="hot\x1b[2J")
            for place, level in enumerate(levels)
        )
        robot.line.give("/diagnostics", cdr(Diagnostics(status=status)), robot.now)

    say(Severity.WARN, Severity.OK)
    assert robot.problem("motor0") == ["motor0: hot\\x1b[2J"]
    assert not robot.problem("motor1")
    say(Severity.OK, Severity.ERROR)
    assert not robot.problem("motor0")
    robot.run(11.0, tick=0.5)
    assert not robot.problem("motor1")
    say(*[Severity.ERROR] * 200)
    assert len(robot.sensors.diagnostics) < 50


def test_velocities_of_a_type_that_the_bridge_does_not_say(tmp_path):
    robot = RobotInMemory(tmp_path, velocities="")
    robot.line.topics["/cmd_vel"] = RosTopic(name="/cmd_vel", subscribers=("/base",))
    robot.run(3.0, tick=0.1)
    (problem,) = robot.problem("velocities")
    assert "the type of velocities on /cmd_vel is not known" in problem
    assert "cmd_vel_type" in problem


def test_velocities_of_ros_1_are_twist_where_the_bridge_does_not_say_their_type(tmp_path):
    robot = RobotInMemory(tmp_path, velocities="", encoding="ros1")
    robot.line.topics["/cmd_vel"] = RosTopic(name="/cmd_vel", subscribers=("/base",))
    robot.line.whole = True
    robot.run(3.0, tick=0.1)
    assert robot.line.advertised == {"/cmd_vel": TWIST}
    assert not robot.problem("velocities")


@pytest.mark.parametrize("whole", [True, False])
def test_a_named_type_of_velocities_needs_no_topic_of_the_bridge(tmp_path, whole):
    robot = RobotInMemory(
        tmp_path, velocities="", more=ROBOT.replace("[ros]", '[ros]\ncmd_vel_type = "Twist"')
    )
    robot.line.whole = whole
    robot.run(3.0, tick=0.1)
    assert robot.line.advertised == {"/cmd_vel": TWIST}
    assert bool(robot.problem("velocities")) == whole


def test_another_publisher_and_a_missing_subscriber_are_named(tmp_path):
    robot = RobotInMemory(tmp_path, velocities="")
    robot.run(3.0, tick=0.1)
    assert "nothing on the robot subscribes to /cmd_vel" in robot.problem("velocities")[0]
    robot.line.whole = True
    bridges = "/foxglove_bridge", "/foxglove_nodelet_manager"
    robot.line.topic("/cmd_vel", TWIST, publishers=(*bridges, "/joy_teleop", "/bot/rune_3"))
    robot.run(0.1)
    deaf, other = robot.problem("velocities")
    assert "no node of the robot subscribes" in deaf
    assert other.startswith("/joy_teleop, /bot/rune_3 may drive too")


def test_a_topic_of_velocities_of_another_type_is_named_and_not_used(tmp_path):
    robot = RobotInMemory(tmp_path, velocities="ackermann_msgs/msg/AckermannDrive")
    robot.drive()
    robot.run(3.0, tick=0.1)
    assert not robot.line.published
    assert "which is no Twist" in robot.problem("velocities")[0]


@pytest.mark.parametrize(
    ("kind", "request_bytes", "refused"),
    [
        ("std_srvs/srv/Trigger", b"\0\1\0\0\0", b"\0\1\0\0\0\0\0\0\4\0\0\0no!\0"),
        ("std_srvs/srv/SetBool", b"\0\1\0\0\1", b"\0\1\0\0\0\0\0\0\4\0\0\0no!\0"),
        ("std_srvs/srv/Empty", b"\0\1\0\0\0", None),
    ],
)
def test_a_stop_calls_the_robots_own_stop(robot, kind, request_bytes, refused):
    robot.line.services["/e_stop"] = RosService(name="/e_stop", type=kind)
    robot.body.stop()
    (name, payload, answered) = robot.line.called.pop()
    assert (name, payload) == ("/e_stop", request_bytes)
    answered(refused, "" if refused else "no answer within 1 s")
    (said,) = robot.problem("/e_stop")
    assert ("no!" if refused else "no answer") in said
    robot.body.stop()
    robot.line.called.pop()[2](b"\0\1\0\0\1\0\0\0\1\0\0\0\0", "")
    assert not robot.problem("/e_stop")


def test_a_stop_that_is_not_there_is_a_problem(robot):
    robot.body.stop()
    assert robot.problem("/e_stop") == [
        "the service /e_stop failed: the robot has none of this name"
    ]


def test_a_light_is_a_number_or_a_service(robot):
    robot.body.set_light("lamp", 0.5)
    robot.line.topic("/lamp", "std_msgs/msg/Float32")
    robot.run(0.1)
    assert robot.line.sent("/lamp") == [b"\0\1\0\0" + struct.pack("<f", 0.5)]
    assert robot.sensors.vehicle.lights[0].brightness == 0.5
    robot.line.services["/lamp"] = RosService(name="/lamp", type="std_srvs/srv/SetBool")
    robot.body.set_light("lamp", 1.0)
    assert robot.line.called.pop()[:2] == ("/lamp", b"\0\1\0\0\1")


def test_a_joint_turns_from_where_it_is_to_its_limit(robot):
    robot.line.topic("/pan/angle", "std_msgs/msg/Float64")
    robot.line.topic("/joint_states", "sensor_msgs/msg/JointState")
    joints = JointStates.of([JointState(name="pan", position=1.0)], Header())
    robot.line.give("/joint_states", cdr(joints), robot.now)
    assert robot.sensors.joints
    robot.body.turn_joint("pan", 1.0)
    robot.run(0.1)
    angles = [struct.unpack("<d", each[4:])[0] for each in robot.line.sent("/pan/angle")]
    assert angles == pytest.approx([1.05, 1.1], abs=0.02)
    robot.run(2.0)
    assert struct.unpack("<d", robot.line.sent("/pan/angle")[-1][4:])[0] == math.pi / 2
    robot.body.turn_joint("pan", 0.0)
    robot.run(0.5)
    assert not robot.line.sent("/pan/angle")


def transforms(*poses, stamp=5.0):
    """A message of tf: parent, child, x, heading each."""
    return cdr(
        Transforms(
            transforms=tuple(
                TransformStamped(
                    header=Header(stamp=Time.of(stamp), frame_id=parent),
                    child_frame_id=child,
                    transform=Transform(
                        translation=Translation(x=x), rotation=Quaternion.of(0.0, 0.0, theta)
                    ),
                )
                for parent, child, x, theta in poses
            )
        )
    )


def test_without_odometry_the_frames_say_where_it_is(tmp_path):
    robot = RobotInMemory(tmp_path)
    del robot.line.topics["/odom"]
    robot.run(3.0, tick=0.1)
    robot.line.topic("/tf", "tf2_msgs/msg/TFMessage")
    robot.line.topic("/tf_static", "tf2_msgs/msg/TFMessage")
    fixed = transforms(("base_footprint", "base_link", 0.1, 0.0))
    robot.line.give("/tf_static", fixed, robot.now)
    for count in range(10):
        moved = transforms(("odom", "base_footprint", 1.0 + 0.03 * count, 0.0))
        robot.line.give("/tf", moved, robot.now, 0.01)
        robot.run(0.1)
    found = robot.sensors
    assert found.known
    assert found.x == pytest.approx(1.37)
    assert found.velocity.linear.x == pytest.approx(0.3)
    robot.line.give("/tf", transforms(("base_link", "wheel", 0.0, 1.0)), robot.now)
    robot.run(0.5)
    assert not robot.sensors.known


def test_with_a_map_of_its_own_it_is_in_the_frame_of_that_map(tmp_path):
    robot = RobotInMemory(tmp_path, ROBOT.replace("[ros]", '[ros]\nmap = "/map"'))
    robot.line.topic("/tf", "tf2_msgs/msg/TFMessage")
    robot.odometry(x=1.0)
    assert not robot.sensors.known
    robot.run(2.1, tick=0.1)
    robot.odometry(x=1.0)
    before = robot.sensors
    assert before.known
    assert before.x == 1.0
    assert "do not say where it is on it" in robot.problem("own map")[0]
    moved = transforms(("map", "odom", 5.0, math.pi / 2))
    robot.line.give("/tf", moved, robot.now)
    found = robot.sensors
    assert (found.x, found.y, found.theta) == pytest.approx((5.0, 1.0, math.pi / 2))
    assert found.reckoning not in (0, before.reckoning)
    assert not robot.problem("own map")
