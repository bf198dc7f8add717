"""The window takes away what would lead into something, and nothing else."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
from hypothesis import assume, given
from hypothesis import strategies as st

from hub.gcm.outline import hull
from hub.modules.navigation.dynamic_window import BodyLimits, DynamicWindow
from hub.modules.navigation.sweeps import Sweep
from hub.pose import Pose
from tests.hub.modules.navigation.drives import BODY

Floats = npt.NDArray[np.float64]
Points = tuple[Floats, Floats]
WINDOW = DynamicWindow(BODY)
FULL = (0.5, 0.0)


def points(*places: tuple[float, float]) -> Points:
    x, y = np.array(places, dtype=np.float64).reshape(-1, 2).T
    return x.copy(), y.copy()


def wall(distance: float, angle: float = 0.0) -> Points:
    """A wall whose nearest point is in this direction [m, rad]."""
    along = np.linspace(-2.0, 2.0, 200)
    return (
        distance * math.cos(angle) - along * math.sin(angle),
        distance * math.sin(angle) + along * math.cos(angle),
    )


def test_in_the_open_the_operator_gets_what_was_wanted() -> None:
    for wanted in ((0.5, 0.0), (-0.5, 0.3), (0.1, -1.0), (0.0, 0.7)):
        assert WINDOW.towards(wanted, wanted, points()) == wanted


def test_a_slow_body_sets_off_and_in_the_open_nothing_holds_it_back() -> None:
    slow = DynamicWindow(dataclasses.replace(BODY, linear_braking=0.2, angular_braking=0.5))
    assert slow.towards((0.0, 0.0), FULL, points()) == FULL
    assert slow.towards((0.0, 0.0), FULL, wall(1.5))[0] >= 0.06
    assert slow.towards((0.0, 0.0), (-0.5, 0.0), wall(1.5))[0] <= -0.06


def test_a_far_wall_takes_nothing_away() -> None:
    assert WINDOW.towards(FULL, FULL, wall(0.8)) == FULL


def test_a_wall_ahead_slows_down_and_then_stops() -> None:
    near = WINDOW.towards(FULL, FULL, wall(0.4))
    assert 0.0 < near[0] < 0.5
    assert WINDOW.towards(FULL, FULL, wall(BODY.radius + BODY.margin)) == (0.0, 0.0)


def test_however_slowly_a_wall_is_not_driven_into() -> None:
    for speed in (0.001, 0.01, 0.019, 0.03):
        close = wall(BODY.radius + BODY.margin)
        assert WINDOW.towards((0.0, 0.0), (speed, 0.0), close) == (0.0, 0.0)


def test_turning_and_backing_off_are_always_possible_before_a_wall() -> None:
    close = wall(BODY.radius + 0.01)
    assert WINDOW.towards((0.0, 0.0), (0.0, 1.0), close) == (0.0, 1.0)
    assert WINDOW.towards((0.0, 0.0), (-0.25, 0.0), close) == (-0.25, 0.0)


def test_a_wall_behind_stops_only_a_robot_that_backs_off() -> None:
    behind = wall(BODY.radius + 0.03, math.pi)
    assert WINDOW.towards((0.0, 0.0), (-0.5, 0.0), behind)[0] == 0.0
    assert WINDOW.towards(FULL, FULL, behind) == FULL


def test_a_wall_beside_does_not_hold_back_a_robot_that_drives_along() -> None:
    assert WINDOW.towards(FULL, FULL, wall(BODY.radius + 0.1, math.pi / 2.0))[0] > 0.4
    slowly = WINDOW.towards((0.1, 0.0), (0.1, 0.0), wall(BODY.radius + 0.02, math.pi / 2.0))
    assert slowly[0] > 0.05


def test_standing_before_a_wall_noise_does_not_make_it_jerk() -> None:
    for distance in np.linspace(-0.005, 0.005, 11) + BODY.radius + BODY.margin:
        assert WINDOW.towards((0.0, 0.0), FULL, wall(float(distance)))[0] == 0.0


def test_a_goal_ahead_is_gone_to_straight_and_one_behind_is_turned_to() -> None:
    linear, angular = WINDOW.to_goal((0.4, 0.0), (0.5, 0.0), 0.5, points())
    assert linear > 0.45
    assert abs(angular) < 0.1
    assert WINDOW.to_goal((0.0, 0.0), (-1.0, -0.1), 0.5, points())[0] == 0.0
    assert WINDOW.to_goal((0.0, 0.0), (-1.0, -0.1), 0.5, points())[1] < 0.0


def test_on_the_way_to_a_goal_an_obstacle_is_driven_around() -> None:
    linear, angular = WINDOW.to_goal((0.3, 0.0), (1.0, 0.0), 0.5, points((0.6, 0.05)))
    assert linear > 0.0
    assert angular < -0.1


@given(
    st.floats(-0.5, 0.5),
    st.floats(-1.0, 1.0),
    st.floats(-0.5, 0.5),
    st.floats(-1.0, 1.0),
    st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), max_size=20),
)
def test_never_faster_never_the_other_way_and_always_able_to_stop(
    speed: float, turn: float, wanted: float, wanted_turn: float, places: list[tuple[float, float]]
) -> None:
    around = points(*places)
    linear, angular = WINDOW.towards((speed, turn), (wanted, wanted_turn), around)
    assert abs(linear) <= abs(wanted)
    assert linear * wanted >= 0.0
    assert abs(angular) <= BODY.angular_limit
    assert stands_clear(BODY, linear, angular, places)


def stands_clear(
    body: BodyLimits,
    linear: float,
    angular: float,
    places: list[tuple[float, float]],
    axis: float = 0.0,
) -> bool:
    """Whether a body that goes on for its reaction time and then brakes touches nothing."""
    x, y = (
        (np.array(part, dtype=np.float64) for part in zip(*places, strict=True))
        if places
        else (
            np.empty(0),
            np.empty(0),
        )
    )
    time = body.reaction + 0.5 * max(
        abs(linear) / body.linear_braking, abs(angular) / body.angular_braking
    )
    if body.outline is None:
        time = body.stopping(abs(linear)) / abs(linear) if linear else 0.0
    apart = beyond(body, x, y) > 0.0
    x, y = x[apart], y[apart]
    for share in np.linspace(0.0, 1.0, 200):
        turn, way = angular * time * share, linear * time * share
        half = axis + turn / 2.0
        chord = way * np.sinc(turn / (2.0 * math.pi))
        pose = Pose(x=chord * math.cos(half), y=chord * math.sin(half), theta=turn)
        if (beyond(body, *pose.inward(x, y)) < -1e-3).any():
            return False
    return True


def beyond(body: BodyLimits, x: Floats, y: Floats) -> Floats:
    """Distances of points from the body's rim [m], shape (n,)."""
    return np.hypot(x, y) - body.radius if body.outline is None else body.outline.distances(x, y)


@st.composite
def bodies(draw: st.DrawFn) -> BodyLimits:
    """Bodies of any shape and strength."""
    count = draw(st.integers(3, 14))
    corners = hull(
        np.array(
            [draw(st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))) for _ in range(count)]
        )
    )
    assume(len(corners) >= 3)
    outline = Sweep(corners)
    return BodyLimits(
        radius=outline.radius,
        margin=draw(st.floats(0.0, 0.1)),
        linear_limit=draw(st.sampled_from((0.5, 0.0))),
        sway_limit=draw(st.sampled_from((0.5, 0.0))),
        angular_limit=draw(st.sampled_from((1.0, 0.0))),
        linear_braking=draw(st.floats(0.5, 3.0)),
        angular_braking=draw(st.floats(1.0, 6.0)),
        outline=outline,
    )


@given(
    bodies(),
    st.floats(-0.5, 0.5),
    st.floats(-1.0, 1.0),
    st.floats(-0.5, 0.5),
    st.floats(-1.0, 1.0),
    st.lists(st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2)), max_size=20),
    st.sampled_from((0.0, 0.5, math.pi / 2.0, -2.0)),
)
def test_a_body_of_any_shape_can_stop_before_it_touches(
    body: BodyLimits,
    speed: float,
    turn: float,
    wanted: float,
    wanted_turn: float,
    places: list[tuple[float, float]],
    axis: float,
) -> None:
    around = points(*places)
    linear, angular = DynamicWindow(body).towards(
        (speed, turn), (wanted, wanted_turn), around, axis=axis
    )
    assert abs(linear) <= abs(wanted)
    assert linear * wanted >= 0.0
    assert abs(angular) <= body.angular_limit
    assert stands_clear(body, linear, angular, places, axis)


def test_a_body_that_turns_faster_than_its_limit_is_commanded_no_more_than_that() -> None:
    straight = DynamicWindow(dataclasses.replace(LONG_BODY, angular_limit=0.0))
    for place in ((0.7, 0.21), (0.6, 0.22), (-0.2, 0.22)):
        for turning in (-2.0, 2.0):
            assert straight.towards((0.0, turning), (0.5, 0.0), points(place))[1] == 0.0


LONG_BODY = BodyLimits(
    radius=0.5,
    margin=0.05,
    linear_limit=0.5,
    sway_limit=0.3,
    angular_limit=1.0,
    linear_braking=2.0,
    angular_braking=4.0,
    outline=Sweep(np.array(((0.45, -0.2), (0.45, 0.2), (-0.45, 0.2), (-0.45, -0.2)))),
)
LONG = DynamicWindow(LONG_BODY)


def corridor(half_width: float) -> Points:
    """Two walls beside the robot [m]."""
    x, left = wall(half_width, math.pi / 2.0)
    return np.concatenate((x, x)), np.concatenate((left, -left))


def test_a_long_body_drives_through_a_corridor_that_its_circle_does_not_fit() -> None:
    narrow = corridor(0.27)
    assert LONG.towards((0.4, 0.0), FULL, narrow)[0] > 0.3
    assert LONG.towards((-0.4, 0.0), (-0.5, 0.0), narrow)[0] < -0.3
    assert LONG.to_goal((0.4, 0.0), (0.5, 0.0), 0.5, narrow)[0] > 0.3
    assert LONG.towards((0.4, 1.0), FULL, narrow)[0] < 0.1, "its ends still swing"
    as_circle = dataclasses.replace(LONG_BODY, outline=None)
    assert DynamicWindow(as_circle).towards((0.0, 0.0), FULL, narrow)[0] == 0.0


def test_in_a_corridor_a_long_body_turns_only_as_far_as_it_can_stop() -> None:
    assert LONG.towards((0.0, 0.0), (0.0, 1.0), corridor(0.22)) == (0.0, 0.0)
    assert 0.0 <= LONG.turn((0.0, 0.0), 1.0, corridor(0.27)) < 0.5
    assert LONG.towards((0.0, 0.9), (0.0, 1.0), corridor(0.55)) == (0.0, 1.0)


def test_sideways_motion_is_held_back_before_a_wall_beside() -> None:
    left = math.pi / 2.0
    towards = LONG.towards((0.2, 0.0), (0.3, 0.0), wall(0.3, left), axis=left)
    assert 0.0 < towards[0] < 0.3
    assert LONG.towards((0.0, 0.0), (0.3, 0.0), wall(0.24, left), axis=left)[0] == 0.0
    assert LONG.towards((0.2, 0.0), (0.3, 0.0), wall(0.24, left), axis=-left) == (0.3, 0.0)
    assert LONG.towards((0.2, 0.0), (0.3, 0.0), wall(0.55), axis=left) == (0.3, 0.0)
    disc = dataclasses.replace(LONG_BODY, radius=0.2, outline=None)
    assert (
        DynamicWindow(disc).towards((0.2, 0.0), (0.3, 0.0), wall(0.24, left), axis=left)[0] == 0.0
    )


def test_what_goes_on_across_the_new_direction_is_kept_room_for() -> None:
    close = wall(0.2 + 0.045, -math.pi / 2.0)
    assert LONG.towards((0.4, 0.0), FULL, close) == FULL
    assert LONG.towards((0.4, 0.0), FULL, close, aside=-0.3)[0] < 0.2
