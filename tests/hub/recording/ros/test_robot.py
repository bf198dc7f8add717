"""Messages of ROS 2 become those of Rune, and the same at a moment however it is reached."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.gcm.battery import BATTERY
from hub.gcm.beams import beams_of
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.catalog import BY_NAME
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.flight import FLUID_PRESSURE
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import NAVIGATION_STATUS, ROBOT_STATE
from hub.gcm.ranges import RANGES
from hub.recording.ros.bag import Bag
from hub.recording.ros.robot import RosRobot, RosScene
from hub.recording.ros.topic_roles import ROLES, SHOWN_BY
from tests.support import ros_bags
from tests.support.ros_bags import START, STORE, Entry, header, make, pose, transform


@contextlib.contextmanager
def robot_of(path: Path, entries: list[Entry]) -> Iterator[tuple[Bag, RosRobot]]:
    with Bag.open(ros_bags.write_mcap(path / "a.mcap", entries)) as bag:
        yield bag, RosRobot(bag, "rover")


def scene_of(path: Path, *sent: tuple[str, Any], at: int = START) -> RosScene:
    """What is known after these messages, one each millisecond."""
    entries = [
        (topic, each.__msgtype__, START + n, bytes(STORE.serialize_cdr(each, each.__msgtype__)))
        for n, (topic, each) in enumerate(sent)
    ]
    with robot_of(path, entries) as (_, robot):
        robot.seek(at + len(sent))
        scene = robot.scene()
        assert robot.values.faults == []
    return scene


def value(scene: RosScene, name: str) -> Any:
    return scene.messages[name].value


def test_a_robot_is_known_at_each_moment(tmp_path: Path) -> None:
    with robot_of(tmp_path, list(ros_bags.entries())) as (bag, robot):
        robot.seek(START + 2_000_000_000)
        scene = robot.scene()
        state = value(scene, ROBOT_STATE.name)
        assert (state.x, state.y, state.theta) == pytest.approx((1.0, 1.0, 0.0))
        assert (state.linear, state.angular) == (0.5, 0.0)
        assert value(scene, BATTERY.name).percentage == 0.75
        assert value(scene, IMU.name).angular_velocity.z == 0.125
        assert [each.name for each in value(scene, DIAGNOSTICS.name).status] == ["lidar"]
        assert scene.map is not None
        assert scene.map.value.cells.shape == (20, 40)
        assert (scene.map.value.origin_x, scene.map.value.resolution) == (-2.0, 0.25)
        body = value(scene, ROBOT_DESCRIPTION.name)
        assert [each.name for each in body.cameras] == ["camera"]
        beams = beams_of(body)
        assert np.nanmax(beams.ranges(value(scene, RANGES.name))) == 3.0
        assert (beams.x[0], beams.bearing[90]) == pytest.approx((0.2, 0.0), abs=1e-6)
        assert scene.pictures["camera"].message.stamp == START + 2_000_000_000
        assert robot.values.faults == []
        assert bag.faults == []


def test_a_moment_is_the_same_after_a_jump_and_after_playing(tmp_path: Path) -> None:
    with robot_of(tmp_path, list(ros_bags.entries())) as (bag, played):
        jumped = RosRobot(bag, "rover")
        played.seek(bag.start)
        at = bag.start
        for stamp in range(bag.start + 150_000_000, bag.end, 333_000_000):
            for message in bag.messages(at + 1, stamp):
                played.take(message)
            at = stamp
            jumped.seek(stamp)
            one, other = played.scene(), jumped.scene()
            assert repr(one.messages) == repr(other.messages)
            assert repr(one.problems) == repr(other.problems)
            assert {name: each.message for name, each in one.pictures.items()} == {
                name: each.message for name, each in other.pictures.items()
            }


def test_all_that_is_made_fits_the_messages_of_rune(tmp_path: Path) -> None:
    with robot_of(tmp_path, list(ros_bags.entries())) as (bag, robot):
        robot.seek(bag.end)
        for name, shown in robot.scene().messages.items():
            definition = BY_NAME[name]
            assert definition.decode(b"".join(definition.encode(shown.value)))


def test_a_sensor_that_is_turned_measures_in_the_body(tmp_path: Path) -> None:
    upside_down = make("geometry_msgs/msg/Quaternion", x=1.0)
    mounted = transform(START, "base_link", "imu", 0, 0, 0)
    mounted.transform.rotation = upside_down
    scene = scene_of(
        tmp_path,
        ("/tf_static", make("tf2_msgs/msg/TFMessage", transforms=[mounted])),
        (
            "/imu",
            make(
                "sensor_msgs/msg/Imu",
                header=header(START, "imu"),
                orientation=upside_down,
                angular_velocity=make("geometry_msgs/msg/Vector3", z=-1.0),
                linear_acceleration=make("geometry_msgs/msg/Vector3", z=-9.81),
            ),
        ),
    )
    read = value(scene, IMU.name)
    assert read.linear_acceleration.z == pytest.approx(9.81)
    assert read.angular_velocity.z == pytest.approx(1.0)
    assert read.roll_pitch_yaw == pytest.approx((0, 0, 0))


def test_an_imu_without_orientation_says_so(tmp_path: Path) -> None:
    read = make("sensor_msgs/msg/Imu", orientation=make("geometry_msgs/msg/Quaternion"))
    scene = scene_of(tmp_path, ("/imu", read))
    assert math.isnan(value(scene, IMU.name).roll_pitch_yaw[0])


@pytest.mark.parametrize(("given", "share"), [(0.5, 0.5), (85.0, 0.85), (math.nan, math.nan)])
def test_percentages_of_both_kinds_are_read(tmp_path: Path, given: float, share: float) -> None:
    scene = scene_of(
        tmp_path, ("/b", make("sensor_msgs/msg/BatteryState", percentage=given, voltage=1e9))
    )
    read = value(scene, BATTERY.name)
    assert read.percentage == pytest.approx(share, nan_ok=True)
    assert math.isnan(read.voltage)


def test_a_battery_that_counts_to_100_does_so_in_the_whole_recording(tmp_path: Path) -> None:
    said = [("/b", make("sensor_msgs/msg/BatteryState", percentage=each)) for each in (3.0, 1.0)]
    for number, share in enumerate((0.03, 0.01)):
        scene = scene_of(tmp_path, *said, at=START + number - len(said))
        assert value(scene, BATTERY.name).percentage == pytest.approx(share)
        assert value(scene, ROBOT_STATE.name).battery_fraction == pytest.approx(share)


def test_other_readings_are_known(tmp_path: Path) -> None:
    scene = scene_of(
        tmp_path,
        ("/p", make("sensor_msgs/msg/FluidPressure", fluid_pressure=101325.0)),
        (
            "/joint_states",
            make(
                "sensor_msgs/msg/JointState",
                name=["a", "b"],
                position=np.array([0.5]),
                velocity=np.array([1.0, 2.0, 3.0]),
            ),
        ),
        (
            "/sonar",
            make(
                "sensor_msgs/msg/Range",
                header=header(START, "front"),
                field_of_view=0.5,
                min_range=0.1,
                max_range=4.0,
                range=1.5,
            ),
        ),
        (
            "/camera/camera_info",
            make("sensor_msgs/msg/CameraInfo", width=640, k=np.array([320.0] + [0.0] * 8)),
        ),
        ("/camera/image_raw", ros_bags.picture(START, 1)),
        (
            "/cmd_vel",
            make("geometry_msgs/msg/Twist", linear=make("geometry_msgs/msg/Vector3", x=0.3)),
        ),
    )
    assert value(scene, FLUID_PRESSURE.name).fluid_pressure == 101325.0
    joints = value(scene, JOINT_STATES.name)
    assert joints.name == ("a", "b")
    assert joints.position.tolist() == pytest.approx([0.5, math.nan], nan_ok=True)
    assert joints.velocity.tolist() == [1.0, 2.0]
    scan = value(scene, RANGES.name).scans[0]
    assert (scan.header.frame_id, scan.ranges.tolist()) == ("sonar", [1.5])
    assert scene.pictures["camera"].horizontal_fov == pytest.approx(math.pi / 2)
    assert value(scene, ROBOT_STATE.name).commanded_linear == 0.3


def test_a_path_is_the_way_ahead_on_the_map(tmp_path: Path) -> None:
    poses = [make("geometry_msgs/msg/PoseStamped", pose=pose(0.01 * n, 0, 0)) for n in range(3001)]
    scene = scene_of(
        tmp_path,
        (
            "/tf",
            make(
                "tf2_msgs/msg/TFMessage",
                transforms=[
                    transform(START, "map", "odom", 0, 1, math.pi / 2),
                    transform(START, "odom", "base_link", 2, 0, 0),
                ],
            ),
        ),
        ("/plan", make("nav_msgs/msg/Path", header=header(START, "odom"), poses=poses)),
    )
    path = value(scene, NAVIGATION_STATUS.name).path
    assert len(path) <= 1000
    assert (path[0].x, path[0].y) == pytest.approx((0, 1))
    assert (path[-1].x, path[-1].y) == pytest.approx((0, 31))
    state = value(scene, ROBOT_STATE.name)
    assert (state.x, state.y, state.theta) == pytest.approx((0, 3, math.pi / 2))


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("/amcl_pose", make("geometry_msgs/msg/PoseWithCovarianceStamped")),
        ("/pose", make("geometry_msgs/msg/PoseStamped")),
        ("/odom", make("nav_msgs/msg/Odometry")),
    ],
)
def test_a_pose_is_known_without_frames(tmp_path: Path, topic: str, message: Any) -> None:
    inner = message if topic == "/pose" else message.pose
    inner.pose = pose(1, 2, 0.5)
    state = value(scene_of(tmp_path, (topic, message)), ROBOT_STATE.name)
    assert (state.x, state.y, state.theta) == pytest.approx((1, 2, 0.5))


@pytest.mark.parametrize("part", ["x", "w"])
def test_a_place_and_a_speed_that_are_not_known_are_not_zero(tmp_path: Path, part: str) -> None:
    message = make("nav_msgs/msg/Odometry", header=header(START, "odom"))
    message.pose.pose = pose(1, 2, 0.5)
    message.twist.twist.linear.x = math.nan
    if part == "x":
        message.pose.pose.position.x = math.nan
    else:
        message.pose.pose.orientation = make("geometry_msgs/msg/Quaternion")
    state = value(scene_of(tmp_path, ("/odom", message)), ROBOT_STATE.name)
    assert all(map(math.isnan, (state.x, state.y, state.theta, state.linear)))
    assert state.angular == 0.0
    battery = make("sensor_msgs/msg/BatteryState", percentage=0.5)
    state = value(scene_of(tmp_path, ("/b", battery)), ROBOT_STATE.name)
    assert all(map(math.isnan, (state.x, state.y, state.theta, state.linear)))


def test_a_turned_map_is_shown_on_the_axes_of_its_frame(tmp_path: Path) -> None:
    info = make("nav_msgs/msg/MapMetaData", resolution=0.5, width=3, height=1)
    info.origin = pose(1, 2, math.pi / 2)
    grid = make("nav_msgs/msg/OccupancyGrid", info=info, data=np.array([0, 0, 100], np.int8))
    scene = scene_of(tmp_path, ("/map", grid))
    assert scene.map is not None
    assert scene.map.value.cells.tolist() == [[0], [0], [100]]
    assert (scene.map.value.origin_x, scene.map.value.origin_y) == pytest.approx((0.5, 2.0))


def test_a_map_has_its_changes(tmp_path: Path) -> None:
    info = make("nav_msgs/msg/MapMetaData", resolution=0.1, width=4, height=3, origin=pose(0, 0, 0))
    grid = make("nav_msgs/msg/OccupancyGrid", info=info, data=np.zeros(12, np.int8))
    name = "map_msgs/msg/OccupancyGridUpdate"
    text = "std_msgs/Header header\nint32 x\nint32 y\nuint32 width\nuint32 height\nint8[] data\n"
    from rosbags.typesys import get_types_from_msg

    if name not in STORE.fielddefs:
        STORE.register(get_types_from_msg(text, name))
    inside = make(name, x=1, y=1, width=2, height=1, data=np.array([100, -1], np.int8))
    scene = scene_of(tmp_path, ("/map", grid), ("/map_updates", inside))
    assert scene.map is not None
    assert scene.map.value.cells.tolist() == [[0, 0, 0, 0], [0, 100, -1, 0], [0, 0, 0, 0]]


def test_what_makes_no_sense_is_said_once_and_left_out(tmp_path: Path) -> None:
    nothing = make("nav_msgs/msg/OccupancyGrid")
    beams = make("sensor_msgs/msg/LaserScan", angle_min=math.nan)
    sent = [("/map", nothing), ("/scan", beams), ("/map", nothing)]
    entries = [
        (topic, each.__msgtype__, START + n, bytes(STORE.serialize_cdr(each, each.__msgtype__)))
        for n, (topic, each) in enumerate(sent)
    ]
    entries.append(("/battery", "sensor_msgs/msg/BatteryState", START, b"\0\1\0\0"))
    with robot_of(tmp_path, entries) as (bag, robot):
        robot.seek(bag.end)
        for _ in range(3):
            scene = robot.scene()
        faults = "\n".join(robot.values.faults)
        assert set(scene.messages) == {ROBOT_DESCRIPTION.name}
        assert [faults.count(f"{name}: ") for name in ("/map", "/scan", "/battery")] == [1, 1, 1]


def test_rings_of_frames_end(tmp_path: Path) -> None:
    ring = [transform(START, a, b, 1, 0, 0) for a, b in ("ab", "bc", "ca", "aa")]
    odometry = make("nav_msgs/msg/Odometry", header=header(START, "x"), child_frame_id="c")
    scene = scene_of(
        tmp_path, ("/tf", make("tf2_msgs/msg/TFMessage", transforms=ring)), ("/odom", odometry)
    )
    assert BATTERY.name not in scene.messages


def test_equal_names_of_cameras_are_told_apart(tmp_path: Path) -> None:
    names = ("/cam/image_raw", "/cam/image_color", "/depth/image", "/" + "x" * 300)
    scene = scene_of(tmp_path, *((name, ros_bags.picture(START, 1)) for name in names))
    cameras = [each.name for each in value(scene, ROBOT_DESCRIPTION.name).cameras]
    assert len(set(cameras)) == 4
    assert all(len(each) <= 64 for each in cameras)
    assert cameras[0] == "cam"
    assert cameras[2] == "depth"


def test_each_role_says_what_shows_it() -> None:
    assert {*ROLES.values()} < SHOWN_BY.keys()
