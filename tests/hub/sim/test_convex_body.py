"""A body with corners among boxes and cylinders."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import Bumper, Freedom, Motion, Point32, RobotBody
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.outline import corners
from hub.pose import Pose
from hub.robots.simulated_base import SimulatedBase
from hub.robots.simulated_rough_base import RoughBody
from hub.sim.arena import Arena, load_arena
from hub.sim.contact import TOUCH
from hub.sim.convex_body import ConvexBody
from hub.sim.ground.chassis import TRACKED
from tests.hub.sim.arenas import arena_of
from tests.support.repetitions import repetitions

LONG = RobotBody(
    name="long",
    kind="long",
    radius=math.hypot(0.6, 0.2),
    footprint=tuple(
        Point32(x=x, y=y) for x, y in ((0.6, 0.2), (-0.4, 0.2), (-0.4, -0.2), (0.6, -0.2))
    ),
    motions=tuple(
        Motion(freedom=freedom, limit=1.0, acceleration=2.0)
        for freedom in (Freedom.SURGE, Freedom.SWAY, Freedom.YAW)
    ),
    bumpers=tuple(
        Bumper(name=name, direction=math.radians(degrees), width=math.radians(90.0))
        for name, degrees in (("front", 0), ("left", 90), ("back", 180), ("right", -90))
    ),
)
"""1 m long, 0.4 m wide: it turns in 1.26 m."""
FRONT, LEFT, BACK, RIGHT = 1, 2, 4, 8
HEAD = 'name = "walls"\n[start]\nat = [0.0, 0.0]\n'


def boxes(*spans: tuple[float, float, float, float]) -> Arena:
    """Boxes of half a metre, each from x, y to x, y [m]."""
    text = (
        f"[[box]]\nat = [{(x + u) / 2}, {(y + v) / 2}]\nsize = [{u - x}, {v - y}, 0.5]\n"
        for x, y, u, v in spans
    )
    return arena_of(HEAD + "".join(text))


CORRIDOR = boxes((-2.0, 0.3, 6.0, 0.4), (-2.0, -0.4, 6.0, -0.3))
"""0.6 m wide: only the outline goes through."""


def gaps(arena: Arena, robot: SimulatedBase | RoughBody, body: RobotBody = LONG) -> float:
    truth = robot.ground_truth()
    pose = Pose(x=truth.x, y=truth.y, theta=truth.theta)
    outline = ConvexBody(corners(body), arena.footprints)
    return float(outline.gaps(pose)[0].min())


@given(
    x=st.floats(-1.5, 1.5),
    y=st.floats(-1.5, 1.5),
    theta=st.floats(-math.pi, math.pi),
    width=st.floats(0.05, 1.0),
    radius=st.floats(0.02, 0.5),
)
def test_gaps_are_negative_exactly_where_shapes_overlap(
    x: float, y: float, theta: float, width: float, radius: float
) -> None:
    text = (
        f"{HEAD}[[box]]\nat = [{-width}, -0.1]\nsize = [{2 * width}, 0.3, 0.5]\n"
        f"[[cylinder]]\nat = [0.0, 3.0]\nradius = {radius}\nheight = 0.5\n"
    )
    there = arena_of(text).footprints
    outline = ConvexBody(corners(LONG), there)
    # Points of the outline and of its inside, 2 cm apart or less.
    u, v = (
        each.ravel() for each in np.meshgrid(np.linspace(-0.4, 0.6, 51), np.linspace(-0.2, 0.2, 21))
    )
    for number, pose in enumerate((Pose(x=x, y=y, theta=theta), Pose(x=x, y=y + 3.0, theta=theta))):
        px, py = pose.outward(u, v)
        away = min(
            float(there.distances(a, b)[number])
            for a, b in zip(px.tolist(), py.tolist(), strict=True)
        )
        found = outline.gaps(pose)
        gap, way = float(found[0][number]), found[1][number]
        assert np.hypot(*way) == pytest.approx(1.0)
        assert gap <= away + 1e-9
        if gap > 0.03:
            assert away > 0.0
        if gap < -0.03:
            assert away <= 0.0


def test_a_long_body_drives_through_a_corridor_that_its_circle_does_not_fit() -> None:
    robot = SimulatedBase(CORRIDOR, LONG)
    robot.command(Twist.planar(0.5, 0.0))
    robot.advance(5.0)
    truth = robot.ground_truth()
    assert truth.x > 2.0
    assert truth.contacts == 0
    assert not robot.sensors(0.0).bumpers


def test_it_does_not_turn_where_its_corners_meet_walls_and_its_encoders_stand() -> None:
    robot = SimulatedBase(CORRIDOR, LONG)
    robot.command(Twist.planar(0.0, 1.0))
    robot.advance(4.0)
    truth = robot.ground_truth()
    assert 0.05 < truth.theta < 0.8
    assert truth.angular == 0.0
    assert truth.touching
    assert robot.sensors(0.0).theta == pytest.approx(truth.theta, abs=0.05)
    robot.command(Twist.planar(0.0, -1.0))
    robot.advance(0.5)
    assert robot.ground_truth().theta < truth.theta - 0.1


@pytest.mark.parametrize(
    ("way", "pressed"),
    [((1.0, 0.0), FRONT), ((-1.0, 0.0), BACK), ((0.0, 1.0), LEFT), ((0.0, -1.0), RIGHT)],
)
def test_the_bumpers_on_the_side_that_touches_are_pressed(
    way: tuple[float, float], pressed: int
) -> None:
    arena = boxes(
        (1.0, -3.0, 1.2, 3.0),
        (-1.2, -3.0, -1.0, 3.0),
        (-3.0, 1.0, 3.0, 1.2),
        (-3.0, -1.2, 3.0, -1.0),
    )
    robot = SimulatedBase(arena, LONG)
    robot.command(Twist(linear=Vector3(x=0.5 * way[0], y=0.5 * way[1])))
    robot.advance(4.0)
    assert gaps(arena, robot) == pytest.approx(0.0, abs=TOUCH)
    assert robot.sensors(0.0).bumpers & pressed
    assert not robot.sensors(0.0).bumpers & (pressed * 4 if pressed < BACK else pressed // 4)


@pytest.mark.parametrize("rough", [False, True])
def test_no_commands_bring_its_outline_into_anything(rough: bool) -> None:  # noqa: FBT001 - a case
    arena = load_arena("yellow")
    for seed in range(repetitions(2, 40)):
        random = np.random.default_rng(seed)
        robot = RoughBody(arena, LONG, TRACKED) if rough else SimulatedBase(arena, LONG)
        for _ in range(25):
            surge, sway, yaw = random.uniform(-1.0, 1.0, 3).tolist()
            robot.command(Twist(linear=Vector3(x=surge, y=sway), angular=Vector3(z=yaw)))
            robot.advance(1.0)
            assert gaps(arena, robot) > -1e-6
