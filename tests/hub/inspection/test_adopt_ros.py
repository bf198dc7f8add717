"""`rune-hub adopt ws://...` and the doctor, as a person types them, with a simulated robot."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.robots.robot_file import read_description
from tests.support.command_line import rune_hub
from tests.support.ports import free_port
from tests.support.ros_robot import SimulatedRos


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimulatedRos]:
    with closing(SimulatedRos(tmp_path_factory.mktemp("ros"))) as running:
        yield running


def test_a_robot_gets_a_robot_file_that_check_accepts(robot: SimulatedRos, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    done = rune_hub("adopt", "-o", str(path), robot.address)
    assert done.returncode == ExitCode.OK, done.stderr
    assert f"{robot.address}: a robot with ROS 2" in done.stdout
    assert "stops 0.5 s after the last command" in done.stdout
    assert "unsafe" not in done.stdout
    file, problems = read_description(path)
    assert problems == []
    assert (file.kind, file.ros.address, file.ros.hold) == ("ros", robot.address, False)
    assert (file.ros.cmd_vel, file.ros.odom, file.ros.map) == ("/cmd_vel", "/odom", "/map")
    assert file.ros.stop_service == "/e_stop"
    (group,) = file.ranges
    assert (group.topic, group.beams, group.height) == ("/scan", 360, 0.18)
    (camera,) = file.cameras
    assert (camera.topic, camera.info) == ("/camera/image_raw/compressed", "/camera/camera_info")
    assert (camera.width_px, camera.forward, camera.pitch) == (160, 0.08, 0.0)
    assert rune_hub("check", str(path)).returncode == ExitCode.OK
    assert rune_hub("adopt", robot.address, "-o", str(path)).returncode == ExitCode.FAULT
    assert robot.commands() == [], "nothing is sent that moves it"


def test_json_says_what_stops_it(robot: SimulatedRos) -> None:
    done = rune_hub("adopt", "ros", robot.address, "--json", "--name", "scout")
    facts = json.loads(done.stdout)
    assert (facts["name"], facts["path"], facts["cmd_vel"]) == ("scout", None, "/cmd_vel")
    assert (facts["stops_after_s"], facts["hold"], facts["unsafe"]) == (0.5, False, [])
    assert 'name = "scout"' in facts["text"]


def test_the_doctor_says_what_stops_it_and_how_old_its_odometry_is(
    robot: SimulatedRos, tmp_path: Path
) -> None:
    path = tmp_path / "robot.toml"
    rune_hub("adopt", robot.address, "-o", str(path))
    said = rune_hub("doctor", str(path)).stdout
    assert "ok      ros: the robot stops 0.5 s after the last command" in said, said
    assert "ok      ros: /odom comes " in said
    assert "ok      ros: its own navigation /navigate_to_pose takes goals" in said
    path.write_text(path.read_text().replace('"/battery_state"', '"/no_such"'))
    path.write_text(path.read_text().replace('"/navigate_to_pose"', '"/no_action"'))
    robot.set_parameter("/diff_drive_controller.cmd_vel_timeout", 0.0)
    try:
        done = rune_hub("doctor", str(path))
        assert done.returncode == ExitCode.FAULT
        assert "problem ros: the robot keeps the last command for ever" in done.stdout
        assert "or write hold = true under [ros]" in done.stdout
        assert "warning ros: /no_such: the robot has no such topic" in done.stdout
        assert "warning ros: the robot's own navigation lacks /no_action/_action/" in done.stdout
        path.write_text(path.read_text().replace("[ros]", "[ros]\nhold = true"))
        assert "problem ros" not in rune_hub("doctor", str(path)).stdout
    finally:
        robot.set_parameter("/diff_drive_controller.cmd_vel_timeout", 0.5)
    assert "warning ros: the robot stops 0.5 s" in rune_hub("doctor", str(path)).stdout


@pytest.mark.parametrize("options", [("--ros1",), ("--twist",)])
def test_other_robots_are_adopted_and_their_dangers_said(
    options: tuple[str, ...], tmp_path: Path
) -> None:
    others = ("--no-timeout", "--other-publisher", "/teleop_joy")
    with closing(SimulatedRos(tmp_path, *options, *others)) as robot:
        facts = json.loads(rune_hub("adopt", robot.address, "--json").stdout)
    assert {each["name"] for each in facts["unsafe"]} == {"time-out", "publisher"}
    assert facts["hold"] is True
    assert "hold = true" in facts["text"]
    assert facts["title"].startswith("robot with ROS 1" if "--ros1" in options else "robot with")
    assert "geometry_msgs/Twist\n" in facts["text"] or "TwistStamped" in facts["text"]


def test_where_nothing_answers_it_says_so_and_writes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    done = rune_hub("adopt", f"ws://127.0.0.1:{free_port()}", "-o", str(path), "--seconds", "0.3")
    assert done.returncode == ExitCode.NO_HUB
    assert "no robot with ROS answers at ws://127.0.0.1:" in done.stderr
    assert not path.exists()


@pytest.mark.parametrize("address", ["ws://", "ws://robot:99999", "ws://a/b", "zenoh+tcp://"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    done = rune_hub("adopt", address)
    assert done.returncode == ExitCode.USAGE
    assert "is no address of a robot with ROS: write ws://HOST:8765" in done.stderr


def test_a_namespace_that_is_none_is_refused() -> None:
    done = rune_hub("adopt", "ws://127.0.0.1:1", "--namespace", 'a"b')
    assert done.returncode == ExitCode.USAGE
