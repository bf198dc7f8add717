"""Bodies of any shape under a careless operator in random worlds, with accelerations and delays.

Every obstacle is seen. The wheels follow after a delay, with limited accelerations.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import numpy.typing as npt
import pytest

from hub.gcm.outline import hull
from hub.modules.navigation.dynamic_window import BodyLimits, DynamicWindow
from hub.modules.navigation.sweeps import Sweep
from hub.pose import Pose
from hub.sim.kinematics import ANGULAR, LINEAR, approach, moved
from tests.support.repetitions import repetitions

Floats = npt.NDArray[np.float64]
STEP = 0.01
STEPS_PER_CHOICE = 5
DELAY_STEPS = 4
SPACING = 0.02


def random_body(random: np.random.Generator) -> BodyLimits:
    """A convex body of 10 to 60 cm; its origin need not be its middle."""
    while True:
        corners = hull(random.uniform((-0.5, -0.25), (0.5, 0.25), (random.integers(3, 9), 2)))
        if len(corners) >= 3:
            outline = Sweep(corners)
            return BodyLimits(
                radius=outline.radius,
                margin=0.05,
                linear_limit=0.5,
                sway_limit=0.4,
                angular_limit=1.0,
                linear_braking=LINEAR.braking,
                angular_braking=ANGULAR.braking,
                outline=outline,
            )


def random_world(random: np.random.Generator, body: BodyLimits) -> tuple[Floats, Floats]:
    """Points on round and straight obstacles that leave the start free [m]."""
    parts = []
    for _ in range(25):
        x, y, angle = random.uniform(-3.0, 3.0, 3)
        if random.random() < 0.5:
            along = np.arange(0.0, random.uniform(0.2, 1.5), SPACING)
            parts.append((x + along * math.cos(angle), y + along * math.sin(angle)))
        else:
            around = np.arange(0.0, math.tau, SPACING / 0.08)
            parts.append((x + 0.08 * np.cos(around), y + 0.08 * np.sin(around)))
    x, y = (np.concatenate(part) for part in zip(*parts, strict=True))
    assert body.outline is not None
    free = body.outline.distances(x, y) > 0.08
    return x[free], y[free]


@pytest.mark.parametrize("first", range(0, repetitions(12, 300), 4))
def test_no_body_touches_anything(first: int) -> None:
    ways = [driven(seed) for seed in range(first, first + 4)]
    assert sum(ways) > 1.0


def driven(seed: int) -> float:
    """How far a body drives without a touch [m]."""
    random = np.random.default_rng(seed)
    body = random_body(random)
    outline = body.outline
    assert outline is not None
    world = random_world(random, body)
    window, pose = DynamicWindow(body), Pose()
    surge = sway = turn = 0.0
    orders = deque([(0.0, 0.0, 0.0)] * DELAY_STEPS)
    order = (0.0, 0.0, 0.0)
    way = 0.0
    for step in range(1200):
        if step % 200 == 0:
            stick = random.uniform((-0.5, -0.4, -1.0), (0.5, 0.4, 1.0)) * random.integers(0, 2, 3)
        if step % STEPS_PER_CHOICE == 0:
            x, y = pose.inward(*world)
            near = np.hypot(x, y) < body.radius + 0.6
            axis = math.atan2(stick[1], stick[0])
            along, aside = Pose(theta=axis).inward(surge, sway)
            speed, rate = window.towards(
                (along, turn),
                (math.hypot(stick[0], stick[1]), float(stick[2])),
                (x[near], y[near]),
                axis=axis,
                aside=aside,
            )
            order = (speed * math.cos(axis), speed * math.sin(axis), rate)
        orders.append(order)
        wanted = orders.popleft()
        surge = approach(surge, wanted[0], LINEAR, STEP)
        sway = approach(sway, wanted[1], LINEAR, STEP)
        turn = approach(turn, wanted[2], ANGULAR, STEP)
        pose = moved(pose, surge * STEP, turn * STEP, sway * STEP)
        way += math.hypot(surge, sway) * STEP
        assert outline.distances(*pose.inward(*world)).min() > 0.0, f"seed {seed}, step {step}"
    return way
