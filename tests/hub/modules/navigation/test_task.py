"""A task ends when it is done, when it comes no nearer, or when it is ended."""

from __future__ import annotations

import math

import pytest

from hub.gcm.navigation import Cause, GoalCommand, Point, Task, TurnCommand
from hub.modules.navigation.task import (
    BLOCKED_S,
    CLOSELY,
    CLOSELY_S,
    LONGEST_HOLD_S,
    MENTION_S,
    MOST_DETOURS,
    MOST_PATIENCE_S,
    MOST_POINTS,
    MOST_ROUNDS,
    OCCUPIED,
    PATIENCE_S,
    NavigationTask,
    refusal,
)
from hub.pose import Pose


def goal(
    *places: tuple[float, float], theta: float = math.nan, patience: float = 0.01
) -> GoalCommand:
    points = tuple(Point(x=x, y=y) for x, y in places)
    return GoalCommand(points=points, theta=theta, patience=patience)


def going(
    *places: tuple[float, float], theta: float = math.nan, patience: float = 0.01
) -> NavigationTask:
    task = NavigationTask()
    task.go(goal(*places, theta=theta, patience=patience), 7, 0.0)
    return task


def test_it_heads_for_the_point_and_reaches_it() -> None:
    task = going((2.0, 0.0))
    aim = task.aim(Pose(), 0.1)
    assert aim is not None
    assert (aim.x, aim.y, aim.left) == (2.0, 0.0, 2.0)
    assert task.state is Task.GOING
    assert task.aim(Pose(x=1.95), 0.2) is None
    assert task.state is Task.REACHED


def test_points_are_passed_in_their_order() -> None:
    task = going((1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    assert task.aim(Pose(x=0.9), 0.1) is not None
    assert len(task.points) == 2
    assert task.distance_left == pytest.approx(math.hypot(0.1, 1.0) + 1.0)


def test_the_heading_at_the_end_is_turned_to() -> None:
    task = going((1.0, 0.0), theta=1.0)
    aim = task.aim(Pose(x=1.0), 0.1)
    assert aim is not None
    assert aim.turn == pytest.approx(1.0)
    # Turning may move it a little; it does not go back to the point for that.
    assert task.aim(Pose(x=1.15, theta=0.5), 0.2) is not None
    assert task.aim(Pose(x=1.15, theta=1.0), 0.3) is None
    assert task.state is Task.REACHED


def test_it_is_blocked_without_headway() -> None:
    task = going((2.0, 0.0))
    task.aim(Pose(), 0.0)
    assert task.aim(Pose(x=0.02), BLOCKED_S - 0.1) is not None
    assert task.aim(Pose(x=0.04), BLOCKED_S + 0.1) is None
    assert task.state is Task.BLOCKED
    assert (task.why, task.cause) == ("it comes no nearer", Cause.CLOSED)
    assert task.place == (2.0, 0.0)
    assert task.seconds(99.0) == BLOCKED_S + 0.1


def test_a_driver_that_does_not_follow_is_no_obstacle() -> None:
    """An autopilot is disarmed, or in a mode of another."""
    task = going((5.0, 0.0), patience=60.0)
    task.aim(Pose(), 0.1)
    task.followed(by_driver=False)
    task.aim(Pose(), MENTION_S + 1.0)
    assert task.why.startswith("waits: the driver does not follow")
    assert task.cause is Cause.DRIVER
    task.followed(by_driver=True)
    task.aim(Pose(), MENTION_S + 2.0)
    assert task.why == "waits: something is in the way"


def test_it_waits_for_a_person_in_the_way_and_says_so_and_goes_on() -> None:
    task = going((2.0, 0.0), patience=math.nan)
    task.aim(Pose(), 0.0)
    assert task.aim(Pose(), MENTION_S + 0.1) is not None
    assert (task.state, task.cause) == (Task.GOING, Cause.CLOSED)
    assert task.why == "waits: something is in the way"
    assert task.aim(Pose(), PATIENCE_S - 0.1) is not None
    assert task.aim(Pose(x=0.2), PATIENCE_S) is not None
    assert (task.why, task.cause) == ("", Cause.NONE)
    assert task.aim(Pose(x=0.2), 2.0 * PATIENCE_S - 0.1) is not None
    assert task.aim(Pose(x=0.2), 2.0 * PATIENCE_S + 0.1) is None
    assert task.state is Task.BLOCKED


def test_nobody_waits_for_ever() -> None:
    for patience, most in ((0.0, PATIENCE_S), (1e9, MOST_PATIENCE_S), (math.inf, MOST_PATIENCE_S)):
        task = going((2.0, 0.0), patience=patience)
        task.aim(Pose(), 0.0)
        assert task.aim(Pose(), most - 0.1) is not None
        assert task.aim(Pose(), most + 0.1) is None


def test_it_stands_where_the_map_shows_no_way_and_goes_on_when_it_does() -> None:
    task = going((2.0, 0.0), patience=20.0)
    task.aim(Pose(), 0.0)
    task.planned(None, "the map shows no way there")
    aim = task.aim(Pose(), 1.0)
    assert aim is not None
    assert aim.stay
    assert task.why == "waits: the map shows no way there"
    task.planned(((0.0, 0.0), (2.0, 0.0)))
    aim = task.aim(Pose(), 2.0)
    assert aim is not None
    assert not aim.stay
    assert task.why == ""
    task.planned(None, "the map shows no way there")
    assert task.aim(Pose(), 20.1) is None
    assert (task.state, task.why) == (Task.BLOCKED, "the map shows no way there")


def test_headway_on_a_longer_way_is_headway_but_not_for_ever() -> None:
    task = going((9.0, 0.0))
    task.planned(((0.0, 0.0), (9.0, 0.0)))
    now, length = 0.0, 9.0
    for _ in range(MOST_DETOURS):
        assert task.aim(Pose(), now) is not None
        length += 5.0
        task.planned(((0.0, 0.0), (9.0 - length, 0.0), (9.0, 0.0)))
        now += BLOCKED_S - 1.0
        assert task.aim(Pose(x=-0.5), now) is not None, "it has gone half a metre of it"
        now += 1.5
    while task.state is Task.GOING and now < 1000.0:
        length += 5.0
        task.planned(((0.0, 0.0), (9.0 - length, 0.0), (9.0, 0.0)))
        task.aim(Pose(), now)
        now += 1.0
    assert task.state is Task.BLOCKED


def test_held_wheels_are_no_lack_of_headway_but_not_for_ever() -> None:
    task = going((2.0, 0.0))
    task.aim(Pose(), 0.0)
    now = 0.0
    while now < LONGEST_HOLD_S - 1.0:
        now += 0.5
        task.hold(Cause.BUSY, "too busy", now)
    assert (task.state, task.cause, task.why) == (Task.GOING, Cause.BUSY, "waits: too busy")
    assert task.aim(Pose(), now + 1.0) is not None
    assert (task.cause, task.why) == (Cause.NONE, "")
    for _ in range(5):
        now += 0.5
        task.hold(Cause.BUSY, "too busy", now)
    assert (task.state, task.cause) == (Task.CANCELLED, Cause.BUSY)
    assert task.why == "gave up after 60 s: too busy"


def test_headway_between_two_holds_begins_a_new_minute() -> None:
    task = going((9.0, 0.0))
    task.aim(Pose(), 0.0)
    now = 0.0
    for part in range(1, 4):
        for _ in range(100):
            now += 0.5
            task.hold(Cause.DRIVER, "silent", now)
        assert task.aim(Pose(x=float(part)), now) is not None
    assert task.state is Task.GOING


def test_a_goal_that_is_not_begun_says_so_and_disturbs_nothing() -> None:
    task = NavigationTask()
    task.refuse(goal((2.0, 0.0)), 7, "somebody drives", Cause.STICK, 1.0)
    assert (task.number, task.state, task.sender) == (1, Task.CANCELLED, 7)
    assert (task.why, task.cause) == ("not begun: somebody drives", Cause.STICK)
    assert task.seconds(9.0) == 0.0
    task.go(goal((1.0, 0.0)), 7, 2.0)
    task.refuse(goal((2.0, 0.0)), 8, "somebody drives", Cause.STICK, 3.0)
    assert (task.number, task.state, task.place) == (2, Task.GOING, (1.0, 0.0))


def test_with_headway_it_is_not_blocked() -> None:
    task = going((20.0, 0.0))
    for second in range(60):
        assert task.aim(Pose(x=0.2 * second), float(second)) is not None


def test_a_way_round_something_new_counts_anew_but_not_for_ever() -> None:
    task = going((2.0, 0.0))
    task.aim(Pose(), 0.0)
    for number in range(1, MOST_ROUNDS + 1):
        now = number * (BLOCKED_S - 1.0)
        task.goes_round(Pose(), now)
        assert task.aim(Pose(), now + 0.5) is not None
    task.goes_round(Pose(), now + BLOCKED_S - 1.0)
    assert task.aim(Pose(), now + BLOCKED_S + 1.0) is None
    assert task.state is Task.BLOCKED


def test_a_goal_without_patience_does_not_wait_where_something_stands() -> None:
    task = going((2.0, 0.0))
    task.goes_round(Pose(x=2.0 - 0.9 * OCCUPIED), 1.0)
    assert (task.state, task.cause) == (Task.BLOCKED, Cause.OCCUPIED)


def test_a_goal_with_patience_waits_until_the_place_is_free() -> None:
    task = going((2.0, 0.0), patience=20.0)
    here = Pose(x=2.0 - 0.9 * OCCUPIED)
    task.aim(here, 1.0)
    task.goes_round(here, 2.0)
    assert task.aim(here, 10.0) is not None
    assert task.why == "waits: something stands there"
    assert task.aim(here, 21.1) is None
    assert (task.state, task.cause) == (Task.BLOCKED, Cause.OCCUPIED)


def test_after_a_blockage_the_robot_follows_its_way_closely() -> None:
    task = going((2.0, 0.0))
    task.planned(((0.0, 0.0), (2.0, 0.0)))
    task.goes_round(Pose(), 1.0)
    aim = task.aim(Pose(), 1.1)
    assert aim is not None
    assert aim.x == pytest.approx(CLOSELY)
    aim = task.aim(Pose(), 1.1 + CLOSELY_S)
    assert aim is not None
    assert aim.x > CLOSELY + 0.1


def test_more_than_a_whole_turn_is_turned() -> None:
    task = NavigationTask()
    task.turn(TurnCommand(angle=7.0), 7, Pose(), 0.0)
    turned, now = 0.0, 0.0
    while task.aim(Pose(theta=math.remainder(turned, 2.0 * math.pi)), now) is not None:
        turned, now = turned + 0.05, now + 0.05
    assert task.state is Task.REACHED
    assert turned == pytest.approx(7.0, abs=0.1)


def test_no_points_end_it_and_every_task_has_its_number() -> None:
    task = going((2.0, 0.0))
    task.go(goal(), 8, 1.0)
    assert task.state is Task.CANCELLED
    assert task.number == 1
    task.go(goal((1.0, 0.0)), 8, 1.0)
    assert (task.number, task.sender) == (2, 8)


def test_what_has_ended_stays_as_it_ended() -> None:
    task = going((2.0, 0.0))
    task.aim(Pose(x=2.0), 0.1)
    task.end(Task.CANCELLED, "too late", Cause.STOP, 1.0)
    assert task.cause is Cause.NONE
    assert task.state is Task.REACHED


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1e30])
def test_goals_that_are_nowhere_are_refused(wrong: float) -> None:
    assert refusal(goal((0.0, wrong)))
    assert refusal(goal((1.0, 1.0), (wrong, 0.0)))
    assert not refusal(goal((1.0, 1.0)))


def test_too_many_points_are_refused() -> None:
    assert refusal(goal(*[(0.0, 0.0)] * (MOST_POINTS + 1)))
