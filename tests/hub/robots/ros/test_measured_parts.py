"""What a robot with ROS says of its parts, on a line in memory."""

import dataclasses

import pytest

from hub.robots.ros.line import RosService
from tests.support.memory_ros_body import RobotInMemory


@pytest.fixture
def robot(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return RobotInMemory(tmp_path)


def test_what_the_bridge_does_not_serve_is_a_problem_in_its_words(robot):
    refusals = {"/cmd_vel": "no type Twist", "/scan": "no library", "/e_stop": "it hangs"}
    robot.line.state = dataclasses.replace(robot.line.state, refusals=refusals)
    driving = (
        "the robot cannot be driven: the robot's bridge does not serve /cmd_vel: no type Twist"
    )
    assert robot.problem("/cmd_vel") == [driving]
    assert "no library" in robot.problem("/scan")[0]
    robot.line.services["/e_stop"] = RosService(name="/e_stop", type="std_srvs/srv/Trigger")
    robot.body.stop()
    robot.line.called[-1][2](None, "no answer in 1 s")
    assert robot.problem("/e_stop") == ["the service /e_stop failed: it hangs"]
