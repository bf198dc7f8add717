"""Solids around a floating body: what it touches, what its sensors see below."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.sim.afloat.body_contact import TOUCH, BodyContact, ContactShape
from hub.sim.afloat.sensors import (
    Altimeter,
    Anemometer,
    Barometer,
    Compass,
    EchoSounder,
    Gyro,
    PressureSensor,
    TiltSensor,
)
from hub.sim.afloat.surroundings import Surroundings
from hub.sim.geometry import Box, Cylinder, Surface
from tests.hub.sim.arenas import VOID, arena_of
from tests.hub.sim.camera.rough_ground import height_field, on
from tests.support.cases import for_each

WOOD, CLOTH = Surface(texture="wood", colour=(9, 9, 9)), Surface(texture="fabric", colour=(9, 9, 9))
TABLE = Box(low=(1.0, -1.0, 0.0), high=(3.0, 1.0, 0.75), surface=WOOD)
SOFA = Box(low=(-3.0, -1.0, 0.0), high=(-1.0, 1.0, 0.5), surface=CLOTH)
SHELF = Box(low=(-1.0, 2.0, 1.5), high=(1.0, 3.0, 1.6), surface=WOOD)
POST = Cylinder(x=0.0, y=-3.0, radius=0.2, low=0.0, high=2.5, surface=WOOD)
ROOM = Surroundings((TABLE, SOFA, SHELF), (POST,), ceiling=3.0)
SHAPE = ContactShape(radius=0.3, above=0.2, below=0.25)


def moved(
    contact: BodyContact, place: tuple[float, float, float], way: tuple[float, float, float]
) -> tuple[float, float, float]:
    """The end of a way in steps of a centimetre."""
    steps = math.ceil(math.hypot(*way) / 0.01)
    for _ in range(steps):
        x, y, z = (at + each / steps for at, each in zip(place, way, strict=True))
        place = contact.move(place, (x, y, z))
    return place


def clearance(place: tuple[float, float, float]) -> float:
    x, y, z = place
    across = ROOM.distances(x, y) - SHAPE.radius
    along = np.maximum(ROOM.bottom - z - SHAPE.above, z - SHAPE.below - ROOM.top)
    inside = min(z - SHAPE.below, 3.0 - z - SHAPE.above)
    return min(float(np.maximum(across, along).min()), inside)


PLACES = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(0.3, 2.7))


@given(places=st.lists(PLACES, min_size=2, max_size=5))
def test_no_way_brings_the_body_into_anything(places: list[tuple[float, float, float]]) -> None:
    contact = BodyContact(ROOM, SHAPE)
    place = contact.move((0.0, 0.0, 1.0), (0.0, 0.0, 1.0))
    for goal in places:
        x, y, z = (wanted - at for wanted, at in zip(goal, place, strict=True))
        for _ in range(20):
            place = moved(contact, place, (x / 20.0, y / 20.0, z / 20.0))
            assert clearance(place) >= -1e-9


@for_each(
    ("start", "way", "end"),
    [
        ((0.0, 0.0, 0.5), (2.0, 0.0, 0.0), (0.7, 0.0, 0.5)),
        ((0.0, 0.0, 1.1), (2.0, 0.0, 0.0), (2.0, 0.0, 1.1)),
        ((2.0, 0.0, 1.5), (0.0, 0.0, -1.0), (2.0, 0.0, 1.0)),
        ((0.0, 0.0, 1.5), (0.0, 0.0, -2.0), (0.0, 0.0, 0.25)),
        ((0.0, 0.0, 1.5), (0.0, 0.0, 2.0), (0.0, 0.0, 2.8)),
        ((0.0, 2.5, 1.0), (0.0, 0.0, 1.0), (0.0, 2.5, 1.3)),
        ((0.0, 0.0, 1.0), (0.0, -4.0, 0.0), (0.0, -2.5, 1.0)),
        ((0.0, 0.0, 0.5), (2.0, 0.5, 0.0), (0.7, 0.5, 0.5)),
    ],
)
def test_the_body_stops_at_sides_tops_and_undersides_and_slides_along_them(
    start: tuple[float, float, float],
    way: tuple[float, float, float],
    end: tuple[float, float, float],
) -> None:
    contact = BodyContact(ROOM, SHAPE)
    assert moved(contact, start, way) == pytest.approx(end, abs=TOUCH)


def test_contacts_count_and_only_what_is_below_supports() -> None:
    contact = BodyContact(ROOM, SHAPE)
    place = moved(contact, (0.0, 0.0, 0.5), (1.0, 0.0, 0.0))
    assert (contact.contacts, contact.supported, len(contact.touched)) == (1, False, 1)
    assert contact.normals == [pytest.approx((-1.0, 0.0, 0.0))]
    place = moved(contact, place, (-0.3, 0.0, 0.0))
    assert not contact.touched
    place = moved(contact, place, (0.4, 0.0, 0.0))
    assert contact.contacts == 2
    moved(contact, place, (0.0, 0.0, -1.0))
    assert contact.supported


def slope_and_wall() -> Surroundings:
    """Ground that rises by a tenth to the east, and by a metre at x = 3."""
    x = (np.arange(200) + 0.5) * 0.025
    heights = np.tile(np.where(x < 3.0, 0.1 * x, 1.3), (200, 1)).astype(np.float32)
    ground = height_field(heights, np.zeros((200, 200), dtype=np.uint16), (0.0, -2.5))
    return Surroundings.in_air(on(ground, arena_of(VOID)))


def test_rough_ground_lifts_the_body_and_a_ledge_stops_it() -> None:
    slope = slope_and_wall()
    contact = BodyContact(slope, SHAPE)
    x, _, z = moved(contact, (0.5, 0.0, 0.3), (1.5, 0.0, 0.0))
    assert (x, z) == pytest.approx((2.0, 0.25 + 0.1 * 2.3), abs=0.005)
    assert slope.below(2.0, 0.0, 1.2, 0.1).distance == pytest.approx(1.0, abs=0.002)
    place = moved(contact, (x, 0.0, z), (2.0, 0.0, 0.0))
    x, _, z = place
    assert x == pytest.approx(2.7, abs=0.05)
    assert z < 0.6
    assert moved(contact, place, (0.5, 0.0, 0.5))[2] == pytest.approx(z + 0.5)
    assert moved(contact, (0.5, 0.0, 2.0), (3.0, 0.0, 0.0))[2] == 2.0
    assert slope.ground.height(-0.01, 0.0) == slope.ground.height(9.0, 9.0) == 0.0
    assert slope.ground.highest(-0.2, 0.0, 0.3) == pytest.approx(0.01, abs=0.003)
    assert slope.ground.highest(5.2, 2.6, 0.3) == pytest.approx(1.3)


def test_water_is_ground_in_the_air_and_a_diver_stays_within_it() -> None:
    text = VOID + "[water]\nsurface = 1.5\narea = [[-2.0, -2.0], [2.0, 2.0]]\n"
    arena = arena_of(text)
    above = Surroundings.in_air(arena)
    assert above.below(0.0, 0.0, 2.0, 0.1).distance == pytest.approx(0.5)
    assert above.below(2.1, 0.0, 2.0, 0.1).distance == pytest.approx(2.0)
    contact = BodyContact(above, SHAPE)
    assert moved(contact, (0.0, 0.0, 2.0), (0.0, 0.0, -1.0))[2] == pytest.approx(1.75)
    assert contact.supported
    contact = BodyContact(Surroundings.under_water(arena), SHAPE)
    end = moved(contact, (0.0, 0.0, 1.0), (5.0, -5.0, 0.0))
    assert end == pytest.approx((1.7, -1.7, 1.0))
    assert contact.normals == [(-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    assert moved(contact, end, (0.0, 0.0, -2.0))[2] == pytest.approx(0.25)


@for_each(
    ("x", "y", "z", "distance", "soft"),
    [
        (0.0, 0.0, 1.0, 1.0, False),
        (2.0, 0.0, 1.0, 0.25, False),
        (-2.0, 0.0, 1.0, 0.5, True),
        (0.0, 2.5, 1.2, 1.2, False),
        (0.0, 2.5, 2.0, 0.4, False),
        (0.8, 0.0, 2.0, 1.25, False),
        (0.0, -3.0, 2.9, 0.4, False),
    ],
)
def test_a_beam_down_meets_the_highest_thing_in_it(
    x: float, y: float, z: float, distance: float, *, soft: bool
) -> None:
    below = ROOM.below(x, y, z, math.radians(10.0))
    assert (below.distance, below.soft) == (pytest.approx(distance), soft)


def seeded(number: int = 1) -> np.random.SeedSequence:
    return np.random.SeedSequence(number)


def test_an_altimeter_sees_the_table_and_hears_nothing_over_fabric_or_tilted() -> None:
    altimeter = Altimeter(seeded())
    ranges = [altimeter.measure(ROOM, 0.0, 0.0, 1.5, 0.0) for _ in range(200)]
    assert np.mean(ranges) == pytest.approx(1.5, abs=0.003)
    assert 0.005 < np.std(ranges) < 0.02
    assert altimeter.measure(ROOM, 2.0, 0.0, 1.5, 0.0) == pytest.approx(0.75, abs=0.05)
    assert math.isnan(altimeter.measure(ROOM, -2.0, 0.0, 1.5, 0.0))
    assert math.isnan(altimeter.measure(ROOM, 0.0, 0.0, 1.5, math.radians(26.0)))
    assert math.isnan(altimeter.measure(ROOM, 0.0, 0.0, 0.45, 0.0))
    assert math.isnan(altimeter.measure(Surroundings(), 0.0, 0.0, 6.5, 0.0))


def test_the_other_sensors_err_as_their_figures_say() -> None:
    pressure = PressureSensor(seeded())
    depths = np.array([pressure.measure(1.0) for _ in range(500)])
    assert np.allclose(depths / 0.002, np.rint(depths / 0.002))
    assert depths.std() == pytest.approx(0.0026, rel=0.15)
    compass = Compass(seeded(), worst=math.radians(10.0))
    errors = [compass.error(x, y) for x, y in itertools.product(np.linspace(0, 10, 30), repeat=2)]
    assert math.radians(7.0) < max(map(abs, errors)) <= math.radians(10.0)
    assert abs(compass.measure(1.0, 2.0, 1.0) - 1.0 - compass.error(1.0, 2.0)) < 0.1
    barometer = Barometer(seeded())
    drift = np.array([barometer.measure(2.0, 10.0) for _ in range(2000)]) - 2.0
    assert 0.1 < drift.std() < 0.25
    sounder = EchoSounder(seeded())
    ranges = np.array([sounder.measure(Surroundings(), 0.0, 0.0, 4.1) for _ in range(200)]) - 0.1
    assert abs(ranges.mean() / 4.0 - 1.0) <= 0.017
    assert ranges.std() == pytest.approx(0.02, rel=0.3)
    others = [
        EchoSounder(seeded(each)).measure(Surroundings(), 0.0, 0.0, 50.1) for each in range(30)
    ]
    assert 0.36 < np.std(others) < 0.8
    assert math.isnan(sounder.measure(Surroundings(), 0.0, 0.0, 0.35))
    anemometer = Anemometer(seeded())
    assert anemometer.measure(0.04) == 0.0
    assert anemometer.measure(0.5) == pytest.approx(0.5, abs=0.1)
    assert Gyro(seeded()).measure(0.1, 0.2, 0.3) == pytest.approx((0.1, 0.2, 0.3), abs=0.03)
    assert TiltSensor(seeded()).measure(0.1, 0.2) == pytest.approx((0.1, 0.2), abs=0.04)


def test_the_same_seed_gives_the_same_values_to_the_last_bit() -> None:
    def values(seed: int) -> list[object]:
        compass, gyro = Compass(seeded(seed), worst=0.1), Gyro(seeded(seed))
        return [
            [compass.measure(1.0, number, 0.0), gyro.measure(0.0, 0.0, 0.0)] for number in range(9)
        ]

    assert values(1) == values(1)
    assert values(1) != values(2)
