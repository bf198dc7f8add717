"""Marks in the camera's picture, however many there are."""

from __future__ import annotations

import dataclasses
import re

from hub.gcm.mapping import INTEREST_POINTS
from tests.console.visualizers import known
from tests.messages import camera_state

NAME = "visualizeCameraImage"
CAMERA = camera_state(robot_x=0.0, robot_y=0.0, robot_theta=0.0)


def test_of_a_thousand_marks_the_nearest_are_written(made, draw) -> None:
    marks = [known.point(number, x=1.0 + 0.01 * number, y=0.0) for number in range(1000)]
    far = known.point(1000, x=30.0, y=0.0)
    behind = known.point(1001, x=-2.0, y=0.0)
    told = {INTEREST_POINTS.name: made.received(known.points(*marks, far, behind))}
    picture = dataclasses.replace(made.picture(), camera=CAMERA)
    robot = made.robot(picture=made.received(picture), messages=told)
    rows = draw(NAME, robot, (60, 200)).glyphs.tolist()
    lines = ["".join(chr(letter or 32) for letter in row) for row in rows]
    written = [int(number) for line in lines for number in re.findall(r"V(\d+)", line)]
    assert 0 < len(written) <= 24
    nearest = min(written)
    assert max(written) < nearest + 24
    # The camera does not see the ground at its feet.
    assert f"V{nearest} {1.0 + 0.01 * nearest:.1f} m" in " ".join(lines)
