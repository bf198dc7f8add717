"""Victims, coverage, maps and shortest paths."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rune_study.errors import DataError
from rune_study.metrics.coverage import TrueGrid, coverage, reachable, seen_cells, standing
from rune_study.metrics.map_quality import map_quality, middles, surface
from rune_study.metrics.shortest_path import in_sight, shortest_path
from rune_study.metrics.victims import Mark, first_victim, victims_found

PLACES = [(1, 1), (5, 5), (8, 2), (3, 9)]
MARKS = [
    Mark(time=50, x=1.2, y=1),
    Mark(time=60, x=1, y=1.3),
    Mark(time=70, x=5.6, y=5.8),
    Mark(time=80, x=8, y=3.1),
]


def grid_of(*rows: str, resolution: float = 1.0) -> TrueGrid:
    """A grid whose last row is at the smallest y; # is blocked."""
    cells = np.array([[each == "#" for each in row] for row in reversed(rows)])
    return TrueGrid(blocked=cells, resolution=resolution)


def test_victims_by_hand() -> None:
    found = victims_found(MARKS, PLACES)
    assert (found.found, found.false, found.victims, found.marks) == (2, 2, 4, 4)
    assert (found.fraction, found.precision) == (0.5, 0.5)
    assert found.error == pytest.approx(0.6)


def test_no_marks_and_no_victims() -> None:
    none = victims_found([], PLACES)
    assert (none.fraction, math.isnan(none.precision), math.isnan(none.error)) == (0, True, True)
    empty = victims_found(MARKS, [])
    assert (empty.false, empty.precision, math.isnan(empty.fraction)) == (4, 0, True)
    removed = [Mark(time=each.time, x=each.x, y=each.y, removed=True) for each in MARKS]
    assert victims_found(removed, PLACES).marks == 0
    with pytest.raises(DataError, match="places of victims"):
        victims_found(MARKS, [(1, 2, 3)])


def test_first_victim() -> None:
    assert first_victim(MARKS, PLACES, 600).value == 50
    assert first_victim(MARKS[::-1], PLACES, 600).value == 50
    assert first_victim(MARKS[1:], PLACES, 600).value == 60
    late = first_victim(MARKS[2:3], PLACES, 600)
    assert (late.value, late.censored) == (70, False)
    none = first_victim(MARKS[3:], PLACES, 600)
    assert (none.value, none.censored) == (600, True)
    gone = [Mark(time=5, x=1, y=1, removed=True), *MARKS]
    assert first_victim(gone, PLACES, 600).value == 50
    assert first_victim(MARKS, PLACES, 40).censored
    assert not first_victim(MARKS, [], 600).known


def test_reachable_ground() -> None:
    grid = grid_of(
        "..#..",
        "..#..",
        "..#.#",
        ".....",
    )
    assert reachable(grid, (0.5, 0.5), 0.0).sum() == 16 - 0
    # A robot of 1 cell radius does not fit beside walls, nor through the door.
    narrow = reachable(grid, (0.5, 0.5), 1.1)
    assert narrow.tolist() == [
        [True, True, False, False, False],
        [True, False, False, False, False],
        [True, False, False, False, False],
        [True, False, False, False, False],
    ]
    assert not reachable(grid, (2.5, 3.5), 0.0).any()
    with pytest.raises(DataError, match="outside"):
        reachable(grid, (-0.1, 0.5), 0.0)


def test_corners_of_cells_are_no_door() -> None:
    grid = grid_of(".#", "#.")
    assert reachable(grid, (0.5, 1.5), 0.0).sum() == 1


def test_a_camera_sees_its_wedge_up_to_walls() -> None:
    grid = grid_of(*["." * 21] * 21, resolution=0.5)
    seen = seen_cells(grid, [5.25], [5.25], [0.0], width=math.pi / 2)
    rows, columns = np.nonzero(seen)
    x, y = (columns + 0.5) * 0.5 - 5.25, (rows + 0.5) * 0.5 - 5.25
    away, angle = np.hypot(x, y), np.abs(np.arctan2(y, x))
    assert (away <= 3.0 + 0.36).all()
    inner = np.array([(x, y) for x, y in itertools.product(np.arange(0.5, 2.9, 0.5), [0.0])])
    assert all(seen[10, 10 + round(2 * each)] for each, _ in inner)
    assert (angle[away > 1.0] <= math.pi / 4 + 0.5).all()
    behind = seen_cells(grid, [5.25], [5.25], [math.pi], width=math.pi / 2)
    assert (behind == seen[:, ::-1]).all()


def test_walls_hide_what_is_behind_them() -> None:
    grid = grid_of("......", "......", "..#...", "......", "......")
    seen = seen_cells(grid, [0.5], [2.5], [0.0], width=0.1, farthest=9.0)
    assert seen[2].tolist() == [True, True, False, False, False, False]
    assert not seen_cells(grid, [math.nan], [2.5], [0.0], width=0.1).any()


def test_coverage() -> None:
    assert coverage([[1, 1], [0, 1]], [[1, 1], [1, 0]]) == pytest.approx(2 / 3)
    assert math.isnan(coverage([[1]], [[0]]))
    with pytest.raises(DataError, match="one shape"):
        coverage([[1]], [[0, 1]])


def test_maps_by_hand() -> None:
    truth, marked = np.zeros((10, 10), bool), np.zeros((10, 10), bool)
    truth[5, 2:8] = True
    marked[5, 2:5] = marked[6, 5] = marked[8, 8] = marked[0, 0] = True
    points = [middles(each, 0.05, 0.0, 0.0) for each in (marked, truth)]
    near = map_quality(points[0], points[1], 0.05)
    assert (near.precision, near.recall, near.f1) == pytest.approx((4 / 6, 4 / 6, 2 / 3))
    far = map_quality(points[0], points[1], 0.10)
    assert (far.precision, far.recall, far.f1) == pytest.approx((4 / 6, 5 / 6, 20 / 27))
    none = map_quality([], points[1])
    assert (math.isnan(none.precision), none.recall, none.f1) == (True, 0, 0)
    wrong = map_quality([(9, 9)], points[1])
    assert (wrong.precision, wrong.recall, wrong.f1) == (0, 0, 0)
    with pytest.raises(DataError, match="no surface"):
        map_quality(points[0], [])


def test_surfaces_face_the_space() -> None:
    grid = grid_of("#####", "#..##", "#####", "#.###", "#####")
    faces = surface(grid, reachable(grid, (1.5, 3.5), 0.0))
    assert faces.sum() == 6
    assert not faces[0].any()


@given(arrays.arrays(bool, (6, 7)), arrays.arrays(bool, (6, 7)), st.sampled_from([0.05, 0.1, 0.12]))
def test_maps_are_those_of_all_pairs(first, second, tolerance: float) -> None:
    one, two = middles(first, 0.05, -1.0, 2.0), middles(second, 0.05, -1.0, 2.0)
    if not len(one) or not len(two):
        return
    away = np.hypot(*(one[:, None] - two[None]).transpose(2, 0, 1)) <= tolerance + 1e-9
    found = map_quality(one, two, tolerance)
    assert (found.precision, found.recall) == (away.any(1).mean(), away.any(0).mean())
    turned = map_quality(two, one, tolerance)
    assert (turned.recall, turned.f1) == (found.precision, pytest.approx(found.f1))


def test_shortest_paths_by_hand() -> None:
    free = grid_of(*["." * 30] * 20, resolution=0.1)
    assert shortest_path(free, (0.2, 0.3), (2.7, 1.7)) == pytest.approx(math.hypot(2.5, 1.4))
    wall = grid_of(*["..........#........."] * 8, *["." * 20] * 2, resolution=0.1)
    # The wall is from x 1.0 to 1.1, and its end at y 0.2: two bends.
    length = math.hypot(0.5, 0.3) + 0.1 + math.hypot(0.4, 0.6)
    assert shortest_path(wall, (0.5, 0.5), (1.5, 0.8)) == pytest.approx(length)
    door = grid_of("..#..", "..#..", "..#..")
    assert math.isnan(shortest_path(door, (0.5, 0.5), (4.5, 0.5)))
    assert math.isnan(shortest_path(door, (0.5, 0.5), (2.5, 0.5)))
    assert shortest_path(door, (0.5, 0.5), (0.5, 0.5)) == 0
    with pytest.raises(DataError, match="goal"):
        shortest_path(free, (0.2, 0.3), (3.1, 1.0))


def test_a_robot_keeps_its_radius() -> None:
    wall = grid_of(*["." * 10 + "#" + "." * 9] * 14, *["." * 20] * 6, resolution=0.1)
    thin = shortest_path(wall, (0.5, 1.5), (1.6, 1.5))
    wide = shortest_path(wall, (0.5, 1.5), (1.6, 1.5), 0.3)
    assert thin < wide < thin + math.pi * 0.3 + 0.1


@settings(max_examples=60)
@given(arrays.arrays(bool, (7, 8), elements=st.sampled_from([False, False, True])))
def test_shortest_paths_are_those_over_all_corners(blocked) -> None:
    blocked[0, 0] = blocked[-1, -1] = False
    grid = TrueGrid(blocked=blocked, resolution=1.0)
    found = shortest_path(grid, (0.3, 0.6), (7.5, 6.5))
    closed = np.pad(blocked, 1, constant_values=True)
    corners = list(itertools.product(np.arange(1.0, 9.0), np.arange(1.0, 10.0)))
    nodes = np.array([(1.6, 1.3), (7.5, 8.5), *corners])
    best = np.full(len(nodes), math.inf)
    best[0], left = 0.0, set(range(len(nodes)))
    while left:
        here = min(left, key=lambda each: best[each])
        left.remove(here)
        if not math.isfinite(best[here]):
            break
        for other in left:
            away = best[here] + math.dist(nodes[here], nodes[other])
            if away < best[other] and in_sight(closed, nodes[here], nodes[other]):
                best[other] = away
    wanted = best[1] if math.isfinite(best[1]) else math.nan
    assert found == pytest.approx(wanted, nan_ok=True)


def test_standing() -> None:
    grid = grid_of("...", "...", "#..")
    assert standing(grid, 0.0).sum() == 8
    assert standing(grid, 1.1).tolist() == [[0, 0, 1], [0, 1, 1], [1, 1, 1]]
