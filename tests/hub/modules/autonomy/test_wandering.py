"""Wandering goes to free places near by, and not for ever against a wall."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.autonomy import Behaviour
from hub.gcm.navigation import Task
from hub.grids.clearance import clearance
from hub.grids.grid import Grid
from hub.modules.autonomy.wandering import FARTHEST, TRIES
from tests.hub.modules.autonomy.scene import RADIUS, Scene


def wandered(seed: int, count: int) -> Scene:
    scene = Scene(seed)
    scene.x = 0.5
    scene.hears()
    scene.ask(Behaviour.WANDER)
    while len(scene.targets) < count:
        scene.wait(3.0)
        assert scene.task is Task.GOING
        scene.arrive()
    return scene


def test_places_are_free_known_and_near() -> None:
    scene = wandered(1, 20)
    assert scene.grid is not None
    distance = clearance(scene.grid.occupied, 0.1, 1.0)
    before = (0.5, 0.0)
    for place in scene.targets:
        cell = scene.grid.cell(*place)
        assert scene.grid.free[cell]
        assert distance[cell] >= RADIUS
        assert math.dist(before, place) <= FARTHEST
        before = place
    assert len(set(scene.targets)) > 15


def test_the_same_seed_gives_the_same_places() -> None:
    assert wandered(4, 5).targets == wandered(4, 5).targets
    assert wandered(4, 5).targets != wandered(5, 5).targets


def test_it_gives_up_where_every_place_is_blocked() -> None:
    scene = Scene()
    scene.ask(Behaviour.WANDER)
    for _ in range(30):
        scene.wait(3.0)
        if scene.task is Task.GOING:
            scene.end(Task.BLOCKED)
    assert len(scene.targets) == TRIES
    assert scene.why == f"there is no way, tried {TRIES} places"


def test_a_place_that_is_reached_makes_up_for_those_that_were_not() -> None:
    scene = Scene()
    scene.ask(Behaviour.WANDER)
    for _ in range(3):
        for _ in range(TRIES - 1):
            scene.wait(3.0)
            scene.end(Task.BLOCKED)
        scene.wait(3.0)
        scene.arrive()
    assert scene.state.behaviour is Behaviour.WANDER


def test_it_stands_where_there_is_no_room() -> None:
    scene = Scene()
    cells = np.full((10, 10), 100, np.int8)
    scene.grid = Grid(cells=cells, resolution=0.1, origin_x=-0.5, origin_y=-0.5)
    scene.ask(Behaviour.WANDER)
    scene.wait(3.0)
    assert scene.goals == []
    assert scene.why == "there is no room to wander"
