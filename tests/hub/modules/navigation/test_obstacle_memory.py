"""What was met is remembered until it is seen to be gone, and what cannot be seen is feared."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beam_scans import BeamScan
from hub.gcm.beams import beams_of
from hub.gcm.ranges import as_measured
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.obstacle_memory import CONE_S, RAY_S, ObstacleMemory
from hub.pose import Pose
from tests.hub.modules.navigation.drives import ROBOT
from tests.support.messages import drive_state

BODY = ROBOT.body
RADIUS = BODY.radius
REACH = 1.8


class Memory(ObstacleMemory):
    """The memory of a Magellan."""

    def __init__(self) -> None:
        super().__init__(BODY, BeamRules(BODY, beams_of(BODY)), REACH)

    def see(
        self,
        now: float,
        *,
        infrared: dict[int, float] | None = None,
        sonar: dict[int, float] | None = None,
        x: float = 0.0,
        theta: float = 0.0,
    ) -> None:
        """Take ranges [m] of some sensors; the others see nothing."""
        beams = beams_of(BODY)
        ranges = np.full(len(beams.kind), np.inf)
        for name, given in (("infrared", infrared), ("sonar", sonar)):
            for number, value in (given or {}).items():
                ranges[beams.groups[name]][number] = value
        self.moved(drive_state(x=x, theta=theta), now)
        fresh = np.ones(len(ranges), dtype=np.bool_)
        self.scanned(BeamScan(pose=Pose(x=x, theta=theta), ranges=ranges, fresh=fresh), now)


def places(memory: Memory, x: float = 0.0, theta: float = 0.0) -> list[tuple[float, float]]:
    left, up = memory.points(x, 0.0, theta, REACH)
    return sorted((round(float(a), 2), round(float(b), 2)) for a, b in zip(left, up, strict=True))


def test_a_ray_is_a_point_and_a_cone_an_arc() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.75})
    assert places(memory) == [(0.75, 0.0)]
    memory = Memory()
    memory.see(0.0, sonar={4: 0.75})
    assert len(places(memory)) > 1
    assert all(abs(math.hypot(*place) - 0.75) < 0.02 and place[1] > 0.6 for place in places(memory))


def test_points_stay_where_they_are_when_the_robot_moves() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.75})
    assert places(memory, x=0.3) == [(0.45, 0.0)]
    assert places(memory, x=0.3, theta=math.pi / 2.0) == [(0.0, -0.45)]


def test_a_point_between_two_rays_is_remembered() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.75})
    memory.see(0.1, theta=0.2)
    assert places(memory) == [(0.75, 0.0)]


def test_a_point_that_rays_pass_through_is_forgotten() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.5})
    assert (0.5, 0.0) in places(memory)
    for number in range(1, 6):
        memory.see(0.1 * number, x=-0.02 * number)
    assert (0.5, 0.0) not in places(memory)


def test_rays_without_a_measurement_pass_through_nothing() -> None:
    """Drivers of lasers say 0 for it, also where something is too near."""
    assert np.isnan(as_measured(np.zeros(1, np.float32), 0.12, 3.5)).all()
    memory = Memory()
    memory.see(0.0, infrared={0: 0.5})
    unknown = dict.fromkeys(range(16), math.nan)
    for number in range(1, 6):
        memory.see(0.1 * number, x=-0.02 * number, infrared=unknown, sonar=unknown)
    assert (0.5, 0.0) in places(memory)


def test_cones_are_forgotten_sooner_than_rays_and_nothing_for_long() -> None:
    memory = Memory()
    memory.see(0.0, infrared={2: 0.6}, sonar={8: 0.6})
    drive(memory, CONE_S + 0.5)
    assert len(places(memory)) == 1
    drive(memory, RAY_S + 0.5)
    assert places(memory) == []


def drive(memory: Memory, until: float) -> None:
    """Turn on the spot, out of sight of everything, until some time."""
    for step in range(round(until / 0.1)):
        memory.see(0.1 * step, theta=0.02 * step)


def test_standing_it_remembers_for_longer() -> None:
    memory = Memory()
    memory.see(0.0, sonar={0: 0.4})
    for step in range(1, 51):
        memory.see(0.1 * step)
    assert places(memory)


def test_a_pressed_bumper_is_a_point_at_the_rim() -> None:
    memory = Memory()
    memory.moved(drive_state(bumpers=1 << 4), 0.0)
    (place,) = places(memory)
    assert abs(place[0]) < 0.01
    assert abs(place[1] - RADIUS) < 0.01


def test_what_is_too_near_to_be_measured_is_taken_to_be_at_the_rim() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.303})
    assert min(place[0] for place in places(memory)) < RADIUS + 0.02


def test_an_echo_explains_what_is_too_near_for_infrared() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.303}, sonar={0: 0.29})
    assert min(math.hypot(*place) for place in places(memory)) > 0.28


def test_a_corner_is_feared_between_two_rays_from_where_no_echo_comes() -> None:
    memory = Memory()
    memory.see(0.0, infrared={0: 0.5, 1: 0.5})
    assert min(math.hypot(*place) for place in places(memory)) < 0.41
    memory = Memory()
    memory.see(0.0, infrared={0: 0.5, 1: 0.5}, sonar={0: 0.5, 1: 0.5})
    assert min(math.hypot(*place) for place in places(memory)) > 0.48
