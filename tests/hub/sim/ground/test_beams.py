"""Range sensors that look at the ground."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.beams import beams_of
from hub.pose import Pose
from hub.robots.robot_file import find_robot_file, read_description
from hub.sim.arena import Arena
from hub.sim.ground.beams import ground_echoes, ground_hits
from hub.sim.range_sensors import SONAR_INCIDENCE, RangeSensors
from hub.sim.spatial_pose import SpatialPose
from tests.hub.sim.ground.grounds import block, field_of, ground_arena, ramp, stepfields
from tests.support.magellan import magellan_body

Beam = tuple[tuple[float, float, float], tuple[float, float, float]]


def beam(x: float, z: float, down_deg: float, y: float = 1.5, east: float = 1.0) -> Beam:
    """A beam that looks east, or west, and down by an angle."""
    down = math.radians(down_deg)
    return (x, y, z), (east * math.cos(down), 0.0, -math.sin(down))


def hits(text: str, *beams: Beam) -> tuple[np.ndarray, np.ndarray]:
    origins, directions = np.array(beams).transpose(1, 0, 2)
    return ground_hits(field_of(text), origins, directions, 5.0)


def test_nose_down_the_floor_is_ahead_but_a_smooth_floor_gives_no_echo() -> None:
    """A sonar 0.2 m up at 15 degrees meets the floor at 0.77 m, 0.75 m ahead, at 75 degrees."""
    text = block(8.0, 0.1)
    distance, square = hits(text, beam(0.0, 0.2, 15.0), beam(0.0, 0.2, 70.0), beam(0.0, 0.2, -5.0))
    wanted = 0.2 / math.sin(math.radians(15.0))
    assert abs(distance[0] - wanted) < 1e-9
    assert abs(square[0] - math.cos(math.radians(75.0))) < 1e-9
    assert abs(distance[1] - 0.2 / math.sin(math.radians(70.0))) < 1e-9
    assert np.isinf(distance[2])
    origins, directions = np.array([beam(0.0, 0.2, d) for d in (15.0, 70.0, -5.0)]).transpose(
        1, 0, 2
    )
    echoes = ground_echoes(field_of(text), origins, directions, 5.0, SONAR_INCIDENCE)
    assert np.isinf(echoes[0])
    assert echoes[1] == distance[1]
    assert np.isinf(echoes[2])
    assert np.isfinite(ground_echoes(field_of(text), origins, directions, 5.0, math.pi / 2)[0])


def test_sides_of_steps_and_ramps_echo() -> None:
    text = block(2.0, 0.3, 1.0) + block(4.0, 0.1, 1.0)
    distance, square = hits(
        text, beam(0.5, 0.2, 0.0), beam(3.9, 0.2, 0.0, east=-1.0), beam(0.5, 0.35, 0.0)
    )
    assert np.abs(distance[:2] - (1.5, 0.9)).max() < 1e-6
    assert np.abs(square[:2] - 1.0).max() < 1e-9
    assert np.isinf(distance[2])
    steep, level = hits(ramp(40), beam(1.0, 0.2, 0.0))
    assert abs(steep[0] - 0.5 - 0.2 / math.tan(math.radians(40.0))) < 1e-6
    assert abs(level[0] - math.sin(math.radians(40.0))) < 1e-6


def test_a_post_is_seen_before_what_stands_behind_it() -> None:
    field = field_of(stepfields("flat", 0.1, 1))
    random = np.random.default_rng(3)
    turns = random.uniform(-0.4, 0.4, 60)
    falls = random.uniform(-0.1, 0.3, 60)
    origins = np.tile((0.7, 1.5, 0.25), (60, 1))
    directions = np.stack(
        (np.cos(turns) * np.cos(falls), np.sin(turns) * np.cos(falls), -np.sin(falls)), axis=1
    )
    distance, square = ground_hits(field, origins, directions, 3.0)
    assert ((square >= 0.0) & (square <= 1.0)).all()
    assert 20 < np.isfinite(distance).sum() < 60
    # Before its hit, or all the way, a beam is above ground, except at corners that it grazes.
    ways = np.minimum(distance, 3.0) - 0.001
    for part in (0.3, 0.6, 0.9):
        point = origins + directions * (ways * part)[:, None]
        clear = point[:, 2] > field.heights_at(point[:, 0], point[:, 1])
        assert clear.mean() > 0.97


def test_a_deck_is_ground_for_beams_from_above_it() -> None:
    text = "[[deck]]\nat = [1.0, 0.0]\nsize = [2.0, 3.0]\nheight = 0.6\n"
    distance, _ = hits(text, beam(1.5, 0.8, 90.0), beam(1.5, 0.4, 90.0))
    assert np.abs(distance - (0.2, 0.4)).max() < 1e-6


def test_beams_find_the_same_ground_as_all_their_samples_do() -> None:
    field = field_of(stepfields("hill", 0.1, 2) + ramp(20).replace("1.5, 0.0", "4.5, 0.0"))
    random = np.random.default_rng(8)
    turns, falls = random.uniform(-3.1, 3.1, 300), random.uniform(-0.2, 0.6, 300)
    origins = np.stack(
        (random.uniform(0, 7, 300), random.uniform(0, 3, 300), np.full(300, 0.65)), axis=1
    )
    directions = np.stack(
        (np.cos(turns) * np.cos(falls), np.sin(turns) * np.cos(falls), -np.sin(falls)), axis=1
    )
    found, _ = ground_hits(field, origins, directions, 5.0)
    ways = np.arange(1, 251) * 0.02
    x, y, z = (origins[:, k, None] + directions[:, k, None] * ways for k in range(3))
    below = z <= field.heights_at(x, y)
    first = np.where(below.any(axis=1), ways[below.argmax(axis=1)], np.inf)
    assert (np.isfinite(found) == np.isfinite(first)).mean() > 0.99
    both = np.isfinite(found) & np.isfinite(first)
    assert 100 < both.sum() < 300
    assert np.abs(found[both] - first[both]).max() < 0.021


def ahead(arena: Arena, pose: SpatialPose) -> float:
    """What the middle beam of the tracked robot's laser measures, 0.15 m ahead and 0.35 m up."""
    beams = beams_of(read_description(find_robot_file("tracked"))[0].body)
    sensors = RangeSensors(arena.footprints, beams, np.random.SeedSequence(1), arena.ground)
    return float(sensors.measure("scan", pose.plan, pose)[135])


def test_range_sensors_lean_with_the_robot_and_meet_the_ground() -> None:
    wall = "[[wall]]\nfrom = [6.05, 0.0]\nto = [6.05, 3.0]\n"
    pose = SpatialPose(x=0.6, y=1.5)
    for height, wanted in ((0.5, 1.25), (0.3, 5.25)):
        seen = ahead(ground_arena(block(2.0, height, 1.0) + wall), pose)
        assert abs(seen - wanted) < 0.04
    # Nose down by 10 degrees: 0.345 m up and 0.2 m ahead of the axle, the floor is 1.9 m away.
    nose_down = SpatialPose(x=0.6, y=1.5, pitch=math.radians(10.0))
    up = 0.35 * math.cos(nose_down.pitch) - 0.15 * math.sin(nose_down.pitch)
    seen = ahead(ground_arena(block(8.0, 0.1) + wall), nose_down)
    assert abs(seen - up / math.sin(nose_down.pitch)) < 0.04


def test_sonars_hear_ramps_and_posts_but_no_floor_that_they_graze() -> None:
    beams = beams_of(magellan_body())
    nose_down = SpatialPose(x=0.6, y=1.5, pitch=math.radians(15.0))
    heard = []
    for text in (block(8.0, 0.1), block(1.3, 0.3, 0.1)):
        arena = ground_arena(text)
        sensors = RangeSensors(arena.footprints, beams, np.random.SeedSequence(1), arena.ground)
        heard.append(float(sensors.measure("sonar", Pose(x=0.6, y=1.5), nose_down)[0]))
    assert math.isinf(heard[0])
    assert 0.6 < heard[1] < 0.85
