"""All visualizers together."""

from __future__ import annotations

import itertools

from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.mapping import INTEREST_POINTS
from hub.gcm.navigation import ROBOT_STATE, STOP
from hub.gcm.supervision import MODULE_REPORTS
from rune_tui.model.robot_state import LinkPhase
from rune_tui.visualizers.parts.staleness import Staleness, age_text, pause_of, staleness
from rune_tui.visualizers.registry import VISUALIZERS
from tests.console.states import visualizer_spec
from tests.console.visualizers.known import everything
from tests.support.cases import for_each


def test_every_name_makes_its_visualizer() -> None:
    for name, kind in VISUALIZERS.items():
        assert isinstance(kind.from_spec(visualizer_spec(name)), kind)


SIZES = ((1, 1), (1, 2), (2, 1), (3, 5), (20, 7), (40, 2), (2, 40), (120, 40))


@for_each("name", sorted(VISUALIZERS))
def test_every_visualizer_draws_on_any_canvas_with_and_without_data(made, draw, name) -> None:
    text = {"text": "words"} if VISUALIZERS[name].rule.text else {}
    known = {definition.name: made.received(v) for definition, v in everything().items()}
    robots = [made.robot(messages=known, link=made.link(phase)) for phase in LinkPhase]
    robots.append(made.robot(picture=None, navigation=None, camera=None))
    for robot, size in itertools.product(robots, SIZES):
        draw(name, robot, size, **text)


@for_each(
    ("age", "expected"),
    [
        (0.0, Staleness.FRESH),
        (1.0, Staleness.FRESH),
        (1.1, Staleness.OLD),
        (3.0, Staleness.OLD),
        (3.1, Staleness.STALE),
    ],
)
def test_the_steps_of_age_are_one_and_three_seconds(age: float, expected: Staleness) -> None:
    assert staleness(age) is expected


def test_only_what_comes_once_a_second_or_less_may_pause() -> None:
    definitions = (ROBOT_STATE, STOP, MODULE_REPORTS, INTEREST_POINTS)
    assert [pause_of(definition) for definition in definitions] == [0.0, 0.0, 1.0, 5.0]


@for_each(
    ("age", "text"),
    [
        (0.0, "0.0 s"),
        (4.29, "4.2 s"),
        (9.99, "9.9 s"),
        (37.9, "37 s"),
        (180, "3 min"),
        (9e3, "2 h"),
    ],
)
def test_an_age_is_told_as_precisely_as_helps(age: float, text: str) -> None:
    assert age_text(age) == text


@example(7199.0)
@given(st.floats(0, 1e7))
def test_an_age_is_always_short(age: float) -> None:
    assert len(age_text(age)) <= len("119 min")
