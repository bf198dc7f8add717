"""A hub whose robot maps and drives by itself, and what is to be seen of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from hub.gcm import autonomy, mapping, navigation
from hub.gcm.autonomy import AutonomyCommand, AutonomyState, Behaviour
from hub.grids.clearance import clearance
from hub.grids.grid import Grid, grid_of
from hub.grids.wavefront import spread
from hub.sim.arena import Arena, load_arena
from tests.system.harness import HubProcess, Observer

MODULES = ("driver", "navigation", "mapping", "autonomy")
RADIUS = 0.255
"""Of the robot with its margin [m]."""
RESOLUTION = 0.05


class Tour:
    """A hub in an arena, and an operator who watches."""

    def __init__(self, stack: ExitStack, folder: Path, arena: str = "yellow") -> None:
        self.arena = arena
        self.hub = HubProcess(folder, arena=arena, modules=MODULES)
        stack.enter_context(closing(self.hub))
        seen = (navigation.GROUND_TRUTH, autonomy.AUTONOMY_STATE, navigation.NAVIGATION_STATUS)
        self.observer = stack.enter_context(closing(Observer(self.hub.endpoint, *seen)))
        self.observer.client.define(
            autonomy.AUTONOMY_COMMAND, navigation.VELOCITY_COMMAND, navigation.STOP
        )
        self.observer.client.wait_defined(10.0)

    @property
    def state(self) -> AutonomyState:
        """What autonomy says."""
        state: AutonomyState = self.observer.seen[autonomy.AUTONOMY_STATE.name][-1][1]
        return state

    @property
    def truth(self) -> navigation.GroundTruth:
        """Where the robot really is."""
        return self.observer.truth

    def ask(self, behaviour: Behaviour) -> None:
        """Have the robot do something, and see that it begins."""
        command = AutonomyCommand(behaviour=behaviour)
        self.observer.client.publish(autonomy.AUTONOMY_COMMAND, command)
        self.observer.wait(lambda: self.state.behaviour is behaviour, 10.0, "it does not obey")

    def explore(self, longest: float, say: Callable[[str], object] = str) -> float:
        """Explore until autonomy has done, or the time is over; how long it took [s]."""
        self.ask(Behaviour.EXPLORE)
        began = last = time.monotonic()
        why = ""
        while self.state.behaviour is Behaviour.EXPLORE:
            self.observer.client.listen(0.05)
            now = time.monotonic()
            if self.state.why != why or now - last > 10.0:
                why, last, truth = self.state.why, now, self.truth
                say(
                    f"{now - began:4.0f} s at {truth.x:.1f} {truth.y:.1f}, {truth.contacts}"
                    f" contacts, {self.state.frontier_m:.1f} m left: {why}"
                )
            if now - began > longest:
                break
        return time.monotonic() - began

    def grid(self) -> Grid:
        """The map."""
        message = self.observer.client.query_response(
            mapping.MAP_REQUEST, mapping.MapRequest(), mapping.MAP, timeout=10.0
        )
        return grid_of(message)

    def mapped_share(self) -> float:
        """How much of the ground that the robot can stand on is known in the map, 0 to 1."""
        return mapped_share(load_arena(self.arena), self.grid())


def mapped_share(arena: Arena, grid: Grid) -> float:
    """How much of the ground that the robot can stand on is known in a map, 0 to 1."""
    places = np.argwhere(_standable(arena)) * RESOLUTION + RESOLUTION / 2.0
    # The map's origin is where the robot started, its x axis where it looked then.
    x, y = arena.start.inward(places[:, 1], places[:, 0])
    rows = np.floor((y - grid.origin_y) / grid.resolution).astype(int)
    columns = np.floor((x - grid.origin_x) / grid.resolution).astype(int)
    inside = (rows >= 0) & (rows < grid.height_cells) & (columns >= 0)
    inside &= columns < grid.width_cells
    return float((grid.cells[rows[inside], columns[inside]] >= 0).sum() / len(places))


def _standable(arena: Arena) -> np.ndarray:
    """Cells of a hall of 10 m that the robot can get to from its start, shape (200, 200)."""
    middles = (np.arange(round(10.0 / RESOLUTION)) + 0.5) * RESOLUTION
    wall = [
        [arena.footprints.distances(x, y).min() < RESOLUTION / 2.0 for x in middles]
        for y in middles
    ]
    room = clearance(np.array(wall), RESOLUTION, 1.0) >= RADIUS
    start = int(arena.start.y / RESOLUTION), int(arena.start.x / RESOLUTION)
    return np.isfinite(spread(np.where(room, 1.0, np.inf), start))
