"""What is true at a freeze, against cases worked out by hand; and which questions are asked."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from hub.pose import Pose
from rune_study.metrics.awareness import AnswerKind
from rune_study.questionnaires.ground import Ground
from rune_study.questionnaires.items import (
    Bearing,
    Choice,
    ComparedItem,
    Item,
    NumberItem,
    PlaceItem,
)
from rune_study.questionnaires.questionnaire import find, read
from rune_study.questionnaires.truths import TRUTHS, Moment, Value, with_moving
from rune_study.session.freezing import choose
from rune_study.trial_data.truth import truth_of, walls_of


def wall(x: float) -> Ground:
    """A wall across the x axis, 20 cm thick, from x on."""
    walls = np.zeros((40, 100), bool)
    walls[:, int(x / 0.1) : int(x / 0.1) + 2] = True
    return Ground(walls=walls, resolution=0.1, origin_y=-2.0)


HERE = Moment(
    pose=Pose(x=2.0, y=1.0, theta=math.pi / 2),
    linear=0.4,
    commanded_angular=-0.5,
    pan=math.radians(-30.0),
    battery=0.83,
    collisions=2,
    marks=((2.0, 4.0), (0.0, 1.0)),
    found=1,
    victims=4,
    time_left=125.0,
    ground=wall(3.0),
)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("position", (2.0, 1.0)),
        ("heading", 90.0),
        ("motion", "forward"),
        ("speed", 0.4),
        ("camera", 330.0),
        ("battery", 83.0),
        ("victims_found", 1.0),
        ("marks", 2.0),
        ("collisions", 2.0),
        ("wall_distance", math.hypot(1.05, 0.05)),
        ("start_direction", 90.0 + math.degrees(math.atan2(1.0, 2.0))),
        ("start_distance", math.hypot(2.0, 1.0)),
        ("mark_direction", 90.0),
        ("victims_left", 3.0),
        ("time_left", 125.0),
        ("next_motion", "right"),
        ("next_position", (2.0, 3.0)),
        ("next_heading", 90.0),
        ("next_collision", "no"),
    ],
)
def test_truths_of_a_moment(name: str, value: Value) -> None:
    assert TRUTHS[name].value(HERE) == (
        value if isinstance(value, str) else pytest.approx(value, abs=1e-9)
    )


def test_the_nearest_wall_is_seen_from_the_robot() -> None:
    direction = TRUTHS["wall_direction"].value(HERE)
    assert isinstance(direction, float)
    assert abs((direction - 270.0 + 180.0) % 360.0 - 180.0) < 4.0


def test_a_robot_on_an_arc_ends_where_its_circle_says() -> None:
    turning = dataclasses.replace(HERE, pose=Pose(), linear=0.5, angular=math.pi / 10.0)
    radius = 0.5 / (math.pi / 10.0)
    assert TRUTHS["next_position"].value(turning) == pytest.approx((radius, radius))
    assert TRUTHS["next_heading"].value(turning) == pytest.approx(90.0)


@pytest.mark.parametrize(("speed", "touches"), [(0.5, "yes"), (0.2, "no"), (-0.5, "no")])
def test_a_wall_ahead_is_touched_within_five_seconds(speed: float, touches: str) -> None:
    moment = dataclasses.replace(HERE, pose=Pose(x=1.0), linear=speed)
    assert TRUTHS["next_collision"].value(moment) == touches


def test_what_is_not_known_has_no_truth() -> None:
    bare = Moment(pose=Pose(x=1.0))
    unknown = {name for name, truth in TRUTHS.items() if truth.value(bare) is None}
    assert unknown == {
        "camera", "battery", "victims_found", "collisions", "wall_direction", "wall_distance",
        "mark_direction", "victims_left", "time_left", "next_collision",
    }  # fmt: skip
    assert TRUTHS["start_direction"].value(Moment(pose=Pose())) is None


def test_robots_that_move_are_counted_over_all() -> None:
    still = Moment(pose=Pose())
    moments = with_moving([HERE, still, None])
    assert [each and each.robots_moving for each in moments] == [1, 1, None]


def test_truths_are_complete_and_of_three_levels() -> None:
    assert {truth.level for truth in TRUTHS.values()} == {1, 2, 3}
    for name, truth in TRUTHS.items():
        assert name == truth.name
        assert (truth.kind is AnswerKind.CHOICE) == bool(truth.words)
        assert truth.unit or truth.kind is AnswerKind.CHOICE


def asked(*items: Item, most: int = 9) -> tuple[list[str], dict[str, Value], dict[str, str]]:
    """Which items are asked, the right answers, and why others are not asked."""
    found, queries, unknown = choose(items, [HERE], {("arena", 1): wall(3.0)}, most)
    return [item.id for item in found], {each.id: each.right for each in queries}, unknown


def test_questions_without_a_truth_now_give_way_to_the_next() -> None:
    blind = dataclasses.replace(HERE, battery=math.nan)
    items = (
        NumberItem(id="charge", text="?", truth="battery"),
        NumberItem(id="plain", text="?"),
        Bearing(id="heading", text="?", truth="heading"),
        PlaceItem(id="own", text="?", truth="position", ground="robot"),
        NumberItem(id="bumps", text="?", truth="collisions"),
    )
    found, queries, unknown = choose(items, [blind], {}, 2)
    assert [item.id for item in found] == ["plain", "heading"]
    assert [each.id for each in queries] == ["heading"]
    assert unknown == {"charge": "battery is not known"}
    assert asked(*items)[2] == {"own": "there is no ground to show"}


def test_the_right_option_follows_from_the_truth() -> None:
    options = ("it stood", "it drove", "it turned")
    means = ("stands", "forward backward", "left right")
    item = Choice(id="a", text="?", truth="motion", options=options, means=means)
    assert item.fault() is None
    assert asked(item)[1] == {"a": "it drove"}


def test_all_questions_of_the_shipped_file_can_be_asked() -> None:
    items = read(find("sagat")).items
    assert len(asked(*items, most=99)[0]) == len(items)
    levels = {TRUTHS[item.truth].level for item in items if isinstance(item, ComparedItem)}
    assert levels == {1, 2, 3}


def test_the_ground_that_people_see_has_no_victims() -> None:
    truth = truth_of("yellow")
    bare = walls_of("yellow").blocked
    assert truth.grid.blocked.shape == bare.shape
    assert not (bare & ~truth.grid.blocked).any()
    for x, y in truth.victims.tolist():
        row, column = (int(each) for each in truth.grid.cells(x, y))
        assert truth.grid.blocked[row, column]
        assert not bare[row, column]
