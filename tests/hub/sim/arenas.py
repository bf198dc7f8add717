"""Small arenas for tests, built from the text of a file."""

from __future__ import annotations

import tomllib

import numpy as np

from hub.gcm.body import USUAL_RADIUS
from hub.pose import Pose
from hub.sim.arena import Arena, arena_from_spec
from hub.sim.arena_file import check_arena

VOID = 'name = "void"\n[start]\nat = [0.0, 0.0]\n'


def arena_of(text: str) -> Arena:
    spec, problems = check_arena(tomllib.loads(text))
    assert spec is not None, problems
    return arena_from_spec(spec)


def free_poses(arena: Arena, count: int, seed: int, low: float, high: float) -> list[Pose]:
    """Poses within a square at which the robot touches nothing."""
    random = np.random.default_rng(seed)
    poses: list[Pose] = []
    while len(poses) < count:
        x, y = random.uniform(low, high, 2).tolist()
        if arena.footprints.distances(x, y).min() > USUAL_RADIUS + 0.01:
            poses.append(Pose(x=x, y=y, theta=float(random.uniform(-3.14, 3.14))))
    return poses
