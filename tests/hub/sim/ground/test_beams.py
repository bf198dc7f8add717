"""Range sensors that look at the ground."""

from __future__ import annotations

import math

import numpy as np

from hub.sim.ground.beams import ground_echoes, ground_hits
from tests.hub.sim.ground.grounds import block, field_of, ramp, stepfields

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
    echoes = ground_echoes(field_of(text), origins, directions, 5.0)
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
    for ways in (distance - 0.001, np.where(np.isinf(distance), 3.0, distance) - 0.001):
        seen = np.isfinite(distance)
        # In front of the hit the beam is above ground, apart from corners that it only grazes.
        for part in (0.3, 0.6, 0.9):
            point = origins + directions * (np.minimum(ways, 3.0) * part)[:, None]
            clear = point[:, 2] > field.heights_at(point[:, 0], point[:, 1])
            assert clear[seen].mean() > 0.97


def test_a_deck_is_ground_for_beams_from_above_it() -> None:
    text = "[[deck]]\nat = [1.0, 0.0]\nsize = [2.0, 3.0]\nheight = 0.6\n"
    distance, _ = hits(text, beam(1.5, 0.8, 90.0), beam(1.5, 0.4, 90.0))
    assert np.abs(distance - (0.2, 0.4)).max() < 1e-6
