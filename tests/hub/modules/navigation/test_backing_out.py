"""A long body in a dead end backs out of it, to where it has room to turn."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hub.gcm.navigation import GoalCommand, Point
from hub.modules.navigation.dynamic_window import DynamicWindow, body_of
from hub.pose import Pose
from hub.robots.description import Base
from tests.hub.modules.navigation.drives import BODY, Drive
from tests.hub.sim.arenas import arena_of
from tests.support.bodies import robot_of

_WHOLE = robot_of("tracked")
TRACKED = dataclasses.replace(
    _WHOLE,
    base=Base.WHEELS,
    ranges=tuple(each for each in _WHOLE.ranges if each.name == "scan"),
)
"""On a level floor, with its laser only: so its simulation is quick."""
DEAD_END = arena_of(
    """
name = "dead end"
[start]
at = [0.0, 0.0]
"""
    + "".join(
        f"[[box]]\nat = [{x + wide / 2}, {y + deep / 2}]\nsize = [{wide}, {deep}, 0.6]\n"
        for x, y, wide, deep in (
            (-1.0, 0.36, 2.5, 0.1),
            (-1.0, -0.46, 2.5, 0.1),
            (1.5, -0.46, 0.1, 0.92),
            (-6.0, -3.0, 0.1, 6.0),
            (-6.0, -3.0, 5.0, 0.1),
            (-6.0, 2.9, 5.0, 0.1),
            (-1.0, 0.46, 0.1, 2.5),
            (-1.0, -3.0, 0.1, 2.54),
        )
    )
)
"""A corridor of 0.72 m that ends at x = 1.5 m, before a room; the tracked robot turns in 0.83 m."""


def test_it_backs_out_turns_and_goes_on_ahead() -> None:
    drive = Drive(DEAD_END, Pose(x=-1.8, y=0.03), robot=TRACKED)
    drive.push(0.5, 0.0, 3.6)
    deep = drive.truth
    assert deep.x > -0.3
    here = drive.pilot.pose
    start = Pose(x=deep.x, y=deep.y, theta=deep.theta)
    goal = Pose(x=-4.0, y=1.0).seen_from(start)
    ahead, left = here.outward(goal.x, goal.y)
    drive.pilot.go(GoalCommand(points=(Point(x=ahead, y=left),)), 1, drive.now)
    backed = math.inf
    for _ in range(120):
        drive.carry_out(0.5)
        backed = min(backed, drive.truth.linear)
        if not drive.pilot.task.active:
            break
    truth = drive.truth
    assert truth.contacts == 0
    assert math.dist((truth.x, truth.y), (-4.0, 1.0)) < 0.4
    assert -0.25 < backed < -0.05


def test_where_it_has_not_been_it_does_not_back_without_sensors_that_look_back() -> None:
    """It was switched on in the dead end, and never saw what is behind it."""
    drive = Drive(DEAD_END, Pose(x=1.0, y=0.05, theta=0.05), robot=TRACKED)
    drive.push(0.4, 0.0, 0.5)
    drive.pilot.go(GoalCommand(points=(Point(x=-4.0, y=1.0),)), 1, drive.now)
    drive.carry_out(5.0)
    assert drive.truth.x >= 0.99
    assert drive.truth.contacts == 0


def test_a_disc_never_backs_to_a_goal() -> None:
    window = DynamicWindow(BODY)
    around = np.linspace(0.0, math.tau, 200)
    ring = 0.26 * np.cos(around), 0.26 * np.sin(around)
    assert window.to_goal((0.0, 0.0), (-1.0, 0.1), 0.5, ring, way_back=(-1.0, 0.0))[0] == 0.0


def test_it_turns_the_other_way_where_only_that_has_room() -> None:
    window = DynamicWindow(body_of(TRACKED))
    post = np.array([0.30]), np.array([0.34])
    linear, angular = window.to_goal((0.0, 0.0), (-1.0, 0.3), 0.5, post)
    assert linear == 0.0
    assert angular < 0.0
