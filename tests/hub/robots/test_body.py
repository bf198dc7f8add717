"""What a robot file says of the robot's body."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.robots.description import RobotDescription, read_description


def described(tmp_path: Path, body: str) -> tuple[RobotDescription, list[str]]:
    path = tmp_path / "robot.toml"
    path.write_text(f'name = "crawler"\nkind = "simulated-magellan"\n[body]\n{body}\n')
    robot, problems = read_description(path)
    return robot, list(problems)


def test_a_file_that_says_nothing_of_the_body_has_the_usual_one(tmp_path: Path) -> None:
    robot, problems = described(tmp_path, "")
    assert not problems
    assert (robot.body.name, robot.body.kind) == ("crawler", "simulated-magellan")
    assert (robot.body.radius, robot.body.footprint) == (0.205, ())


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
            "radius = 0.2\nfootprint = [[1, 0], [0, 1], [-1, 0]]",
            "line 4: [body], key 'radius': 0.2",
        ),
        ("footprint = [[1, 0], [0, 1]]", "is not a list of the corners"),
        ("footprint = [[1, 0], [2, 0], [3, 0]]", "is not a list of the corners"),
        ("footprint = [[1, 0], [0, 9], [3, 0]]", "is not between -5 and 5"),
        ("footprint = 7", "is not a list of 1 to 32 values"),
    ],
)
def test_a_body_that_cannot_be_is_refused(tmp_path: Path, body: str, problem: str) -> None:
    _, problems = described(tmp_path, body)
    assert len(problems) == 1
    assert problem in problems[0]
