"""visualizeAutonomy and its short form in the status line: what the robot does by itself."""

from __future__ import annotations

import math
from typing import Any

from hub.gcm.autonomy import AUTONOMY_STATE, Behaviour, Phase
from hub.gcm.navigation import (
    NAVIGATION_STATUS,
    Cause,
    MotionState,
    NavigationStatus,
    Task,
)
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.robot_task import task_of
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.task_words import OTHERS_S, SHOWN_S, SILENT_S
from rune_tui.visualizers.words.status_words import status_parts
from tests.console.visualizers import known
from tests.console.visualizers.conftest import NOW, Made, made_by, received, words
from tests.support.cases import for_each
from tests.support.messages import robot_state

NAN = math.nan
STATE = ConsoleState(now=NOW)


def navigation(**changes: Any) -> NavigationStatus:
    values: dict[str, Any] = {
        "number": 3,
        "task": Task.GOING,
        "sender": 9,
        "driver": 0,
        "points_left": 1,
        "distance_left": 3.14,
        "why": "",
        "path": (),
        "x": 2.0,
        "y": 1.0,
        "seconds": 12.0,
    }
    return NavigationStatus(**values | changes)


def robot(
    autonomy: dict[str, Any] | None = None,
    status: dict[str, Any] | None = None,
    *,
    age: float = 0.1,
    motion: MotionState = MotionState.GOING,
) -> RobotState:
    messages = {}
    if autonomy is not None:
        messages[AUTONOMY_STATE.name] = received(known.autonomy(**autonomy), age)
    if status is not None:
        messages[NAVIGATION_STATUS.name] = received(navigation(**status), age)
    return Made().robot(navigation=received(robot_state(motion=motion)), messages=messages)


def said(robot: RobotState) -> list[Part]:
    """What the status line says of motion."""
    parts = list(status_parts(robot, STATE))
    words = ("EXPL", "GOING", "WAITS", "RETURN", "STAND", "TURN", "STOPPED", "WANDER")
    return [part for part in parts if part.text.startswith(words)]


IDLE = {"task": Task.NONE, "why": "", "x": NAN, "y": NAN}
UNDER_WAY = [
    ({"autonomy": {}}, "EXPLORING 42 %"),
    ({"autonomy": {}, "status": {"sender": 5}}, "EXPLORING 42 %"),
    ({"status": {}}, "GOING 3.1 m"),
    ({"status": {"task": Task.TURNING, "x": NAN, "distance_left": NAN}}, "TURNING"),
    (
        {"autonomy": {"asked": Behaviour.RETURN, "explored": NAN, "distance_m": 2.0}},
        "RETURNING 2.0 m",
    ),
    (
        {"autonomy": {"phase": Phase.WAITING, "why": "waits: the map is old"}},
        "EXPLORING 42 %, WAITS: the map is old",
    ),
    (
        {"status": {"cause": Cause.BUSY, "why": "waits: navigation is too busy to steer"}},
        "GOING 3.1 m, WAITS: navigation is too busy to steer",
    ),
    ({}, "GOING by itself"),
]


@for_each(("what", "text"), UNDER_WAY)
def test_the_status_line_says_what_it_does_and_how_far(what: dict[str, Any], text: str) -> None:
    assert [part.text for part in said(robot(**what))] == [text]


ENDED = [
    ({"autonomy": {"phase": Phase.DONE, "why": "explored: nothing is left", "explored": 1.0}},
     "EXPLORING 100 % DONE: explored: nothing is left", Severity.GOOD),
    ({"status": {"task": Task.REACHED, "why": "it is there"}},
     "GOING DONE: it is there", Severity.GOOD),
    ({"status": {"task": Task.BLOCKED, "why": "the map shows no way there"}},
     "GOING BLOCKED: the map shows no way there", Severity.WARNING),
    ({"status": {"task": Task.CANCELLED, "cause": Cause.STOP, "why": "stopped: lunch"}},
     "GOING STOPPED: lunch", Severity.PLAIN),
    ({"autonomy": {"phase": Phase.TAKEN_OVER, "why": "the operator took over"}},
     "EXPLORING 42 % ENDED: the operator took over", Severity.PLAIN),
    ({"autonomy": {"phase": Phase.LOST, "why": "gave up after 60 s: the map is old"}},
     "EXPLORING 42 % GIVEN UP: gave up after 60 s: the map is old", Severity.WARNING),
]  # fmt: skip


@for_each(("what", "text", "severity"), ENDED)
def test_the_status_line_says_for_a_while_how_it_ended(
    what: dict[str, Any], text: str, severity: Severity
) -> None:
    for parts in what.values():
        parts["ended_s"] = 1.0
    robot_now = robot(**what, motion=MotionState.STANDING)
    motion, outcome = said(robot_now)
    assert (motion.text, outcome.text, outcome.severity) == ("STANDING", text, severity)
    for parts in what.values():
        parts["ended_s"] = max(OTHERS_S, *SHOWN_S.values())
    assert len(said(robot(**what, motion=MotionState.STANDING))) == 1


def test_what_was_not_heard_of_for_a_while_is_not_taken_for_true() -> None:
    (part,) = said(robot({}, age=SILENT_S + 2.0))
    assert (part.text, part.severity) == ("EXPLORING 42 %, NOT HEARD FOR 5 s", Severity.WARNING)


def test_what_goes_on_comes_before_what_has_ended() -> None:
    (part,) = said(robot({"phase": Phase.DONE, "ended_s": 1.0}, {}))
    assert part.text == "GOING 3.1 m"


def test_the_pane_says_all_of_it(draw: Any) -> None:
    assert words(draw("visualizeAutonomy", robot({}), (60, 12), state=STATE)) == [
        "EXPLORING 42 %",
        "explores: a frontier of 2.1 m, 4.7 m away",
        "to 3.1, -0.5 m, 4.7 m to go",
        "12.3 m of the map's edge are left to explore",
        "for 2 min 31 s",
        "",
    ]
    ended = {"phase": Phase.BLOCKED, "why": "no way", "x": NAN, "ended_s": 44.0, "seconds": 7.0}
    assert words(draw("visualizeAutonomy", robot(ended), (60, 6), state=STATE)) == [
        "EXPLORING 42 % BLOCKED",
        "no way",
        "took 7 s, ended 44 s ago",
    ]
    for task, said in (
        (robot(), "not known: the robot reports no tasks"),
        (robot(status=IDLE), "nothing yet: the robot has done nothing by itself"),
        (robot(status=IDLE, age=9.0), "STALE 9.0 s"),
    ):
        assert said in " ".join(words(draw("visualizeAutonomy", task, (60, 3), state=STATE)))
    unknown = {"phase": Phase.DONE, "seconds": NAN, "ended_s": 44.0}
    text = words(draw("visualizeAutonomy", robot(unknown), (60, 6), state=STATE))
    assert "took ?, ended 44 s ago" in text


def test_the_pane_changes_with_its_words_and_its_age() -> None:
    pane = made_by("visualizeAutonomy")
    before = pane.source(robot({}), STATE)
    assert pane.source(robot({}), STATE) == before
    assert pane.source(robot({"distance_m": 4.0}), STATE) != before
    assert pane.source(robot({}, age=60.0), STATE) != before


def test_of_two_that_ended_the_later_one_is_shown_however_long_ago_it_came() -> None:
    ended = {
        AUTONOMY_STATE.name: received(known.autonomy(phase=Phase.DONE, ended_s=1.0), 60.0),
        NAVIGATION_STATUS.name: received(navigation(task=Task.REACHED, ended_s=5.0), 0.1),
    }
    task = task_of(Made().robot(messages=ended))
    assert task is not None
    assert task.kind == "going"
