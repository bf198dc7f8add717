"""visualizeMapData."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.gcm.navigation import NAVIGATION_STATUS, Cause, NavigationStatus, Point, Task
from hub.gcm.occupancy_map import OccupancyMap
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase
from rune_tui.model.theme import DARK, LIGHT
from rune_tui.raster.canvas import Canvas
from rune_tui.view import View
from rune_tui.visualizers.maps.map_data import MapData
from tests.console.states import (
    ABSENT,
    COMING,
    layout_of,
    rendered,
    standing,
    view_of,
    visualizer_spec,
)
from tests.console.visualizers.conftest import NOW, made_by, words
from tests.support.cases import for_each

NAME = "visualizeMapData"
SIZE = (100, 80)
STATE = ConsoleState(now=100.0)
WALL = 4.0
"""How far north the wall is [m]."""


def room() -> OccupancyMap:
    """20 m by 20 m around the origin, known 5 m around it, with a wall from west to east."""
    cells = np.full((200, 200), -1, np.int8)
    cells[50:150, 50:150] = 0
    cells[140:143, 50:150] = 100
    return OccupancyMap(cells=cells, resolution=0.1, origin_x=-10.0, origin_y=-10.0)


def victim(number: int, x: float, y: float, kind: PointKind = PointKind.VICTIM) -> InterestPoint:
    return InterestPoint(number=number, kind=kind, x=x, y=y, thumbnail=np.empty(0, np.uint8))


def going(*way: tuple[float, float], task: Task = Task.GOING, **changes: Any) -> NavigationStatus:
    path = tuple(Point(x=x, y=y) for x, y in way)
    rest = {"number": 1, "sender": 0, "driver": 0, "points_left": 1, "distance_left": 1.0}
    x, y = way[-1]
    values = {"x": x, "y": y} | rest | changes
    return NavigationStatus(task=task, why="", path=path, **values)


def robot_in(made, *, age=0.1, map_age=1.0, number=1, points=(), status=None, **changes):
    """A robot in the room; it stands in the middle of it unless told otherwise."""
    messages = {INTEREST_POINTS.name: made.received(InterestPoints(points=points))}
    if status is not None:
        messages[NAVIGATION_STATUS.name] = made.received(status)
    parts = {
        "map": made.received(room(), map_age, number),
        "navigation": made.received(made.navigation(**changes), age),
        "messages": messages,
    }
    return made.robot(**parts)


def at(canvas, x: float, y: float, across: float = 10.0) -> tuple[int, int, int]:
    """The colour of a place [m], north up, the origin in the middle."""
    scale = across / canvas.width
    column, row = int(canvas.width / 2 + x / scale), int(canvas.height / 2 - y / scale)
    red, green, blue, alpha = canvas.pixels[row, column].tolist()
    assert alpha == 255
    return red, green, blue


def spots(canvas, colour) -> np.ndarray:
    """x and y of the pixels of a colour, shape (n, 2)."""
    return np.argwhere((canvas.pixels[..., :3] == colour[:3]).all(axis=2))[:, ::-1]


def where(canvas, word: str) -> tuple[int, int] | None:
    """Column and row of a word."""
    for row, line in enumerate(words(canvas)):
        if word in line:
            return line.index(word), row
    return None


def text(canvas) -> str:
    return " ".join(" ".join(words(canvas)).split())


def test_walls_are_bright_free_ground_grey_and_the_unknown_dark_and_dotted(
    made, draw, golden
) -> None:
    canvas = draw(NAME, robot_in(made), SIZE, option=12.0)
    assert at(canvas, 2.0, WALL + 0.15, 12.0) == DARK.wall[:3]
    assert at(canvas, 2.0, WALL - 1.0, 12.0) == DARK.floor[:3]
    unknown = canvas.pixels[20:60, :5, :3].reshape(-1, 3)
    shades, counts = np.unique(unknown, axis=0, return_counts=True)
    assert len(shades) == 2
    assert 0.05 < counts.min() / counts.sum() < 0.3
    # Without hue, too, they are apart, and what is free is not the darkest.
    levels = [float(np.mean(colour[:3])) for colour in (shades[0], DARK.floor, DARK.wall)]
    assert np.diff(levels).min() > 50.0
    golden("map_data", draw(NAME, robot_in(made), (40, 30), option=12.0))


def test_what_is_nearly_sure_looks_sure(made, draw) -> None:
    grid = room()
    grid.cells[grid.cells == 100] = 70
    grid.cells[grid.cells == 0] = 25
    robot = robot_in(made).with_(map=made.received(grid))
    canvas = draw(NAME, robot, SIZE)
    assert at(canvas, 2.0, WALL - 0.05) == DARK.floor[:3]
    assert at(canvas, 2.0, 3.0) == DARK.floor[:3]


def test_the_robot_is_in_the_middle_and_points_where_it_is_heading(made, draw) -> None:
    for theta, ahead in ((0.0, (1, 0)), (math.pi / 2, (0, -1)), (math.pi, (-1, 0))):
        canvas = draw(NAME, robot_in(made, x=1.0, y=2.0, theta=theta), SIZE)
        arrow = spots(canvas, DARK.robot) + 0.5 - (50.0, 40.0)
        assert len(arrow) > 5
        assert np.abs(arrow.mean(axis=0)).max() < 3.0
        tip = arrow @ ahead
        # Slender towards the tip: most of it is behind its middle.
        assert (tip < tip.max() / 2 + tip.min() / 2).mean() > 0.5


def test_the_option_and_the_zoom_say_how_much_is_seen(made) -> None:
    robot = robot_in(made)
    for across, zoom in ((10.0, 1.0), (20.0, 1.0), (10.0, 0.5), (40.0, 2.0)):
        spec = dataclasses.replace(visualizer_spec(NAME, option=across), viewport="map")
        shown = MapData.from_spec(spec)
        state = dataclasses.replace(STATE, zooms={"map": zoom})
        place = shown.locate((75.0, 20.0), SIZE, robot, state)
        metres = across / zoom / 100.0
        assert (place.x, place.y) == pytest.approx((25.0 * metres, 20.0 * metres))


def test_everything_known_is_seen_when_the_whole_map_is_wanted(made, draw) -> None:
    canvas = draw(NAME, robot_in(made, x=4.0, y=-4.0), SIZE, show="whole")
    walls = spots(canvas, DARK.wall)
    across = walls[walls[:, 1] < 20]
    assert np.ptp(across[:, 0]) == pytest.approx(80 / 1.08, abs=2.0)
    free = spots(canvas, DARK.floor)
    assert free[:, 1].max() < 80
    assert free.min() > 1


@pytest.mark.parametrize("theta", [0.3, 0.8, 2.0])
def test_everything_known_is_seen_however_it_is_turned(made, draw, theta) -> None:
    canvas = draw(NAME, robot_in(made, theta=theta), (80, 80), show="whole", up="robot")
    free = spots(canvas, DARK.floor)
    assert 1 <= free.min() <= 5
    assert 74 <= free.max() <= 78


@for_each("theta", [0.1 + index * math.pi / 8.0 for index in range(16)])
def test_where_a_robot_of_eight_pixels_heads_can_be_seen(made, draw, theta) -> None:
    canvas = draw(NAME, robot_in(made, theta=theta), (40, 40), option=40.0)
    pixels = canvas.pixels[14:26, 14:26, :3].astype(float)
    # What is bright as the dart is: on its bow it is narrow, so its middle is behind its outline's.
    away = np.abs(pixels - DARK.robot[:3]).sum(axis=2)
    dart = np.argwhere(away < 160.0)[:, ::-1]
    assert 4 <= np.ptp(dart, axis=0).max() <= 10
    middle = (dart.max(axis=0) + dart.min(axis=0)) / 2.0
    reach = np.array([math.cos(theta), -math.sin(theta)])
    along = (dart - middle) @ reach
    aside = np.abs((dart - middle) @ np.array([reach[1], -reach[0]]))
    assert aside[along > 1.0].max(initial=0.0) < aside[along < 0.0].max() + 0.5


def test_the_robots_heading_is_up_when_that_is_wanted(made, draw) -> None:
    robot = robot_in(made, theta=0.0)
    canvas = draw(NAME, robot, SIZE, up="robot")
    # North is to its left.
    assert canvas.pixels[40, 50 - 41, :3].tolist() == list(DARK.wall[:3])
    column, row = where(canvas, "N")
    assert column <= 1
    assert 18 <= row <= 21
    north = draw(NAME, robot, SIZE)
    column, row = where(north, "N")
    assert 48 <= column <= 51
    assert row <= 1


@for_each("options", [{}, {"up": "robot"}, {"show": "whole"}, {"option": 3.0}])
def test_a_click_gives_the_place_that_is_drawn_there(made, draw, options) -> None:
    marks = (victim(1, -1.0, 0.5),)
    robot = robot_in(made, x=-0.5, y=0.25, theta=0.7, points=marks)
    canvas = draw(NAME, robot, SIZE, **options)
    column, row = where(canvas, "V1")
    shown: Any = made_by(NAME, **options)
    place = shown.locate((column + 0.5, 2 * row + 1.0), SIZE, robot, STATE)
    # The letter is on the cell of one by two pixels that the place is in.
    scale = (20.0 if "show" in options else options.get("option", 10.0)) / 100.0
    assert math.dist((place.x, place.y), (-1.0, 0.5)) <= 1.2 * scale
    assert math.isnan(place.distance)


def test_a_place_is_as_sure_as_a_pixel_or_a_cell(made) -> None:
    robot = robot_in(made)
    shown: Any = made_by(NAME, option=100.0)
    coarse = shown.locate((3.0, 4.0), SIZE, robot, STATE)
    assert coarse.uncertainty == pytest.approx(math.sqrt(0.5))
    shown = made_by(NAME, option=1.0)
    fine = shown.locate((3.0, 4.0), SIZE, robot, STATE)
    assert fine.uncertainty == pytest.approx(0.1 * math.sqrt(0.5))


def test_what_was_found_has_a_letter_and_its_number(made, draw) -> None:
    marks = (victim(3, 2.0, 1.0), victim(4, -2.0, -1.0, PointKind.LANDMARK), victim(5, 90.0, 0.0))
    canvas = draw(NAME, robot_in(made, points=marks), SIZE)
    assert where(canvas, "V3") == (70, 15)
    assert where(canvas, "L4") == (30, 25)
    assert where(canvas, "V5") is None


def test_its_route_is_dashed_and_ends_at_a_letter_while_it_goes(made, draw) -> None:
    way = (0.0, 0.0), (3.0, 0.0), (3.0, 2.0)
    canvas = draw(NAME, robot_in(made, status=going(*way)), SIZE)
    assert where(canvas, "G") == (80, 10)
    dashes = spots(canvas, DARK.good)
    row = dashes[dashes[:, 1] == 40]
    assert 8 < len(row) < 27
    done = draw(NAME, robot_in(made, status=going(*way, task=Task.REACHED, ended_s=99.0)), SIZE)
    assert where(done, "G") is None
    assert not len(spots(done, DARK.good))


@for_each(
    ("fields", "word"),
    [
        ({"cause": Cause.CLOSED}, "G waits"),
        ({"task": Task.REACHED, "ended_s": 1.0}, "G reached"),
        ({"task": Task.BLOCKED, "cause": Cause.CLOSED, "ended_s": 60.0}, "G BLOCKED"),
        ({"task": Task.CANCELLED, "cause": Cause.STOP, "ended_s": 1.0}, "G STOPPED"),
        ({"task": Task.CANCELLED, "cause": Cause.STICK, "ended_s": 1.0}, "G ENDED"),
        ({"task": Task.CANCELLED, "cause": Cause.BUSY, "ended_s": 1.0}, "G GIVEN UP"),
    ],
)
def test_its_goal_stays_for_a_while_with_its_outcome(made, draw, fields, word: str) -> None:
    before = going((0.0, 0.0), (3.0, 2.0))
    status = going((0.0, 0.0), (3.0, 2.0), **fields)
    found = where(draw(NAME, robot_in(made, status=status), SIZE), word)
    assert found is not None
    assert found[1] == 10
    map_data = made_by(NAME)
    state = ConsoleState(now=NOW)
    assert map_data.source(robot_in(made, status=status), state) != map_data.source(
        robot_in(made, status=before), state
    )


def test_the_view_cone_turns_with_the_camera(made, draw) -> None:
    for pan, side in ((0.8, 1), (-0.8, -1)):
        camera = made.received(made.camera(pan=pan, horizontal_fov=0.4))
        robot = made.robot(map=made.received(room()), camera=camera)
        lines = spots(draw(NAME, robot, SIZE), DARK.cone)
        near = lines[(np.abs(lines[:, 1] - 40) > 6) & (np.abs(lines[:, 1] - 40) < 25)]
        near = near[(near[:, 0] > 50) & (near[:, 0] < 75)]
        assert len(near) > 4
        assert (np.sign(40 - near[:, 1]) == side).all()


def test_the_trail_shows_where_it_has_been_as_long_as_the_option_says(made) -> None:
    shown = made_by(NAME, trail=2.0)
    for step in range(60):
        shown.source(robot_in(made, x=-3.0 + 0.05 * step, y=-1.0), STATE)
    canvas = Canvas.blank(*SIZE)
    shown.draw(canvas, robot_in(made), STATE)
    trail = spots(canvas, DARK.faint)
    straight = trail[trail[:, 1] == 50]
    assert 15 <= len(straight) <= 23
    assert straight[:, 0].max() >= 47


def test_a_jump_of_the_pose_leaves_no_trail(made) -> None:
    shown = made_by(NAME)
    for x in (-3.0, -2.8, 2.8, 3.0):
        shown.source(robot_in(made, x=x, y=-1.0), STATE)
    canvas = Canvas.blank(*SIZE)
    shown.draw(canvas, robot_in(made, x=3.0, y=-1.0), STATE)
    # The robot, three metres east, is in the middle.
    columns = spots(canvas, DARK.faint)[:, 0]
    assert not ((columns > -8 + 5) & (columns < 45)).any()


def test_the_scale_is_a_bar_of_a_round_length(made, draw) -> None:
    for across, length in ((10.0, 2.0), (25.0, 5.0), (1.3, 0.2)):
        canvas = draw(NAME, robot_in(made), SIZE, option=across)
        assert f"{length:g} m" in words(canvas)[-1]
        bar = sum(words(canvas)[-1].count(sign) for sign in "├─┤")
        assert bar == pytest.approx(100.0 * length / across, abs=1.0)


@for_each(
    ("lacking", "told"),
    [
        ({"PRO_MAP": COMING}, "no map from magellan: PRO_MAP: not started yet"),
        ({"PRO_MAP": ABSENT}, "no map from magellan: PRO_MAP: this robot has no module"),
        ({}, "waiting for the first map from magellan"),
    ],
)
@for_each("navigation", [True, False])
def test_without_a_map_words_say_why(made, draw, lacking, told, navigation) -> None:
    parts = {} if navigation else {"navigation": None}
    canvas = draw(NAME, made.robot(link=made.link(lacking=lacking), **parts), (60, 30))
    assert told in text(canvas)


def test_a_lost_link_is_said(made, draw) -> None:
    robot = robot_in(made).with_(link=made.link(LinkPhase.LOST, detail="gone"))
    canvas = draw(NAME, robot, (80, 30))
    # The banner says it; the map stays to be seen.
    assert "no link" not in text(canvas)
    empty = made.robot(link=made.link(LinkPhase.LOST, detail="gone"))
    told = text(draw(NAME, empty, (80, 30)))
    assert "no link to magellan at tcp://10.0.0.5:1381: retrying, 3 s; gone" in told


def test_an_unknown_position_is_said_and_the_map_shown(made, draw) -> None:
    robot = made.robot(map=made.received(room()), navigation=None)
    canvas = draw(NAME, robot, SIZE, option=12.0)
    assert "position unknown" in words(canvas)[-1]
    assert at(canvas, 2.0, WALL + 0.15, 12.0) == DARK.wall[:3]
    assert not len(spots(canvas, DARK.robot))


def test_an_old_map_is_said_and_an_old_position_dimmed_then_hatched_and_marked(made, draw) -> None:
    assert "map" not in text(draw(NAME, robot_in(made, map_age=29.0), SIZE))
    assert "map 45 s old" in words(draw(NAME, robot_in(made, map_age=45.9), SIZE))[-1]
    fresh, old, stale = (draw(NAME, robot_in(made, age=age), SIZE) for age in (0.1, 2.0, 5.0))
    assert old.pixels[..., :3].max() < fresh.pixels[..., :3].max()
    assert (stale.pixels[2:, :, :3] < old.pixels[2:, :, :3]).any()
    assert "STALE 5.0 s" in words(stale)[0]


def test_the_token_changes_only_with_what_is_drawn(made) -> None:
    shown = made_by(NAME, trail=0.0)

    def token(state: ConsoleState = STATE, **changes):
        return shown.source(robot_in(made, **changes), state)

    first = token()
    assert first == token(x=0.001, theta=0.001) == token(battery_fraction=0.1) == token(map_age=9.0)
    for other in (
        {"number": 2},
        {"x": 0.1},
        {"theta": 0.1},
        {"age": 2.0},
        {"map_age": 40.0},
        {"points": (victim(1, 2.0, 3.0),)},
        {"status": going((0.0, 0.0), (1.0, 1.0))},
    ):
        assert token(**other) != first, other
    assert token(dataclasses.replace(STATE, theme=LIGHT)) != first
    assert token(dataclasses.replace(STATE, zooms={"": 2.0})) != first
    assert isinstance(hash(first), int)


def screen_of(**changes) -> View:
    """A map that fills a view of 100x80 pixels."""
    shown = dataclasses.replace(visualizer_spec(NAME, **changes), viewport="map")
    view = view_of(standing("map", shown, (0, 0, 100, 80)), xsize=100, ysize=80)
    screen = View(layout_of(view))
    screen.resize(100, 40)
    return screen


def test_the_trail_outlives_another_size_of_the_terminal(made) -> None:
    screen = screen_of()
    for step in range(20):
        rendered(screen, {"magellan": robot_in(made, x=-2.0 + 0.1 * step)}, STATE)
    screen.resize(50, 20)
    cells = rendered(screen, {"magellan": robot_in(made)}, STATE)
    assert (cells.pixels[20, 15:20, :3] == DARK.faint[:3]).all()


@pytest.mark.parametrize("zoom", [0.5, 1.0, 3.0])
def test_a_click_in_the_view_gives_the_place_however_it_is_zoomed(made, zoom) -> None:
    screen = screen_of()
    robots = {"magellan": robot_in(made, x=3.0, y=1.0)}
    state = dataclasses.replace(STATE, zooms={"map": zoom}, robots=robots)
    screen.render(state)
    (hit,) = screen.hits(59, 19, state)
    metres = 0.1 / zoom
    assert (hit.place.x, hit.place.y) == pytest.approx(
        (3.0 + 9.5 * metres, 1.0 + 20.5 * metres), abs=metres / 2 + 1e-6
    )


@for_each("size", [(1, 1), (2, 2), (3, 9), (200, 4), (4, 200)])
@for_each("options", [{}, {"show": "whole", "up": "robot"}, {"option": 0.1}])
def test_any_canvas_will_do(made, draw, size, options) -> None:
    marks = (victim(1, 0.0, 0.0),)
    way = going((0.0, 0.0), (1.0, 1.0))
    draw(NAME, robot_in(made, age=9.0, map_age=99.0, points=marks, status=way), size, **options)


@pytest.mark.parametrize("shape", [(0, 0), (1, 1)])
def test_a_map_of_nothing_will_do(made, draw, shape) -> None:
    grid = dataclasses.replace(room(), cells=np.full(shape, -1, np.int8))
    for navigation in ({}, {"navigation": None}):
        robot = made.robot(map=made.received(grid), **navigation)
        draw(NAME, robot, SIZE, show="whole")
