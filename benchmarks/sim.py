"""Cost of the simulator: pictures and sonar scans at many poses of the yellow arena."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.figures import median_ms, report
from hub.robots.magellan import SimulatedCamera
from hub.sim.arena import BODY_RADIUS, Arena, load_arena
from hub.sim.geometry import Pose
from hub.sim.range_sensors import RangeSensors

POSES = 200


def free_poses(arena: Arena, count: int) -> list[Pose]:
    """Poses at which the robot touches nothing, the same in every run."""
    random = np.random.default_rng(2003)
    poses: list[Pose] = []
    while len(poses) < count:
        x, y, theta = random.uniform((0.0, 0.0, -math.pi), (10.0, 10.0, math.pi)).tolist()
        if arena.footprints.distances(x, y).min() > BODY_RADIUS:
            poses.append(Pose(x=x, y=y, theta=theta))
    return poses


def main() -> None:
    arena = load_arena("yellow")
    poses = free_poses(arena, POSES)
    camera = SimulatedCamera(arena)
    note = f"median over {POSES} poses, {len(arena.boxes)} boxes, one core"
    for width, height, bar in ((160, 120, 6.0), (320, 240, 20.0)):

        def draw(number: int, width: int = width, height: int = height) -> None:
            pose = poses[number % POSES]
            camera.place(pose.x, pose.y, pose.theta)
            camera.capture(width, height)

        value = median_ms(draw, POSES)
        report(f"sim.picture_{width}x{height}_ms", value, "ms", bar=bar, note=note)

    sensors = RangeSensors(arena.footprints, np.random.SeedSequence(1))
    value = median_ms(lambda number: sensors.sonar(poses[number % POSES]), 5 * POSES)
    report("sim.sonar_scan_ms", value, "ms", bar=0.3, note=note + ", 16 sonars")


if __name__ == "__main__":
    main()
