"""The window takes away what would lead into something, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from hypothesis import given
from hypothesis import strategies as st

from hub.modules.navigation.dynamic_window import DynamicWindow
from tests.hub.modules.navigation.drives import BODY

Points = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
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


def test_a_wall_behind_stops_only_who_backs_off() -> None:
    behind = wall(BODY.radius + 0.03, math.pi)
    assert WINDOW.towards((0.0, 0.0), (-0.5, 0.0), behind)[0] == 0.0
    assert WINDOW.towards(FULL, FULL, behind) == FULL


def test_a_wall_beside_does_not_hold_back_who_drives_along() -> None:
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
    if linear:
        chosen = np.array([linear]), np.array([angular])
        assert WINDOW.admissible(*chosen, around).all()
