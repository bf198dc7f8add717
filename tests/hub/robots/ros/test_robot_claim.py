"""One process of this machine has a robot with ROS: a second hub sends nothing until it ends."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

from hub.gcm.geometry import Twist
from hub.robots.ros.address import ros_address
from hub.robots.ros.body import RosBody
from hub.robots.ros.robot_claim import RobotClaim
from hub.robots.ros_table import RosTable
from tests.support.memory_ros_body import ROBOT, TWIST
from tests.support.memory_ros_line import MemoryLine, ros_robot
from tests.support.ports import free_port


class LateLine(MemoryLine):
    """A line that is up once it was advanced, as real ones are."""

    def advance(self, _now: float) -> None:
        if not self.state.up:
            self.find()


def test_a_topic_of_velocities_has_one_owner_until_that_ends() -> None:
    port = free_port()
    place = ros_address(f"ws://127.0.0.1:{port}")
    same = ros_address(f"ws://localhost:{port}")
    with (
        closing(RobotClaim(place, "/cmd_vel")) as first,
        closing(RobotClaim(same, "/cmd_vel")) as second,
    ):
        assert first.held(100.0)
        assert not second.held(100.0)
        assert second.rival == f"process {os.getpid()} of this machine"
        with closing(RobotClaim(place, "/other/cmd_vel")) as other:
            assert other.held(100.0), "it is another robot of the same bridge"
        first.close()
        assert not second.held(100.1), "it does not ask at each step"
        assert second.held(101.0)
        assert second.rival == ""


def test_a_robot_in_a_tunnel_is_the_same_one_at_another_port() -> None:
    port = free_port()
    first, second = (
        RosTable(address=f"ws://127.0.0.1:{each}", known_as="ssh me@robot ws://127.0.0.1:1")
        for each in (port, port + 1)
    )
    assert first.identity == second.identity
    with (
        closing(RobotClaim(ros_address(first.address), "/cmd_vel", first.known_as)) as claim,
        closing(RobotClaim(ros_address(second.address), "/cmd_vel", second.known_as)) as other,
        closing(RobotClaim(ros_address(second.address), "/cmd_vel", "ssh me@other")) as elsewhere,
    ):
        assert claim.held(100.0)
        assert not other.held(100.0)
        assert elsewhere.held(100.0)


def test_a_second_hub_sends_nothing_and_says_who_drives_until_the_first_ends(
    tmp_path: Path,
) -> None:
    place = ros_address(f"ws://127.0.0.1:{free_port()}")
    now = 100.0
    line = LateLine()
    line.lose()
    line.topic("/cmd_vel", TWIST)
    line.topic("/odom", "nav_msgs/msg/Odometry")
    with closing(RobotClaim(place, "/cmd_vel")) as first:
        assert first.held(now)
        claim = RobotClaim(place, "/cmd_vel")
        body = RosBody(ros_robot(tmp_path, ROBOT), line, lambda: now, claim)

        def drive() -> None:
            nonlocal now
            for velocity in (Twist(), Twist.planar(0.4, 0.0)):
                now += 0.6
                body.advance(0.6)
                body.command(velocity)

        drive()
        assert line.published == []
        (problem,) = body.sensors(0.0).diagnostics
        assert f"process {os.getpid()} of this machine has this robot" in problem.message
        first.close()
        drive()
        drive()
        assert line.sent("/cmd_vel")
        assert not any("has this robot" in each.message for each in body.sensors(0.0).diagnostics)
    body.close()
