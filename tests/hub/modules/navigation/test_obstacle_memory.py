"""What was met is remembered until it is seen to be gone, and what cannot be seen is feared."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.navigation import DriveState
from hub.modules.navigation.obstacle_memory import CONE_S, RAY_S, ObstacleMemory

RADIUS = 0.205
REACH = 2.0


def scan(
    *,
    infrared: dict[int, float] | None = None,
    sonar: dict[int, float] | None = None,
    bumpers: int = 0,
    x: float = 0.0,
    theta: float = 0.0,
) -> DriveState:
    """Ranges [m] of some sensors; the others see nothing."""
    ranges = [np.full(16, np.inf, dtype=np.float32) for _ in range(2)]
    for values, given in zip(ranges, (infrared, sonar), strict=True):
        for number, value in (given or {}).items():
            values[number] = value
    return DriveState(
        stamp=0.0,
        x=x,
        y=0.0,
        theta=theta,
        linear=0.0,
        angular=0.0,
        commanded_linear=0.0,
        commanded_angular=0.0,
        sonar=ranges[1],
        infrared=ranges[0],
        bumpers=bumpers,
        battery_voltage=24.0,
        battery_fraction=1.0,
    )


def places(memory: ObstacleMemory, x: float = 0.0, theta: float = 0.0) -> list[tuple[float, float]]:
    left, up = memory.points(x, 0.0, theta, REACH)
    return sorted((round(float(a), 2), round(float(b), 2)) for a, b in zip(left, up, strict=True))


def test_a_ray_is_a_point_and_a_cone_an_arc() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.75}), 0.0)
    assert places(memory) == [(0.75, 0.0)]
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(sonar={4: 0.75}), 0.0)
    assert len(places(memory)) > 1
    assert all(abs(math.hypot(*place) - 0.75) < 0.02 and place[1] > 0.6 for place in places(memory))


def test_points_stay_where_they_are_when_the_robot_moves() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.75}), 0.0)
    assert places(memory, x=0.3) == [(0.45, 0.0)]
    assert places(memory, x=0.3, theta=math.pi / 2.0) == [(0.0, -0.45)]


def test_a_point_between_two_rays_is_remembered() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.75}), 0.0)
    memory.scanned(scan(theta=0.2), 0.1)
    assert places(memory) == [(0.75, 0.0)]


def test_a_point_that_rays_pass_through_is_forgotten() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.5}), 0.0)
    assert (0.5, 0.0) in places(memory)
    for number in range(1, 6):
        memory.scanned(scan(x=-0.02 * number), 0.1 * number)
    assert (0.5, 0.0) not in places(memory)


def test_cones_are_forgotten_sooner_than_rays_and_nothing_for_long() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={2: 0.6}, sonar={8: 0.6}), 0.0)
    drive(memory, CONE_S + 0.5)
    assert len(places(memory)) == 1
    drive(memory, RAY_S + 0.5)
    assert places(memory) == []


def drive(memory: ObstacleMemory, until: float) -> None:
    """Turn on the spot, out of sight of everything, until some time."""
    for step in range(round(until / 0.1)):
        silent = scan(theta=0.02 * step)
        memory.scanned(silent, 0.1 * step)


def test_standing_it_remembers_for_longer() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(sonar={0: 0.4}), 0.0)
    for step in range(1, 51):
        memory.scanned(scan(), 0.1 * step)
    assert places(memory)


def test_a_pressed_bumper_is_a_point_at_the_rim() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(bumpers=1 << 4), 0.0)
    (place,) = places(memory)
    assert abs(place[0]) < 0.01
    assert abs(place[1] - RADIUS) < 0.01


def test_what_is_too_near_to_be_measured_is_taken_to_be_at_the_rim() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.303}), 0.0)
    assert min(place[0] for place in places(memory)) < RADIUS + 0.02


def test_an_echo_explains_what_is_too_near_for_infrared() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.303}, sonar={0: 0.29}), 0.0)
    assert min(math.hypot(*place) for place in places(memory)) > 0.28


def test_a_corner_is_feared_between_two_rays_from_where_no_echo_comes() -> None:
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.5, 1: 0.5}), 0.0)
    assert min(math.hypot(*place) for place in places(memory)) < 0.41
    memory = ObstacleMemory(RADIUS)
    memory.scanned(scan(infrared={0: 0.5, 1: 0.5}, sonar={0: 0.5, 1: 0.5}), 0.0)
    assert min(math.hypot(*place) for place in places(memory)) > 0.48
