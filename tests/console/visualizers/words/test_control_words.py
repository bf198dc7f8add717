"""visualizeControl and its short form in the status line."""

from __future__ import annotations

from typing import Any

from hub.gcm.autonomy import DrivingMode
from hub.gcm.control import CONTROL_STATE, ControlState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import NOW, Made, made_by, words
from tests.support.cases import for_each

ME, BOB = 7, 8
INPUTS = {
    (Purpose.TAKE_CONTROL, "magellan"): "T",
    (Purpose.RELEASE_CONTROL, "magellan"): "C",
    (Purpose.GRANT_CONTROL, "magellan"): "Y",
    (Purpose.DENY_CONTROL, "magellan"): "O",
}
STATE = ConsoleState(now=NOW, inputs=INPUTS)
ASKED: dict[str, Any] = {
    "owner": ME, "operator": "alice", "asker": BOB, "asker_operator": "bob", "left_s": 7.05
}  # fmt: skip
CASES: list[tuple[dict[str, Any], list[str], str]] = [
    ({}, ["nobody has control", "nobody moves the robot", "press T to take it"], "nobody has"),
    (
        {
            "owner": ME,
            "operator": "alice",
            "commander": DrivingMode.OPERATOR,
            "commander_name": "alice",
        },
        ["you have control since 12:03", "alice moves the robot", "press C to give it up"],
        "you have control",
    ),
    (
        {
            "owner": BOB,
            "operator": "bob",
            "commander": DrivingMode.AUTONOMY,
            "commander_name": "autonomy",
        },
        ["bob has control since 12:03", "autonomy moves the robot", "press T to ask"],
        "bob has control",
    ),
    (
        ASKED | {"waiting": 2},
        [
            "you have control since 12:03",
            "bob ASKS FOR CONTROL, 7 s: Y hands it over, O keeps it, 2 more wait",
        ],
        "bob ASKS FOR CONTROL, 7 s: Y hands it over, O keeps it",
    ),
    (
        {"owner": BOB, "operator": "bob", "asker": ME, "asker_operator": "alice", "left_s": 3.05},
        ["bob has control since 12:03", "you ask bob: 3 s", "nobody moves the robot"],
        "you ask bob: 3 s",
    ),
    (
        {"owner": BOB, "operator": "bob", "asker": 9, "asker_operator": "carol", "left_s": 3.05},
        ["bob has control since 12:03", "carol asks bob: 3 s"],
        "carol asks bob: 3 s",
    ),
    (
        {"owner": BOB, "operator": "bob", "silent_s": 1.2},
        ["bob has control since 12:03", "bob's console is silent"],
        "bob's console is silent",
    ),
    (
        {"owner": ME, "operator": "ada", "silent_s": 1.2},
        ["you have control since 12:03", "the hub does not hear you"],
        "the hub does not hear you",
    ),
]


def robot_with(age: float = 0.1, **fields: Any) -> RobotState:
    made = Made()
    state = made.received(ControlState(**fields), age)
    link = made.link(number=ME, owned_since="12:03")
    return made.robot(link=link, messages={CONTROL_STATE.name: state})


@for_each(("fields", "rows", "short"), CASES)
def test_control_is_said_in_words(
    draw: Any, fields: dict[str, Any], rows: list[str], short: str
) -> None:
    robot = robot_with(**fields)
    assert words(draw("visualizeControl", robot, (80, 12), state=STATE))[: len(rows)] == rows
    assert short in words(draw("visualizeStatus", robot, (200, 2), state=STATE))[0]


def test_request_that_is_to_be_answered_here_stands_out_and_comes_first_where_room_is_short(
    draw: Any,
) -> None:
    canvas = draw("visualizeControl", robot_with(**ASKED), (60, 2), state=STATE)
    assert words(canvas) == ["bob ASKS FOR CONTROL, 7 s: Y hands it over, O keeps it  +4"]
    assert tuple(canvas.pixels[0, 59]) == DARK.alarm


def test_time_left_counts_down_between_what_the_hub_says(draw: Any) -> None:
    shown = [
        words(draw("visualizeControl", robot_with(age, **ASKED), (80, 12), state=STATE))[1]
        for age in (0.1, 0.9, 1.1, 9.0)
    ]
    assert [row.split(",")[1].split()[0] for row in shown] == ["7", "7", "6", "0"]


def test_what_is_not_known_is_called_so(draw: Any) -> None:
    made = Made()
    lost = robot_with(owner=BOB, operator="bob").with_(link=made.link(LinkPhase.LOST))
    for robot in (made.robot(), lost):
        assert words(draw("visualizeControl", robot, (80, 2)))[0].endswith("control: not known")
        assert "control" not in words(draw("visualizeStatus", robot, (200, 2)))[0]


def test_the_token_changes_with_what_is_seen_only() -> None:
    control = made_by("visualizeControl")
    first = control.source(robot_with(**ASKED), STATE)
    assert control.source(robot_with(age=0.2, **ASKED), STATE) == first
    assert control.source(robot_with(age=1.2, **ASKED), STATE) != first
    assert control.source(robot_with(age=9.0, owner=BOB), STATE) != control.source(
        robot_with(owner=BOB), STATE
    )
