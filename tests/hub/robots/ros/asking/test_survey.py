"""A look at a robot through a line in memory, with the time given."""

from __future__ import annotations

import dataclasses

from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.survey import ROOT, RosSurvey
from hub.robots.ros.line import TakeParameters
from hub.ros.standard_types import CompressedImage
from tests.support.memory_ros_line import MemoryLine, cdr
from tests.support.ros_findings import ADDRESS

TIME_OUT = "/base.cmd_vel_timeout"


class SlowLine(MemoryLine):
    """It learns of nodes only after a while, as a line over Zenoh does."""

    def ask_parameters(
        self, _names: tuple[str, ...], answered: TakeParameters, _timeout: float
    ) -> None:
        answered({TIME_OUT: 0.5} if self.graph.topics else {})


def test_parameters_are_asked_for_once_nodes_are_known() -> None:
    line = SlowLine(whole=True)
    survey = RosSurvey(line, ros_address(ADDRESS))
    assert not survey.advance(0.0)
    line.topic("/cmd_vel", "geometry_msgs/msg/Twist")
    assert not survey.advance(1.0)
    assert survey.findings.parameters == {TIME_OUT: 0.5}
    assert survey.advance(3.0)
    assert survey.findings.takes
    assert not line.published


def test_a_line_that_does_not_say_yet_which_nodes_publish_gets_more_time() -> None:
    """The bridge for ROS 2 says it with the next change of the graph."""
    line = SlowLine()
    line.topic("/cmd_vel", "geometry_msgs/msg/Twist")
    survey = RosSurvey(line, ros_address(ADDRESS))
    assert not survey.advance(0.0)
    assert not survey.advance(1.0)
    assert not survey.advance(3.0)
    line.whole = True
    assert survey.advance(3.1)


def test_a_large_picture_is_read() -> None:
    line = MemoryLine()
    survey = RosSurvey(line, ros_address(ADDRESS))
    line.topic("/camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage")
    assert not survey.advance(0.0)
    picture = CompressedImage(format="jpeg", data=b"\xff" * 2_000_000)
    line.give("/camera/image_raw/compressed", cdr(picture), 0.1)
    found = survey.findings.of("/camera/image_raw/compressed")
    assert (found.fault, found.messages) == ("", 1)


def test_the_robot_without_a_namespace_is_chosen_among_others() -> None:
    line = MemoryLine()
    for name in ("", "/two"):
        line.topic(f"{name}/cmd_vel", "geometry_msgs/msg/Twist")
        line.topic(f"{name}/odom", "nav_msgs/msg/Odometry")
    line.topic("/two/tf", "tf2_msgs/msg/TFMessage")
    survey = RosSurvey(line, ros_address(ADDRESS), ROOT)
    assert not survey.advance(0.0)
    found = survey.findings
    assert (found.namespace, found.others) == ("", ("/two",))
    assert line.advertised == {"/cmd_vel": "geometry_msgs/msg/Twist"}


def test_what_the_bridge_does_not_serve_is_found_and_not_waited_for() -> None:
    line = SlowLine(whole=True)
    line.topic("/cmd_vel", "geometry_msgs/msg/Twist")
    line.topic("/odom", "nav_msgs/msg/Odometry", publishers=("/base",))
    survey = RosSurvey(line, ros_address(ADDRESS))
    assert not survey.advance(0.0)
    assert not survey.advance(3.0)
    line.state = dataclasses.replace(line.state, refusals={"/odom": "no type", "/cmd_vel": "none"})
    assert survey.advance(3.1)
    assert survey.findings.of("/odom").fault == "no type"
    assert survey.findings.refusals["/cmd_vel"] == "none"


class Described(SlowLine):
    """Its robot has a description."""

    text = ""

    def ask_parameters(
        self, _names: tuple[str, ...], answered: TakeParameters, _timeout: float
    ) -> None:
        answered({"/state.robot_description": f"<robot>{self.text}</robot>"})


def looked_at(line: Described, text: str) -> RosSurvey:
    """A look that has seen all but what is fetched at its end."""
    line.text = text
    line.topic("/cmd_vel", "geometry_msgs/msg/Twist")
    survey = RosSurvey(line, ros_address(ADDRESS))
    for now in (0.0, 1.0, 3.0):
        survey.advance(now)
    return survey


def test_meshes_are_fetched_that_the_outline_needs() -> None:
    def link(name: str, *kinds: str) -> str:
        shapes = "".join(
            f'<{kind}><geometry><mesh filename="package://r/{name}-{kind}.stl"/></geometry></{kind}>'
            for kind in kinds
        )
        return f'<link name="{name}">{shapes}</link>'

    line = Described(whole=True, files={"package://r/a-collision.stl": b"solid"})
    survey = looked_at(line, link("a", "collision", "visual") + link("b", "visual"))
    assert line.fetched == ["package://r/a-collision.stl", "package://r/b-visual.stl"]
    assert survey.findings.files == {
        "package://r/a-collision.stl": b"solid",
        "package://r/b-visual.stl": "there is no such file",
    }
    assert survey.advance(3.1)


def test_a_description_with_very_many_meshes_is_not_fetched_whole() -> None:
    shapes = "".join(
        f'<collision><geometry><mesh filename="package://r/{each}.stl"/></geometry></collision>'
        for each in range(200)
    )
    line = Described(whole=True)
    survey = looked_at(line, f'<link name="a">{shapes}</link>')
    assert len(line.fetched) == 64
    assert survey.advance(3.1)
    assert "too many" in str(survey.findings.files["package://r/199.stl"])
