"""The occupancy grid: what scans do to cells, and the pictures of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.beams import Beams, beams_of
from hub.gcm.body import BodyFrame, RangeGroup, RangeKind, RobotBody
from hub.gcm.map_coding import decode, encode
from hub.gcm.occupancy_map import OccupancyMap
from hub.modules.mapping.evidence import FARTHEST, LEAST, MOST
from hub.modules.mapping.grid import BORDER, LOADED, OccupancyGrid
from hub.pose import Pose
from tests.support.cases import for_each

HERE = Pose()


def one_beam(kind: RangeKind, opening_deg: float = 0.0, farthest: float = 8.0) -> Beams:
    """A single sensor that looks ahead from the robot's origin."""
    opening = math.radians(opening_deg)
    group = RangeGroup(name="one", kind=kind, opening=opening, nearest=0.1, farthest=farthest)
    return beams_of(RobotBody(name="a", kind="b", radius=0.2, ranges=(group,)))


SONAR = one_beam(RangeKind.SONAR, 27.0, 5.1)
INFRARED = one_beam(RangeKind.INFRARED, farthest=1.0)
LASER = one_beam(RangeKind.LASER)


def after(beams: Beams, *ranges: float, scans: int = 1) -> OccupancyGrid:
    """A grid after scans from its middle."""
    grid = OccupancyGrid(0.05, 12.0, beams)
    for _ in range(scans):
        assert grid.add(HERE, np.array(ranges, np.float32))
    return grid


def at(grid: OccupancyGrid, x: float, y: float) -> float:
    row, column = (math.floor((value - grid.low) / grid.resolution) for value in (y, x))
    return float(grid.log_odds[row, column])


def known(grid: OccupancyGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places x and y [m] and log-odds of the known cells, each of shape (n,)."""
    rows, columns = np.nonzero(grid.log_odds)
    x, y = (grid.low + (place + 0.5) * grid.resolution for place in (columns, rows))
    return x, y, grid.log_odds[rows, columns]


@for_each("beams", [SONAR, INFRARED, LASER])
def test_an_echo_marks_its_place_and_frees_the_way_to_it(beams: Beams) -> None:
    grid = after(beams, 0.9)
    assert at(grid, 0.9, 0.0) > 0.1
    assert at(grid, 0.5, 0.0) < -0.1
    assert at(grid, 1.1, 0.0) == 0.0
    assert at(grid, -0.5, 0.0) == 0.0


KINDS = st.sampled_from(list(RangeKind))
ANGLES = st.floats(-math.pi, math.pi)
PLACES = st.floats(-0.5, 0.5)


@st.composite
def bodies(draw: st.DrawFn) -> RobotBody:
    """A body with a few single sensors, a ring and a scan, each anywhere on it."""
    names = ("front", "back", "ring", "scan")
    groups, frames = [], []
    for name in names[: draw(st.integers(1, 4))]:
        beams = {"ring": 7, "scan": 40}.get(name, 1)
        groups.append(
            RangeGroup(
                name=name,
                kind=draw(KINDS),
                beams=beams,
                first=draw(ANGLES),
                step=math.tau / beams * draw(st.sampled_from([-1.0, 0.5, 1.0])),
                opening=math.radians(draw(st.floats(0.0, 40.0))),
                nearest=0.1,
                farthest=draw(st.floats(0.5, 12.0)),
            )
        )
        frame = BodyFrame(name=name, x=draw(PLACES), y=draw(PLACES), yaw=draw(ANGLES))
        frames.append(frame)
    return RobotBody(name="a", kind="b", radius=0.7, frames=tuple(frames), ranges=tuple(groups))


@given(data=st.data(), body=bodies(), x=PLACES, y=PLACES, theta=ANGLES)
def test_one_beam_of_any_body_is_free_to_its_echo_and_nothing_beside_it(
    data: st.DataObject, body: RobotBody, x: float, y: float, theta: float
) -> None:
    beams = beams_of(body)
    beam = data.draw(st.integers(0, len(beams.kind) - 1))
    away = data.draw(st.floats(0.2, 2.5).filter(lambda value: value < beams.farthest[beam]))
    check_beam(beams, beam, away, Pose(x=x, y=y, theta=theta))


def test_an_echo_at_the_edge_of_a_cell_marks_one_of_the_cells_there() -> None:
    check_beam(one_beam(RangeKind.SONAR, farthest=1.0), 0, 0.5, Pose(theta=6.103515625e-05))


def check_beam(beams: Beams, beam: int, away: float, pose: Pose) -> None:
    """Check what an echo of one beam at a distance [m] does to an empty grid."""
    ranges = np.full(len(beams.kind), np.nan, np.float32)
    ranges[beam] = away
    grid = OccupancyGrid(0.05, 8.0, beams)
    assert grid.add(pose, ranges)
    origin = pose.outward(float(beams.x[beam]), float(beams.y[beam]))
    bearing = pose.theta + beams.bearing[beam]
    cells_x, cells_y, values = known(grid)
    distance = np.hypot(cells_x - origin[0], cells_y - origin[1])
    direction = np.arctan2(cells_y - origin[1], cells_x - origin[0])
    aside = np.abs(np.remainder(direction - bearing + math.pi, math.tau) - math.pi)
    # A cell is 5 cm wide: its middle is up to 3.6 cm from the point of a ray in it.
    assert (np.abs(distance[values > 0.0] - away) <= 0.036).all()
    assert (distance <= away + 0.036).all()
    outside = np.clip(aside - beams.opening[beam] / 2.0, 0.0, math.pi / 2.0)
    assert (np.sin(outside) * distance <= 0.036).all()
    towards = Pose(x=origin[0], y=origin[1], theta=bearing)
    if beams.farthest[beam] <= FARTHEST and beams.opening[beam] * away < 1.0:
        # At an edge it belongs to either cell, by rounding.
        echo_x, echo_y = towards.outward(away, 0.0)
        around = np.maximum(np.abs(cells_x - echo_x), np.abs(cells_y - echo_y)) < 0.0251
        assert (values[around] > 0.0).any()
    for share in (0.1, 0.5, 0.8):
        probe_x, probe_y = towards.outward(away * share, 0.0)
        near = np.hypot(cells_x - probe_x, cells_y - probe_y) < 0.05
        assert (values[near] < 0.0).any() or (1.0 - share) * away < 0.1


def test_seven_ranges_and_a_laser_draw_the_walls_of_a_room() -> None:
    """Each sensor from its own place: all walls are at 2 m from the robot's origin."""
    single = [
        (f"r{n}", BodyFrame(name=f"r{n}", x=0.3 * math.cos(n), y=0.3 * math.sin(n), yaw=n))
        for n in range(7)
    ]
    body = RobotBody(
        name="a",
        kind="b",
        radius=0.4,
        frames=(*(frame for _, frame in single), BodyFrame(name="laser", x=0.2, roll=math.pi)),
        ranges=(
            *(
                RangeGroup(name=name, kind=RangeKind.SONAR, opening=0.1, farthest=4.0)
                for name, _ in single
            ),
            RangeGroup(
                name="laser", kind=RangeKind.LASER, beams=360, step=math.tau / 360, farthest=8.0
            ),
        ),
    )
    beams = beams_of(body)
    along = np.stack([np.cos(beams.bearing), np.sin(beams.bearing)])
    to_wall = (2.0 - np.sign(along) * (beams.x, beams.y)) / np.maximum(np.abs(along), 1e-9)
    grid = after(beams, *to_wall.min(axis=0))
    x, y, values = known(grid)
    walls = np.maximum(np.abs(x), np.abs(y))
    assert np.abs(walls[values > 0.0] - 2.0).max() < 0.1
    assert (values > 0.0).sum() > 250
    assert at(grid, 0.0, 1.5) < 0.0
    assert at(grid, -1.5, -1.5) < 0.0


@for_each("value", [-math.inf, -1.0, 0.0, 0.05, 8.1, math.nan])
def test_ranges_that_the_sensor_cannot_measure_give_no_evidence(value: float) -> None:
    assert not after(LASER, value).log_odds.any()


def test_evidence_of_a_sonar_falls_with_angle_and_range() -> None:
    near, middle, far = (after(SONAR, away).log_odds.max() for away in (0.5, 1.5, 2.5))
    assert near > middle > far > 0.0
    slant = math.radians(8.0)
    grid = after(SONAR, 2.0)
    assert at(grid, 2.0, 0.0) > at(grid, 2.0 * math.cos(slant), 2.0 * math.sin(slant)) > 0.0


def test_an_echo_is_put_where_the_map_already_has_something() -> None:
    post = (2.0 * math.cos(0.12), 2.0 * math.sin(0.12))
    grid = OccupancyGrid(0.05, 10.0, SONAR)
    picture = OccupancyMap(
        cells=np.array([[100]], np.int8), resolution=0.05, origin_x=post[0] - 0.025,
        origin_y=post[1] - 0.025,
    )  # fmt: skip
    grid.paint(picture, LOADED)
    before = at(grid, *post)
    grid.add(HERE, np.array([2.0], np.float32))
    unknown_beside = at(grid, post[0], -post[1])
    assert at(grid, *post) - before > 2.0 * unknown_beside


def test_a_known_wall_is_not_erased_by_an_echo_from_behind_it() -> None:
    """Smooth walls send a sonar's beam away: the echo of something farther comes beside them."""
    wall = OccupancyMap(
        cells=np.full((20, 1), 100, np.int8), resolution=0.05, origin_x=1.0, origin_y=-0.5
    )
    lost = []
    for beams in (SONAR, LASER):
        grid = OccupancyGrid(0.05, 10.0, beams)
        grid.paint(wall, LOADED)
        grid.add(HERE, np.array([2.5], np.float32))
        lost.append((LOADED - at(grid, 1.01, 0.01)) / -at(grid, 0.9, 0.01))
    sonar, laser = lost
    assert 0.0 < sonar < 0.5
    assert laser == pytest.approx(1.0)


def test_what_is_gone_is_forgotten_in_the_end() -> None:
    grid = after(SONAR, 1.025, scans=50)
    assert at(grid, 1.0, 0.0) == pytest.approx(MOST)
    for _ in range(150):
        grid.add(HERE, np.array([2.5], np.float32))
    assert at(grid, 1.0, 0.0) == pytest.approx(LEAST)


@for_each(
    ("beams", "free"), [(SONAR, 1.0), (LASER, 8.0 / 3.0), (INFRARED, 0.0)]
)  # fmt: skip
def test_no_echo_frees_only_what_is_near_and_that_of_infrared_nothing(
    beams: Beams, free: float
) -> None:
    grid = after(beams, math.inf)
    x, _, _ = known(grid)
    assert x.max(initial=0.0) == pytest.approx(free, abs=0.06)
    assert grid.log_odds.max() == 0.0


def test_echoes_from_beyond_the_mapped_range_free_what_is_before_it() -> None:
    grid = after(SONAR, 4.5)
    assert at(grid, 2.5, 0.0) < 0.0
    assert grid.log_odds.max() == 0.0


@given(
    values=st.lists(st.floats(width=32), min_size=16, max_size=16),
    x=st.floats(), y=st.floats(), theta=st.floats(), kind=KINDS,
)  # fmt: skip
@example(values=[1.0] * 16, x=1.7e308, y=-1.7e308, theta=1.7e308, kind=RangeKind.SONAR)
@example(values=[1.0] * 16, x=math.nextafter(2.0, 0.0), y=0.0, theta=0.0, kind=RangeKind.LASER)
def test_nothing_that_is_reported_breaks_the_map(
    values: list[float], x: float, y: float, theta: float, kind: RangeKind
) -> None:
    group = RangeGroup(name="g", kind=kind, beams=16, step=0.4, opening=0.3, farthest=8.0)
    beams = beams_of(RobotBody(name="a", kind="b", radius=0.2, ranges=(group,)))
    grid = OccupancyGrid(0.1, 4.0, beams)
    scan = np.array(values, np.float32)
    used = grid.add(Pose(x=x, y=y, theta=theta), scan)
    assert grid.add(Pose(x=0.3, y=0.2), scan[::-1])
    assert grid.outside == (not used)
    assert np.isfinite(grid.log_odds).all()
    assert grid.log_odds.min() >= LEAST
    assert grid.log_odds.max() <= MOST


def test_scans_from_outside_the_square_are_counted_and_left_out() -> None:
    grid = OccupancyGrid(0.05, 4.0, SONAR)
    assert not grid.add(Pose(x=2.01), np.ones(1, np.float32))
    assert grid.outside == 1
    assert not grid.log_odds.any()
    assert grid.add(Pose(x=1.99, y=-1.99, theta=math.pi), np.ones(1, np.float32))
    assert grid.log_odds.any()


def test_the_whole_map_is_what_is_known_and_a_border() -> None:
    grid = OccupancyGrid(0.05, 40.0, SONAR)
    empty = grid.whole()
    assert (empty.cells == -1).all()
    assert empty.cells.shape == (21, 21)
    grid.add(Pose(x=3.0, y=-2.0), np.array([2.0], np.float32))
    whole = grid.whole()
    known = whole.cells >= 0
    border = round(BORDER / 0.05)
    assert not known[:border].any()
    assert known[border].any()
    assert known[:, border].any()
    assert not known[:, -border:].any()
    assert known[:, -border - 1].any()
    assert whole.origin_x == pytest.approx(3.0 - BORDER, abs=0.2)
    assert np.array_equal(decode(encode(whole.cells), *whole.cells.shape), whole.cells)


def test_the_picture_shows_probabilities_in_percent() -> None:
    grid = OccupancyGrid(0.05, 2.0)
    grid.log_odds[20, 20:24] = (MOST, LEAST, 0.0, math.log(0.65 / 0.35))
    picture = grid.window(0.1, 0.025, 0.2, 0.05)
    assert picture is not None
    assert picture.cells.tolist() == [[95, 10, -1, 65]]


@given(
    x=st.floats(-6, 6), y=st.floats(-6, 6), width=st.floats(0, 9), height=st.floats(0, 9)
)  # fmt: skip
def test_a_window_is_clipped_to_the_square_and_covers_what_was_asked_for(
    x: float, y: float, width: float, height: float
) -> None:
    grid = OccupancyGrid(0.1, 8.0)
    picture = grid.window(x, y, width, height)
    left, right = max(x - width / 2, -4.0), min(x + width / 2, 4.0)
    bottom, top = max(y - height / 2, -4.0), min(y + height / 2, 4.0)
    if left >= right or bottom >= top:
        assert picture is None
        return
    assert picture is not None
    rows, columns = picture.cells.shape
    assert left - 0.1001 <= picture.origin_x <= left + 1e-9
    assert bottom - 0.1001 <= picture.origin_y <= bottom + 1e-9
    assert right - 1e-9 <= picture.origin_x + columns * 0.1 <= right + 0.1001
    assert top - 1e-9 <= picture.origin_y + rows * 0.1 <= top + 0.1001


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_window_that_is_nowhere_shows_nothing(bad: float) -> None:
    grid = OccupancyGrid(0.1, 8.0)
    assert grid.window(bad, 0.0, 1.0, 1.0) is None
    assert grid.window(0.0, bad, 1.0, 1.0) is None
    assert grid.window(0.0, 0.0, 1.0, math.nan) is None


@given(
    cells=st.lists(st.sampled_from([-1, 0, 100]), min_size=12, max_size=12),
    left=st.integers(-30, 30), bottom=st.integers(-30, 30),
)  # fmt: skip
def test_painting_a_picture_and_taking_it_gives_the_same(
    cells: list[int], left: int, bottom: int
) -> None:
    picture = OccupancyMap(
        cells=np.array(cells, np.int8).reshape(3, 4),
        resolution=0.1,
        origin_x=left * 0.1,
        origin_y=bottom * 0.1,
    )
    grid = OccupancyGrid(0.1, 10.0)
    grid.log_odds[:] = 1.0
    assert grid.paint(picture, LOADED) == 0
    taken = grid.window((left + 2) * 0.1, (bottom + 1.5) * 0.1, 0.399, 0.299)
    assert taken is not None
    levels = np.where(taken.cells < 0, -1, np.where(taken.cells < 50, 0, 100))
    assert np.array_equal(levels, picture.cells)
    assert np.count_nonzero(grid.log_odds) == np.count_nonzero(picture.cells >= 0)


def test_known_cells_of_a_picture_outside_the_square_are_counted() -> None:
    picture = OccupancyMap(
        cells=np.array([[0, -1, 100, 100]], np.int8), resolution=1.0, origin_x=0.0, origin_y=0.0
    )
    grid = OccupancyGrid(0.5, 6.0)
    assert grid.paint(picture, LOADED) == 1


def test_a_cell_that_gets_several_is_occupied_if_one_of_them_is() -> None:
    picture = OccupancyMap(
        cells=np.array([[100, 0], [0, 0]], np.int8), resolution=0.05, origin_x=0.0, origin_y=0.0
    )
    grid = OccupancyGrid(0.1, 2.0)
    grid.paint(picture, LOADED)
    assert at(grid, 0.05, 0.05) == LOADED
