"""What a robot file says of the robot's body."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from hub.gcm.body import Freedom, HoldKind, RangeKind
from hub.gcm.vehicle import Arming
from hub.robots.description import RobotDescription
from hub.robots.robot_file import read_description


def described(tmp_path: Path, body: str) -> tuple[RobotDescription, list[str]]:
    path = tmp_path / "robot.toml"
    path.write_text(f'name = "crawler"\nkind = "simulated-magellan"\n[body]\n{body}\n')
    robot, problems = read_description(path)
    return robot, list(problems)


def test_a_shipped_kind_brings_its_body(tmp_path: Path) -> None:
    robot, problems = described(tmp_path, "")
    assert not problems
    body = robot.body
    assert (body.name, body.kind) == ("crawler", "simulated-magellan")
    assert (body.radius, body.footprint, body.height) == (0.203, (), 0.45)
    assert [(each.name, each.beams) for each in body.ranges] == [("sonar", 16), ("infrared", 16)]
    assert body.ranges[0].step == pytest.approx(math.tau / 16)
    assert len(body.bumpers) == 16
    assert math.degrees(body.bumpers[4].direction) == pytest.approx(90.0)
    assert [each.name for each in body.cameras] == ["camera"]
    assert [(each.freedom, each.limit) for each in body.motions] == [
        (Freedom.SURGE, 0.5),
        (Freedom.YAW, 1.0),
    ]
    assert {each.name for each in body.frames} == {"sonar", "infrared", "camera"}


def test_a_robot_file_replaces_parts_of_the_body_of_its_kind(tmp_path: Path) -> None:
    robot, problems = described(
        tmp_path,
        "height = 0.6\n[limits]\nsway = 0.3\n"
        '[[range]]\nname = "front"\nkind = "laser"\nfarthest = 8.0\nbeams = 181\nfirst_deg = -90\n'
        'spread_deg = 180\n[camera]\nsource = "/dev/video9"',
    )
    assert not problems
    body = robot.body
    assert (body.radius, body.height) == (0.203, 0.6)
    assert [motion.freedom for motion in body.motions] == [
        Freedom.SURGE,
        Freedom.SWAY,
        Freedom.YAW,
    ]
    (front,) = body.ranges
    assert (front.kind, front.beams) == (RangeKind.LASER, 181)
    assert front.first + 180 * front.step == pytest.approx(math.pi / 2)
    assert body.cameras[0].horizontal_fov == pytest.approx(math.radians(60.0))
    assert not body.cameras[0].headlight
    assert len(body.bumpers) == 16


def test_a_file_of_another_kind_that_says_nothing_of_the_body_is_a_circle(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text('name = "crawler"\nkind = "crawler:KIND"\n')
    robot, problems = read_description(path)
    assert not problems
    assert (robot.body.radius, robot.body.footprint, robot.body.ranges) == (0.205, (), ())
    assert math.isnan(robot.body.height)


def test_each_mistake_of_the_parts_has_its_line(tmp_path: Path) -> None:
    _, problems = described(
        tmp_path,
        '[[range]]\nname = "a"\nkind = "sonar"\nfarthest = 2.0\n'
        '[[range]]\nname = "a"\nkind = "sonr"\nfarthest = 2.0\n'
        '[[range]]\nname = "a"\nkind = "sonar"\nfarthest = 2.0\nnearest = 3.0\n'
        '[[frame]]\nname = "b"\nparent = "c"\n'
        '[[frame]]\nname = "c"\nparent = "b"\n'
        '[[camera]]\nname = "rear"\nparent = "bb"\n'
        "[[bumper]]\nwidth = 7\n",
    )
    assert problems == [
        "line 10: [[range]] 2, key 'kind': 'sonr' is none of sonar, infrared, laser, echo sounder;"
        " did you mean 'sonar'?",
        "line 16: [[range]] 3, key 'nearest': 3 m is more than 'farthest', 2 m",
        "line 27: [[bumper]] 1: unknown key 'width'; did you mean 'width_deg'?",
        "line 26: [[bumper]] 1: key 'name' is missing",
        "line 13: [[range]] 3, key 'name': 'a' is the name of another frame",
        "line 19: [[frame]] 1, key 'parent': 'c' leads back to 'b'",
        "line 22: [[frame]] 2, key 'parent': 'b' leads back to 'c'",
        "line 25: [[camera]] 1, key 'parent': 'bb' is no frame; did you mean 'b'?",
    ]


def test_the_circle_encloses_the_footprint(tmp_path: Path) -> None:
    robot, problems = described(tmp_path, "footprint = [[0.4, -0.3], [-0.4, -0.3], [0, 0.5]]")
    assert not problems
    assert robot.radius == pytest.approx(0.5)
    around = [(point.x, point.y) for point in robot.body.footprint]
    assert around == [(0.0, 0.5), (-0.4, -0.3), (0.4, -0.3)], "counter-clockwise"
    assert len(robot.body.footprint) == 3


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        (
            "radius = 0.2\nfootprint = [[1, -1], [0, 1], [-1, -1]]",
            "line 4: [body], key 'radius': 0.2",
        ),
        ("footprint = [[1, 0], [0, 1]]", "is not a list of the corners"),
        ("footprint = [[1, 0], [2, 0], [3, 0]]", "is not a list of the corners"),
        ("footprint = [[1, 0], [0, 9], [3, 0]]", "is not between -5 and 5"),
        ("footprint = 7", "is not a list of 1 to 32 values"),
        (
            "footprint = [[0, 0], [0.6, 0], [0.6, 0.4], [0, 0.4]]",
            "does not enclose [0, 0], the point where the robot turns",
        ),
        ("footprint = [[1, 1], [2, 1], [2, 2], [1, 2]]", "does not enclose [0, 0]"),
        (
            "footprint = [[1, 1], [-1, -1], [1, -1], [-2, 1]]",
            "crosses itself between [1, 1] and [-1, -1]",
        ),
        (
            '[[range]]\nname = "a"\nkind = "laser"\nbeams = 4096\nfarthest = 9\n'
            '[[range]]\nname = "b"\nkind = "laser"\nbeams = 4096\nfarthest = 9\n'
            '[[range]]\nname = "c"\nkind = "laser"\nfarthest = 9\n',
            "line 4: 8193 beams of all [[range]] are more than the 8192 allowed",
        ),
    ],
)
def test_a_body_that_cannot_be_is_refused(tmp_path: Path, body: str, problem: str) -> None:
    _, problems = described(tmp_path, body)
    assert len(problems) == 1
    assert problem in problems[0]


def test_a_body_has_only_the_motions_with_a_limit(tmp_path: Path) -> None:
    robot, problems = described(tmp_path, "[limits]\nlinear = 0\nangular = 0\nsway = 0.3")
    assert not problems
    assert [(each.freedom, each.limit) for each in robot.body.motions] == [(Freedom.SWAY, 0.3)]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('limits = 3\n[modules.driver]\nrun = "x"\n', "line 3: [limits]: 3 is not a table"),
        ("modules = 3\n", "line 3: modules has to be tables: [modules.NAME]"),
    ],
)
def test_a_value_in_the_place_of_a_table_has_its_line(
    tmp_path: Path, text: str, problem: str
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(f'name = "crawler"\nkind = "crawler:KIND"\n{text}')
    assert list(read_description(path)[1]) == [problem]


def test_a_file_of_a_windows_editor_is_read(tmp_path: Path) -> None:
    """It begins with a mark of its byte order, and its lines end with two characters."""
    path = tmp_path / "robot.toml"
    path.write_bytes(b'\xef\xbb\xbfname = "crawler"\r\nkind = "crawler:KIND"\r\n')
    robot, problems = read_description(path)
    assert not problems
    assert robot.name == "crawler"


def test_holds_lights_and_joints_are_described(tmp_path: Path) -> None:
    robot, problems = described(
        tmp_path,
        'arming = "disarmed"\n[[hold]]\nkind = "depth"\n[[hold]]\nkind = "heading"\n'
        '[[light]]\nname = "beacon"\n[[joint]]\nname = "arm"\nlowest_deg = -90\nhighest_deg = 45\n',
    )
    assert not problems
    body = robot.body
    depth, heading = body.holds
    assert (depth.kind, depth.tolerance) == (HoldKind.DEPTH, 0.3)
    assert (heading.kind, math.degrees(heading.tolerance)) == (
        HoldKind.HEADING,
        pytest.approx(20.0),
    )
    assert [(each.name, each.camera) for each in body.lights] == [
        ("headlight", "camera"),
        ("beacon", ""),
    ]
    (joint,) = body.joints
    assert (joint.name, math.degrees(joint.highest)) == ("arm", pytest.approx(45.0))
    assert math.degrees(joint.speed) == pytest.approx(45.0)
    assert body.arms
    assert robot.arming is Arming.DISARMED


def test_each_mistake_of_holds_lights_and_joints_has_its_line(tmp_path: Path) -> None:
    _, problems = described(
        tmp_path,
        'arming = "yes"\n[[hold]]\nkind = "dept"\n[[hold]]\nkind = "depth"\n[[hold]]\n'
        'kind = "depth"\n[[light]]\nname = "headlight"\n[[joint]]\nname = "arm"\n'
        "lowest_deg = 9\nhighest_deg = 1\n",
    )
    assert problems == [
        "line 4: [body], key 'arming': 'yes' is none of none, disarmed, armed",
        "line 6: [[hold]] 1, key 'kind': 'dept' is none of height, depth, heading, position;"
        " did you mean 'depth'?",
        "line 10: [[hold]] 3, key 'kind': there is another hold 'depth'",
        "line 12: [[light]] 1, key 'name': there is another light 'headlight'",
        "line 15: [[joint]] 1, key 'lowest_deg': 9 is not less than 'highest_deg', 1",
    ]
