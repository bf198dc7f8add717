"""The line over Zenoh with a robot whose nodes others wrote: zenoh-ros2-sdk."""

from __future__ import annotations

import time
from contextlib import closing

from hub.gcm.geometry import Twist
from hub.robots.ros.address import ros_address
from hub.robots.ros.commands import TYPES, velocity_payload
from hub.robots.ros.line import RosMessage
from hub.robots.ros.opening import line_to
from hub.robots.ros_table import CommandType
from hub.ros.decoding import RosDecoder
from tests.support.sdk_nodes import SdkNode
from tests.support.waiting import until
from tests.support.zenoh_router import zenoh_router


def test_a_robot_of_others_is_found_read_and_driven() -> None:
    came: list[RosMessage] = []
    with zenoh_router() as router, closing(SdkNode("robot", router.port)) as robot:
        address = ros_address(f"zenoh+tcp://127.0.0.1:{router.port}")
        with closing(line_to(address)) as line:

            def advance() -> None:
                line.advance(time.monotonic())

            until(lambda: "/cmd_vel" in line.graph.topics, 20.0, meanwhile=advance)
            command = line.graph.topics["/cmd_vel"]
            assert command.schema_name == TYPES[CommandType.STAMPED]
            assert command.subscribers == ("/base",)
            line.subscribe("/odom", came.append)
            line.advertise("/cmd_vel", command.schema_name)
            until(lambda: came, 20.0, meanwhile=advance)

            def drive() -> None:
                advance()
                payload = velocity_payload(Twist.planar(0.3, -0.2), CommandType.STAMPED, "cdr")
                line.publish("/cmd_vel", payload)

            until(lambda: robot.newest == {"linear": 0.3, "angular": -0.2}, 20.0, meanwhile=drive)
            came.clear()
            until(lambda: len(came) > 2, 20.0, meanwhile=advance)
            value = RosDecoder.of(came[-1].topic).decode(came[-1].payload)
            assert value.get("twist.twist.linear.x") == 0.3
            assert came[-1].age < 5.0
            assert line.state.faults == 0
