"""What Rune makes of the topics of a robot with ROS; the robots are written down, not run."""

from __future__ import annotations

import math
import os
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hub.robomon.module_table import load_robot_table
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.findings import RosFindings
from hub.robots.ros.asking.proposal import RosProposal
from hub.robots.ros.asking.robot_text import robot_file
from hub.robots.ros.asking.robots import namespaces_of
from tests.support.ros_findings import (
    OPTICAL,
    ROBOTS,
    TURTLEBOT_4,
    TURTLEBOT_4_FRAMES,
    bare_firmware,
    camera_info,
    clearpath,
    found,
    header,
    odometry,
    ros_1,
    scan,
    transform,
    turtlebot_4,
)

GOLDEN = Path(__file__).parents[4] / "golden" / "ros"
TWIST = "geometry_msgs/msg/Twist"
LASER = "sensor_msgs/msg/LaserScan"
TAKEN = {"type": TWIST, "to": ("/diff_drive_controller",)}
ODOM = {"type": "nav_msgs/msg/Odometry", "by": ("/base",), "said": odometry()}


def read(proposal: RosProposal) -> dict[str, Any]:
    return tomllib.loads(robot_file(proposal))


def dangers(robot: RosFindings) -> dict[str, str]:
    return {each.name: each.why for each in RosProposal(robot).dangers()}


def said(robot: RosFindings) -> str:
    return "\n".join(RosProposal(robot).remarks())


def driven(parameters: dict[str, object]) -> RosFindings:
    return found({"/cmd_vel": TAKEN, "/odom": ODOM}, parameters=parameters)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_gets_its_file(name: str, tmp_path: Path) -> None:
    """After a wanted change, write them again: RUNE_WRITE_SNAPSHOTS=1 pytest with this file."""
    proposal = RosProposal(ROBOTS[name]())
    text = robot_file(proposal, today="2026-11-23")
    text += "\n" + "".join(f"# {line}\n" for line in proposal.remarks())
    path = GOLDEN / f"{name}.toml"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.write_text(text)
    assert text == path.read_text()
    (tmp_path / "robot.toml").write_text(text)
    assert load_robot_table(str(tmp_path / "robot.toml")).robot.kind == "ros"


PLOUGHER = """<robot name="p">
<link name="base_link"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="plough"><collision><geometry><mesh filename="package://r/plough.stl"/></geometry>
</collision></link><joint name="j" type="fixed"><parent link="base_link"/><child link="plough"/>
<origin xyz="0.5 0 0"/></joint></robot>"""


@pytest.mark.parametrize(("planner", "radius"), [(0.2, 0.6), (0.8, 0.8), (None, 0.6)])
def test_a_mesh_that_cannot_be_read_makes_the_robot_larger(
    planner: float | None, radius: float
) -> None:
    parameters: dict[str, object] = {"/state.robot_description": PLOUGHER}
    parameters |= {"/local_costmap.robot_radius": planner} if planner else {}
    proposal = RosProposal(driven(parameters))
    assert "footprint" not in read(proposal)["body"]
    assert ("lacks link 'plough' at [0.5, 0]" in robot_file(proposal)) is (radius == 0.6)
    assert read(proposal)["body"]["radius"] == pytest.approx(radius)
    assert "its outline is not known: the outline lacks link 'plough' at [0.5, 0]" in "\n".join(
        proposal.remarks()
    )


ARM = """<robot name="p">
<link name="base_link"><collision><geometry><box size="0.4 0.4 0.1"/></geometry></collision></link>
<link name="arm"><visual><geometry><box size="0.1 0.1 0.3"/></geometry></visual></link>
<link name="wheel"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
<link name="eye"/>
<joint name="shoulder" type="revolute"><parent link="base_link"/><child link="arm"/></joint>
<joint name="axle" type="continuous"><parent link="base_link"/><child link="wheel"/></joint>
<joint name="tilt" type="revolute"><parent link="base_link"/><child link="eye"/></joint></robot>"""


def test_joints_that_move_a_shape_are_named_with_the_outline() -> None:
    proposal = RosProposal(driven({"/state.robot_description": ARM}))
    said = [each for each in proposal.remarks() if "outline" in each]
    assert said == ["its outline has shoulder at zero: if it reaches farther, correct `footprint`"]


@pytest.mark.parametrize("counts", [True, False])
def test_the_file_says_that_a_battery_counts_to_100(*, counts: bool) -> None:
    said_of = {"percentage": 57.0 if counts else 0.57}
    battery = {"type": "sensor_msgs/msg/BatteryState", "by": ("/base",), "said": said_of}
    robot = found({"/cmd_vel": TAKEN, "/odom": ODOM, "/battery": battery})
    assert read(RosProposal(robot))["ros"].get("battery_percent", False) is counts
    assert ("battery_percent" in said(robot)) is counts


def test_a_scan_gets_its_place_above_the_ground_and_its_beams() -> None:
    (table,) = read(RosProposal(turtlebot_4()))["range"]
    assert (table["topic"], table["beams"], table["spread_deg"]) == ("/scan", 720, 360.0)
    assert (table["forward"], table["height"], table["yaw_deg"]) == (-0.04, 0.199, 90.0)
    assert table["rate_hz"] == 7.5


def test_a_scan_in_the_frame_of_the_base_has_the_name_of_its_topic() -> None:
    topics = {"/scan": {"type": LASER, "by": ("/laser",), "said": scan("base_link")}}
    robot = found({"/cmd_vel": TAKEN, "/odom": ODOM, **topics})
    (group,) = read(RosProposal(robot))["range"]
    assert group["name"] == "scan"


def test_compressed_pictures_are_preferred_and_their_calibration_counts() -> None:
    (table,) = read(RosProposal(turtlebot_4()))["camera"]
    assert table["topic"] == "/oakd/rgb/preview/image_raw/compressed"
    assert table["info"] == "/oakd/rgb/preview/camera_info"
    assert table["fov_deg"] == pytest.approx(math.degrees(2 * math.atan(160 / 264)), abs=0.01)
    assert (table["width_px"], table["height_px"]) == (320, 240)
    assert (table["forward"], table["height"]) == (-0.06, 0.25)
    assert not {"yaw_deg", "pitch_deg"} & {*table}, "the axes of optics are not those of the body"


def test_a_camera_that_looks_down_is_pitched() -> None:
    half = math.radians(20.0) / 2.0
    turn = {"x": 0.0, "y": math.sin(half), "z": 0.0, "w": math.cos(half)}
    frames = (
        transform("base_link", "eye", 0.1, 0.0, 0.4, turn),
        transform("eye", "eye_optical_frame", 0.0, 0.0, 0.0, OPTICAL),
    )
    info = {"type": "sensor_msgs/msg/CameraInfo", "by": ("/eye",)}
    topics = {
        "/cmd_vel": TAKEN,
        "/eye/image_raw": {"type": "sensor_msgs/msg/Image", "by": ("/eye",)},
        "/eye/camera_info": {**info, "said": camera_info("eye_optical_frame")},
    }
    (table,) = read(RosProposal(found(topics, frames=frames)))["camera"]
    assert table["pitch_deg"] == pytest.approx(20.0)


def test_the_velocities_of_a_namespace_are_those_before_its_multiplexer() -> None:
    proposal = RosProposal(clearpath())
    assert read(proposal)["ros"]["cmd_vel"] == "/a200_0000/cmd_vel"
    others = "/a200_0000/platform/cmd_vel, /a200_0000/joy_teleop/cmd_vel"
    assert f"{others} would too" in said(clearpath())
    assert proposal.parts.odometry == "/a200_0000/platform/odom/filtered"
    assert (proposal.limits.linear, proposal.limits.angular) == (1.0, 1.5), "its own 2.0 is fast"


def test_of_several_robots_the_one_in_the_namespace_is_taken() -> None:
    kinds = (("cmd_vel", TAKEN), ("odom", ODOM))
    topics = {f"/{name}/{topic}": spec for name in ("one", "two") for topic, spec in kinds}
    proposal = RosProposal(found(topics, namespace="/two"))
    table = read(proposal)["ros"]
    assert (table["cmd_vel"], table["odom"]) == ("/two/cmd_vel", "/two/odom")
    assert proposal.parts.commands == ()
    assert proposal.name == "two"


BRIDGE = "Failed to retrieve type information of data type 'geometry_msgs/Twist'"


def test_velocities_that_the_bridge_cannot_publish_are_a_refusal_with_the_remedy() -> None:
    robot = found({"/cmd_vel": TAKEN, "/odom": ODOM}, refusals={"/cmd_vel": BRIDGE})
    refusal = RosProposal(robot).refusal()
    assert "its bridge cannot publish /cmd_vel: install geometry_msgs where the bridge" in refusal
    assert BRIDGE in refusal
    other = found({"/cmd_vel": TAKEN, "/odom": ODOM}, refusals={"/scan": BRIDGE})
    assert not RosProposal(other).refusal()


FRAMES = {"type": "tf2_msgs/msg/TFMessage", "by": ("/base",)}


@pytest.mark.parametrize(
    ("topics", "robots"),
    [
        ({"/one/cmd_vel": TAKEN, "/one/odom": ODOM, "/two/cmd_vel": TAKEN, "/two/odom": ODOM}, 2),
        ({f"/fleet/{n}/{k}": v for n in "abc" for k, v in (("cmd_vel", TAKEN), ("tf", FRAMES))}, 3),
        ({"/cmd_vel": TAKEN, "/odom": ODOM}, 1),
        ({"/cmd_vel": TAKEN, "/one/odom": ODOM}, 1),
        # a controller has topics of its own within the robot
        ({"/cmd_vel": TAKEN, "/odom": ODOM, "/w/cmd_vel": TAKEN, "/w/odom": ODOM}, 1),
        ({"/r/cmd_vel": TAKEN, "/r/base/cmd_vel": TAKEN, "/r/base/odom": ODOM, "/r/tf": FRAMES}, 1),
        # a robot without a namespace beside one with
        (
            {
                "/cmd_vel": TAKEN, "/odom": ODOM,
                "/two/cmd_vel": TAKEN, "/two/odom": ODOM, "/two/tf": FRAMES,
            },
            2,
        ),
        # one node drives all of them
        ({"/cmd_vel": TAKEN, "/one/cmd_vel": TAKEN, "/one/odom": ODOM, "/two/odom": ODOM}, 1),
        ({"/one/cmd_vel": {**TAKEN, "to": ()}, "/one/odom": ODOM, "/two/odom": ODOM}, 1),
    ],
)  # fmt: skip
def test_several_robots_are_counted_and_one_has_to_be_chosen(
    topics: dict[str, Any], robots: int
) -> None:
    refusal = RosProposal(found(topics)).refusal()
    if robots == 1:
        assert "robots:" not in refusal
        return
    assert refusal.startswith(f"{robots} robots: ")
    assert refusal.endswith("; choose one with --namespace")
    for name in namespaces_of(found(topics)):
        assert (name or "/") in refusal
        chosen = found(topics, namespace=name, others=() if name else ("/two",))
        assert not RosProposal(chosen).refusal(), name
        assert RosProposal(chosen).parts.command.name == f"{name}/cmd_vel"


def test_a_topic_of_measured_velocities_takes_none() -> None:
    robot = found({"/base/measured": {"type": TWIST, "by": ("/base",)}, "/odom": ODOM})
    assert RosProposal(robot).refusal().startswith("no topic of it takes velocities")


@pytest.mark.parametrize(
    ("parameters", "seconds"),
    [
        ({"/diff_drive_controller.cmd_vel_timeout": 0.5}, 0.5),
        ({"/diff_drive_controller.cmd_vel_timeout": 0}, math.inf),
        ({"/diff_drive_controller.cmd_vel_timeout": -1.0}, math.inf),
        ({"/diff_drive_controller.cmd_vel_timeout": "0.5"}, math.nan),
        ({"/diff_drive_controller.cmd_vel_timeout": True}, math.nan),
        ({"/diff_drive_controller.cmd_vel_timeout": math.nan}, math.nan),
        ({"/x.cmd_vel_timeout": 0.0, "/diff_drive_controller.cmd_vel_timeout": 0.5}, 0.5),
        ({"/one.cmd_vel_timeout": 0.5, "/two.cmd_vel_timeout": 0.0}, math.inf),
        ({"/firmware/watchdog_timeout": 0.2}, 0.2),
        ({"/nav.cmd_vel_timeout_of_goal": 0.2}, math.nan),
    ],
)
def test_the_time_out_of_the_node_that_takes_velocities_counts(
    parameters: dict[str, object], seconds: float
) -> None:
    proposal = RosProposal(driven(parameters))
    assert proposal.stopping.seconds == pytest.approx(seconds, nan_ok=True)
    hold = not math.isfinite(seconds)
    assert read(proposal)["ros"].get("hold", False) is hold


def test_without_a_time_out_it_is_unsafe_and_says_what_that_means() -> None:
    never = dangers(driven({"/diff_drive_controller.cmd_vel_timeout": 0.0}))["time-out"]
    assert "the robot keeps the last command for ever" in never
    assert "/diff_drive_controller.cmd_vel_timeout is 0" in never
    assert "which is long" in dangers(driven({"/base.cmd_vel_timeout": 5.0}))["time-out"]
    assert "it is not known whether" in dangers(bare_firmware())["time-out"]
    assert "time-out" not in dangers(turtlebot_4()), "its firmware stops it"


def test_others_that_drive_are_a_danger_and_the_bridge_is_none() -> None:
    both = {**TAKEN, "by": ("/foxglove_bridge", "/rune_12", "/teleop")}
    robot = found({"/cmd_vel": both, "/odom": ODOM})
    assert dangers(robot)["publisher"].startswith("/teleop also publishes /cmd_vel")
    own = {**TAKEN, "by": ("/foxglove_bridge",)}
    assert "publisher" not in dangers(found({"/cmd_vel": own, "/odom": ODOM}))


HERE = "ws://127.0.0.1:8765"
EVERYWHERE = {"/foxglove_bridge.address": "0.0.0.0"}


@pytest.mark.parametrize(
    ("address", "parameters", "open_to_all"),
    [
        (HERE, {}, False),
        ("ws://localhost", {}, False),
        ("ws://192.0.2.1:8765", {}, True),
        ("wss://192.0.2.1:8765", {}, False),
        (HERE, EVERYWHERE, True),
        (HERE, {"/foxglove_bridge.address": "127.0.0.1"}, False),
        (HERE, {**EVERYWHERE, "/foxglove_bridge.tls": True}, False),
        ("zenoh+tcp://192.0.2.1", {}, True),
        ("zenoh+tls://192.0.2.1", {}, False),
        ("zenoh+tcp://[::1]:7447", {}, False),
    ],
)
def test_a_way_in_that_is_open_to_the_network_is_a_danger(
    address: str, parameters: dict[str, object], *, open_to_all: bool
) -> None:
    robot = turtlebot_4(address=ros_address(address), parameters=parameters)
    assert ("network" in dangers(robot)) is open_to_all
    if open_to_all:
        assert "anybody in this network can drive it" in dangers(robot)["network"]


def test_what_cannot_be_driven_says_why() -> None:
    assert RosProposal(found({})).refusal().startswith("it has no topics")
    assert "clientPublish" in RosProposal(turtlebot_4(takes=False)).refusal()
    assert "nothing says where it is" in RosProposal(found({"/cmd_vel": TAKEN})).refusal()
    for robot in ROBOTS.values():
        assert RosProposal(robot()).refusal() == ""


UNTYPED = {"type": "", "to": ("/mobile_base",)}


def old(topics: dict[str, Any], **more: Any) -> RosFindings:
    """A robot with ROS 1, whose bridge knows the types of published topics only."""
    return found({"/odom": ODOM, **topics}, distribution="noetic", encoding="ros1", **more)


@pytest.mark.parametrize(
    ("robot", "name"),
    [
        (old({"/base/cmd_vel": UNTYPED}), "/base/cmd_vel"),
        (old({}, whole=False), "/cmd_vel"),
    ],
    ids=["known by its subscriber", "not known at all"],
)
def test_a_bridge_for_ros_1_need_not_say_the_type_of_velocities(
    robot: RosFindings, name: str
) -> None:
    proposal = RosProposal(robot)
    assert proposal.refusal() == ""
    assert read(proposal)["ros"]["cmd_vel"] == name
    assert f'cmd_vel = "{name}"    # type not known: Twist is assumed' in robot_file(proposal)
    assert f"does not say the type of {name}: Twist is assumed" in said(robot)


@pytest.mark.parametrize(
    "robot",
    [
        found({"/odom": ODOM, "/cmd_vel": UNTYPED}),
        old({"/cmd_vel": {"type": ""}}),
        old({"/cmd_vel": UNTYPED}, namespace="/other"),
    ],
    ids=["ROS 2", "nobody subscribes", "another robot"],
)
def test_the_type_of_velocities_is_assumed_of_no_other_robot(robot: RosFindings) -> None:
    assert "no topic of it takes velocities" in RosProposal(robot).refusal()


def test_a_type_that_the_bridge_says_is_not_assumed() -> None:
    assert "is assumed" not in robot_file(RosProposal(ros_1()))


def test_velocities_of_the_usual_name_are_taken_before_a_measured_twist() -> None:
    measured = {"type": TWIST, "by": ("/wheels",), "to": ("/logger",)}
    robot = old({"/cmd_vel": UNTYPED, "/wheel/velocity_estimate": measured})
    assert read(RosProposal(robot))["ros"]["cmd_vel"] == "/cmd_vel"
    assert "publisher" not in dangers(robot)


@pytest.mark.parametrize("driver", ["/move_base", "/teleop"])
def test_the_robots_own_navigation_is_no_rival(driver: str) -> None:
    topics = {
        "/move_base/status": {"type": "actionlib_msgs/GoalStatusArray", "by": ("/move_base",)},
        "/move_base/feedback": {"type": "move_base_msgs/MoveBaseActionFeedback"},
        "/cmd_vel": {"type": TWIST, "by": (driver,), "to": ("/base",)},
    }
    robot = old(topics)
    assert read(RosProposal(robot))["ros"]["navigation"] == "/move_base"
    assert ("publisher" in dangers(robot)) is (driver == "/teleop")


def test_velocities_that_nobody_takes_are_said() -> None:
    robot = found({"/cmd_vel": {"type": TWIST, "by": ("/teleop",)}, "/odom": ODOM})
    assert "no node subscribes to /cmd_vel: the robot will not move" in said(robot)


def test_what_is_not_understood_is_said() -> None:
    assert "/hazard_detection (irobot_create_msgs/HazardDetectionVector)" in said(turtlebot_4())
    assert "/head_pan_controller/command" not in said(ros_1())


@pytest.mark.parametrize(
    "name",
    [
        '/scan"\n[ros]\nhold = false #',
        "/scan\x1b[31m",
        "/scan\u202e",
        "/scan'''",
        "/" + "a" * 300,
        "scan",
        "/a b",
        "",
    ],
)
def test_a_name_that_is_none_gets_into_no_file(name: str) -> None:
    odd = {"type": LASER, "by": ("/x",), "said": scan('laser"\n[x]')}
    topics = {
        "/cmd_vel": TAKEN,
        "/odom": {**ODOM, "said": odometry('odom"\nhold = true', "base\x1b[2J")},
        "/good": odd,
        name: odd,
        f"{name} /cmd_vel": TAKEN,
    }
    proposal = RosProposal(found(topics, distribution='x"\n\x1b'))
    text = robot_file(proposal)
    assert text.replace("\n", "").isprintable()
    file = tomllib.loads(text)
    assert [each["topic"] for each in file["range"]] == ["/good"]
    assert file["ros"]["cmd_vel"] == "/cmd_vel"
    assert {*file} == {"name", "kind", "ros", "limits", "body", "range", "modules"}
    remarks = [*proposal.remarks()]
    assert all(line.isprintable() for line in remarks)
    assert any("names that ROS does not allow" in line for line in remarks)


def test_messages_that_are_not_what_their_type_says_leave_their_part_out() -> None:
    lies: list[dict[str, Any]] = [
        {},
        {"header": 7},
        {**scan("laser"), "ranges": "much"},
        {**scan("laser"), "angle_increment": math.nan},
        {**scan("laser"), "range_max": -1.0},
        {**scan("laser"), "ranges": []},
    ]
    by = {"by": ("/x",)}
    topics: dict[str, Any] = {
        f"/scan_{number}": {"type": LASER, **by, "said": lie} for number, lie in enumerate(lies)
    }
    topics |= {"/cmd_vel": TAKEN, "/odom": {**ODOM, "said": {"child_frame_id": 3}}}
    topics["/eye/image_raw"] = {"type": "sensor_msgs/msg/Image", **by, "said": {}}
    info = {**camera_info("eye"), "width": "wide", "k": ["a"]}
    topics["/eye/camera_info"] = {"type": "sensor_msgs/msg/CameraInfo", **by, "said": info}
    robot = found(topics)
    file = read(RosProposal(robot))
    assert "range" not in file
    assert file["camera"][0]["fov_deg"] == 60
    for number in range(len(lies)):
        assert f"/scan_{number} is not used: " in said(robot)


def test_too_many_of_all_stay_within_bounds() -> None:
    laser = {"type": LASER, "by": ("/x",), "said": scan("laser", 360)}
    kinds = (("cmd_vel", TAKEN), ("odom", ODOM), ("scan", laser))
    topics = {f"/robot_{one}/{topic}": spec for one in range(700) for topic, spec in kinds}
    topics |= {f"/x{number}": {"type": "a/msg/B"} for number in range(3000)}
    proposal = RosProposal(found(topics, frames=TURTLEBOT_4_FRAMES))
    file = read(proposal)
    assert len(file["range"]) == 22, "8,192 beams in all"
    assert len({each["name"] for each in file["range"]}) == 22
    remarks = [*proposal.remarks()]
    assert len(remarks) < 60
    assert any("more sensors are not used" in line for line in remarks)
    assert any("and 695 more would too" in line for line in remarks)


def test_its_outline_comes_from_its_urdf_or_its_planner() -> None:
    assert len(read(RosProposal(ros_1()))["body"]["footprint"]) > 8
    broken = turtlebot_4(parameters={"/robot_state_publisher.robot_description": "<robot><li"})
    assert "its outline is not known: robot_description: is not XML" in said(broken)
    known = {"/local_costmap/local_costmap.robot_radius": 0.189, "/a.robot_radius": 1.0}
    assert read(RosProposal(turtlebot_4(parameters=known)))["body"]["radius"] == 0.189


def test_a_map_that_never_came_is_proposed_only() -> None:
    grid: dict[str, Any] = {"type": "nav_msgs/msg/OccupancyGrid", "by": ("/map_server",)}
    topics: dict[str, Any] = {"/cmd_vel": TAKEN, "/odom": ODOM, "/map": grid}
    assert '# map = "/map"    # nothing came on it' in robot_file(RosProposal(found(topics)))
    topics["/map"] = grid | {"said": {"header": header("map")}}
    assert read(RosProposal(found(topics)))["ros"]["map"] == "/map"


def test_simulated_time_is_said() -> None:
    robot = found({**TURTLEBOT_4}, parameters={"/slam.use_sim_time": True})
    assert "simulated time" in said(robot)
