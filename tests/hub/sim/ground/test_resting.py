"""Where wheels touch, what a body rests on, and how its weight is shared."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.sim.ground.chassis import TRACKED, WHEELED, Chassis
from hub.sim.ground.footing import Footing
from hub.sim.ground.height_field import HeightField
from hub.sim.ground.resting import resting_plane
from hub.sim.ground.rolling import RollingGround
from tests.hub.sim.ground.grounds import block, field_of, ramp, stepfields
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

RUBBLE = field_of(stepfields("flat", 0.1, 1) + "[[ramps]]\nat = [2.6, 0.0]\ntiles = [2, 2]\n")
LEVEL = (0.0,) * len(TRACKED.flippers)


def lowest_points(
    field: HeightField, footing: Footing, chassis: Chassis, place: tuple[float, float, float]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Height of every contact point at rest, and how low the ground lets it go [m]."""
    pose = footing.settled(*place)
    if pose is None:
        return None
    angles = LEVEL if chassis.flippers else ()
    x, y, z = pose.rotation() @ chassis.middles(angles) + np.array([[pose.x], [pose.y], [pose.z]])
    radii = np.array([point.radius for point in chassis.contact_points(angles)])
    support, _ = RollingGround(field, radii).supports(x, y, z)
    return z - radii, support


@settings(max_examples=repetitions(30, 500))
@given(x=st.floats(1.2, 5.2), y=st.floats(0.5, 2.5), yaw=st.floats(-3.2, 3.2), tracks=st.booleans())
def test_no_contact_point_is_below_ground_and_loads_sum_to_one(
    x: float, y: float, yaw: float, *, tracks: bool
) -> None:
    chassis = TRACKED if tracks else WHEELED
    footing = Footing(RUBBLE, chassis, LEVEL if tracks else ())
    points = lowest_points(RUBBLE, footing, chassis, (x, y, yaw))
    if points is None:
        return
    lowest, ground = points
    assert (lowest >= ground - 1e-6).all()
    assert (lowest - ground).min() < 1e-6
    pose = footing.settled(x, y, yaw)
    assert pose is not None
    stand = footing.stance(pose)
    assert stand is not None
    loads = footing.loads(stand)
    assert abs(loads.sum() - 1.0) < 1e-9
    assert loads.min() >= 0.0
    assert 0.0 <= stand.push <= stand.driven_load <= 1.0 + 1e-9


@settings(max_examples=repetitions(25, 500))
@given(seed=st.integers(0, 2**32), count=st.integers(3, 12))
def test_the_resting_plane_is_the_best_of_all_triples(seed: int, count: int) -> None:
    """The dual: the greatest sum of load times height over all triangles around the centre."""
    random = np.random.default_rng(seed)
    x, y, heights = random.uniform(-1.0, 1.0, (3, count))
    centre = tuple(random.uniform(-0.4, 0.4, 2).tolist())
    best = -math.inf
    for triple in itertools.combinations(range(count), 3):
        corners = np.stack((np.ones(3), x[list(triple)], y[list(triple)]))
        loads = np.linalg.solve(corners, np.array((1.0, *centre)))
        if loads.min() >= 0.0:
            best = max(best, float(loads @ heights[list(triple)]))
    plane = resting_plane(x, y, heights, centre, None)
    if plane is None:
        assert best == -math.inf
        return
    assert abs(plane.above(*centre) - best) < 1e-6
    assert (plane.height + plane.east * x + plane.north * y >= heights - 1e-6).all()
    assert abs(sum(plane.loads) - 1.0) < 1e-9
    guess = resting_plane(x, y, heights, centre, (0, 1, 2))
    assert guess is not None
    assert abs(guess.above(*centre) - best) < 1e-6


@for_each("radius", [0.0, 0.03, 0.06])
def test_a_wheel_stands_on_the_ground_as_a_ball_does(radius: float) -> None:
    """Against all points of the ground near the wheel, 1 mm apart."""
    random = np.random.default_rng(5)
    x, y = random.uniform(1.3, 4.9, 40), random.uniform(0.3, 2.3, 40)
    rolling = RollingGround(RUBBLE, np.full(40, radius))
    found, _ = rolling.supports(x, y, np.zeros(40))
    offsets = np.arange(-radius, radius + 5e-4, 1e-3)
    east, north = (part.ravel() for part in np.meshgrid(offsets, offsets))
    under = radius**2 - east**2 - north**2
    east, north, under = (part[under >= 0.0] for part in (east, north, under))
    around = RUBBLE.heights_at(x[:, None] + east, y[:, None] + north)
    wanted = (around + np.sqrt(under) - radius).max(axis=1)
    assert (found >= wanted - 1e-6).all()
    # Next to a step a millimetre to the side is some more in height.
    assert (found - wanted).max() < 0.015
    assert np.median(found - wanted) < 1e-4


@for_each("degrees", [5, 15, 30, 40])
def test_it_leans_as_the_ramp_does_to_a_hundredth_of_a_degree(degrees: int) -> None:
    field = field_of(ramp(degrees))
    for chassis in (WHEELED, TRACKED):
        footing = Footing(field, chassis, LEVEL if chassis.flippers else ())
        up, across = footing.settled(2.5, 1.5, 0.0), footing.settled(2.5, 1.5, math.pi / 2)
        assert up is not None
        assert abs(math.degrees(-up.pitch) - degrees) < 0.01
        assert abs(math.degrees(up.roll)) < 0.01
        assert across is not None
        assert abs(math.degrees(-across.roll) - degrees) < 0.01
        assert abs(math.degrees(across.pitch)) < 0.01


def test_the_weight_moves_downhill() -> None:
    """On wheels at 0 and a castor at -0.15 m, the centre of mass 3 cm behind and 13 cm up."""
    shares = []
    for degrees in (1e-6, 15):
        footing = Footing(field_of(ramp(degrees)), WHEELED, ())
        pose = footing.settled(2.5, 1.5, 0.0)
        assert pose is not None
        stand = footing.stance(pose)
        assert stand is not None
        shares.append(stand.driven_load)
    assert abs(shares[0] - 0.8) < 1e-3
    # The castor is smaller than the wheels: its middle is 3 cm lower, which counts on a slope.
    lean = math.tan(math.radians(15.0))
    assert abs(shares[1] - (0.15 - 0.03 - 0.13 * lean + 0.03 * lean) / 0.15) < 0.05


def test_a_body_tips_where_nothing_holds_its_centre_of_mass() -> None:
    footing = Footing(field_of(block(-1.0, 0.8, 2.5)), WHEELED, ())
    assert footing.settled(1.5 - 0.15, 1.5, 0.0) is not None
    assert footing.settled(1.5 + 0.1, 1.5, 0.0) is None
