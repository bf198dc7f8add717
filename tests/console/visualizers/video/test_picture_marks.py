"""Marks in the camera's picture, however many there are."""

from __future__ import annotations

import dataclasses
import re

from hub.gcm.mapping import INTEREST_POINTS, PointKind
from rune_tui.model.console_state import ConsoleState, Ghost
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas
from rune_tui.view import View
from tests.console import view_scenes
from tests.console.states import layout_of
from tests.console.visualizers import known
from tests.console.visualizers.conftest import made_by, words
from tests.support.messages import camera_state

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


def test_ranges_over_the_picture_cover_neither_marks_nor_the_ghost(made) -> None:
    told = {INTEREST_POINTS.name: made.received(known.points(known.point(7, x=2.0, y=0.2)))}
    picture = dataclasses.replace(made.picture(), camera=CAMERA)
    robot = made.robot(picture=made.received(picture), messages=told)
    place = WorldPoint(x=2.0, y=-0.4, uncertainty=0.1, distance=2.0)
    ghost = Ghost(kind=PointKind.VICTIM, place=place, until=made.now + 5.0)
    state = ConsoleState(now=made.now, robots={"magellan": robot}, ghosts={"magellan": ghost})
    view = View(
        layout_of(
            view_scenes.view(
                view_scenes.viewport("visualizeCameraImage", (0, 0, 160, 96)),
                view_scenes.viewport("visualizeRangeData", (32, 0, 96, 96), zpos=2),
                view_scenes.viewport("visualizePanData", (0, 94, 20, 2), zpos=3),
            )
        )
    )
    view.resize(160, 48)
    cells = view.render(state)
    assert cells is not None
    text = view_scenes.words(cells)
    assert "V7 2.0 m" in text
    assert "victim? 2.0 m" in text


def test_a_mark_on_a_wall_is_written_where_it_was_clicked_and_not_on_the_floor(made) -> None:
    rows: dict[float, int] = {}
    for height in (0.0, 0.4):
        mark = known.point(7, x=2.5, y=0.0, height=height)
        told = {INTEREST_POINTS.name: made.received(known.points(mark))}
        picture = dataclasses.replace(made.picture(), camera=CAMERA)
        robot = made.robot(picture=made.received(picture), messages=told)
        lines = words(drawn(robot, (60, 60), made.now))
        (rows[height],) = (row for row, line in enumerate(lines) if "V7 2.5 m" in line)
    assert rows[0.4] < rows[0.0]


def drawn(robot, size: tuple[int, int], now: float) -> Canvas:
    """The picture of a robot."""
    canvas = Canvas.blank(*size)
    made_by(NAME).draw(canvas, robot, ConsoleState(now=now))
    return canvas
