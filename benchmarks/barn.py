"""The BARN worlds as a kinematic simulation, and drives through them.

No figures of its own: `benchmarks/navigation.py` reports them.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.grids.grid import Grid
from hub.grids.planner import plan
from hub.modules.navigation.dynamic_window import BodyLimits, DynamicWindow
from hub.modules.navigation.route import Route
from hub.pose import Pose
from hub.sim.kinematics import ANGULAR, LINEAR, approach, moved

Floats = npt.NDArray[np.float64]
Velocity = tuple[float, float]
Chooser = Callable[[Pose, Velocity, Floats], Velocity]
"""From the pose, the velocity, and the cylinders in sight (n, 2) [m], to the next velocity."""

DATA = Path(__file__).parent / "data" / "barn25.json"
BODY = BodyLimits(
    radius=0.25,
    margin=0.03,
    linear_limit=0.5,
    angular_limit=1.57,
    linear_braking=2.0,
    angular_braking=4.0,
)
PERIOD = 0.05
STEPS = 5
SIGHT = 1.5
ARRIVED = 1.0
TIMEOUT = 100.0
RESOLUTION = 0.05
_RIM = np.linspace(-1.2, 1.2, 5)


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """One world: cylinders (n, 2) of one radius [m], start, goal, shortest way [m]."""

    name: str
    cylinders: Floats
    radius: float
    start: Pose
    goal: tuple[float, float]
    shortest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a drive ended: "reached", "collided" or "timeout"; and after how long [s]."""

    how: str
    seconds: float
    cycles_ms: list[float]


def load() -> tuple[list[World], dict[str, Any]]:
    """All worlds, and the recorded runs of move_base."""
    data = json.loads(DATA.read_text())
    x, y, theta = data["start"]
    worlds = [
        World(
            name=name,
            cylinders=np.array(world["cyl"]),
            radius=data["radius"],
            start=Pose(x=x, y=y, theta=theta),
            goal=tuple(data["goal"]),
            shortest=world["path_len"],
        )
        for name, world in data["worlds"].items()
    ]
    return worlds, data["move_base_dwa"]


def drive(world: World, choose: Chooser, body_radius: float = BODY.radius) -> Outcome:
    """Drive until the end; wheels follow as those of the simulated Magellan do."""
    pose = world.start
    linear = angular = now = 0.0
    cycles: list[float] = []
    while now < TIMEOUT:
        if math.dist((pose.x, pose.y), world.goal) < ARRIVED:
            return Outcome(how="reached", seconds=now, cycles_ms=cycles)
        away = np.hypot(*(world.cylinders - (pose.x, pose.y)).T)
        seen = world.cylinders[away < SIGHT]
        begun = time.perf_counter()
        wanted = choose(pose, (linear, angular), seen)
        cycles.append((time.perf_counter() - begun) * 1e3)
        for _ in range(STEPS):
            step = PERIOD / STEPS
            linear = approach(linear, wanted[0], LINEAR, step)
            angular = approach(angular, wanted[1], ANGULAR, step)
            pose = moved(pose, linear * step, angular * step)
            near = np.hypot(*(world.cylinders - (pose.x, pose.y)).T).min()
            if near < body_radius + world.radius:
                return Outcome(how="collided", seconds=now, cycles_ms=cycles)
        now += PERIOD
    return Outcome(how="timeout", seconds=now, cycles_ms=cycles)


def ours(world: World, *, with_plan: bool) -> Chooser:
    """What navigation does: the dynamic window, on a planned way if it has a map."""
    window = DynamicWindow(BODY)
    start = (world.start.x, world.start.y)
    way = plan(grid_of(world), start, world.goal, radius=BODY.radius + BODY.margin)
    route = Route(way) if with_plan and way is not None else None

    def choose(pose: Pose, velocity: Velocity, seen: Floats) -> Velocity:
        carrot = world.goal if route is None else route.ahead(pose)[0]
        return window.to_goal(velocity, pose.inward(*carrot), math.inf, rims(pose, seen, world))

    return choose


def rims(pose: Pose, seen: Floats, world: World) -> tuple[Floats, Floats]:
    """Points on the sides of the cylinders that look to the robot, in its frame [m]."""
    bearing = np.arctan2(pose.y - seen[:, 1], pose.x - seen[:, 0])[:, None] + _RIM
    x = (seen[:, :1] + world.radius * np.cos(bearing)).reshape(-1)
    y = (seen[:, 1:] + world.radius * np.sin(bearing)).reshape(-1)
    return pose.inward(x, y)


def grid_of(world: World) -> Grid:
    """The world as a map that is known."""
    low = world.cylinders.min(axis=0) - 0.5
    low[1] = min(low[1], 1.0)
    high = world.cylinders.max(axis=0) + 0.5
    high[1] = max(high[1], 14.5)
    width, height = np.ceil((high - low) / RESOLUTION).astype(int)
    x = low[0] + (np.arange(width) + 0.5) * RESOLUTION
    y = low[1] + (np.arange(height) + 0.5) * RESOLUTION
    cells = np.zeros((height, width), dtype=np.int8)
    for centre_x, centre_y in world.cylinders:
        near = np.hypot(x - centre_x, (y - centre_y)[:, None]) <= world.radius
        cells[near] = 100
    return Grid(cells=cells, resolution=RESOLUTION, origin_x=float(low[0]), origin_y=float(low[1]))
