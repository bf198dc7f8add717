"""The edges that a robot knows; pure."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from hub.gcm.edges import EDGES
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Floats

KNOWN_S: Final = 3.0
"""Older edges are not shown [s]: navigation repeats what it knows twice a second."""


def edges_of(robot: RobotState, now: float) -> Floats:
    """The known edges in `map` [m], shape (n, 2)."""
    received = robot.newest(EDGES)
    if received is None or received.age(now) > KNOWN_S:
        return np.empty((0, 2))
    cells = [(cell.x, cell.y) for cell in received.value.cells]
    places: Floats = np.array(cells, np.float64).reshape(-1, 2)
    known: Floats = places[np.isfinite(places).all(axis=1)]
    return known


def edges_around(robot: RobotState, now: float) -> Floats:
    """The known edges in the robot's own frame [m], shape (n, 2)."""
    if robot.navigation is None:
        return np.empty((0, 2))
    state = robot.navigation.value
    if not all(map(math.isfinite, (state.x, state.y, state.theta))):
        return np.empty((0, 2))
    return Pose(x=state.x, y=state.y, theta=state.theta).from_map(edges_of(robot, now))
