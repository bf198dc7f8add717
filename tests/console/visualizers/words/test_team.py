"""visualizeTeam: a row for each robot, what is in it, and what goes when room is short."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from hub.gcm.body import Freedom, HoldKind, Motion
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.flight import ALTITUDE, Altitude
from hub.gcm.navigation import MotionState
from hub.gcm.ranges import RANGES
from hub.gcm.recording import RECORD_STATE, RecordState
from hub.gcm.vehicle import VEHICLE_STATE, HoldPhase, HoldState, VehicleState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.visualizers.words.status_words import START_S
from rune_tui.visualizers.words.team_words import does
from tests.console.states import described
from tests.console.visualizers.conftest import NOW, Made, made_by, words
from tests.support.cases import for_each
from tests.support.messages import robot_state

MADE = Made()


def robot(name: str, *, age: float = 0.1, messages: Any = (), **motion: Any) -> RobotState:
    """A robot that stands with a full battery, unless its state says otherwise."""
    known = {definition.name: MADE.received(value, age) for definition, value in messages}
    state = robot_state(**{"battery_fraction": 0.84, "motion": MotionState.STANDING} | motion)
    made = MADE.robot(
        messages=known, navigation=MADE.received(state, age), picture=None, camera=None
    )
    named = {**made.messages, "GCM_RobotDescription": described(name)}
    return made.with_(name=name, messages=named)


def at(depth: float = math.nan, above: float = math.nan) -> tuple[Any, Altitude]:
    return ALTITUDE, Altitude(stamp=0.0, depth=depth, above_ground=above)


def doing(activity: str, *holds: HoldState) -> tuple[Any, VehicleState]:
    return VEHICLE_STATE, VehicleState(activity=activity, holds=holds)


def held(kind: HoldKind, target: float, phase: HoldPhase = HoldPhase.HOLDING) -> HoldState:
    return HoldState(kind=kind, phase=phase, target=target)


OWNED = CONTROL_STATE, ControlState(owner=9, operator="bob", owner_name="console")
TEAM = (
    robot("rover", motion=MotionState.MOVING),
    robot("blimp", messages=[at(above=1.24), OWNED], battery_fraction=0.15),
    robot("rov", messages=[at(depth=2.0)]),
)


def team(*robots: RobotState, **changes: Any) -> ConsoleState:
    robots = robots or TEAM
    inputs = {
        (Purpose.CHOOSE_ROBOT, each.name): str(number) for number, each in enumerate(robots, 1)
    }
    return ConsoleState(
        now=NOW,
        robots={each.name: each for each in robots},
        **{"chosen": robots[0].name, "inputs": inputs} | changes,
    )


def rows(draw: Any, state: ConsoleState, columns: int = 120, height: int = 6) -> list[str]:
    shown = next(iter(state.robots.values()))
    return words(draw("visualizeTeam", shown, (columns, height), state=state))


def test_a_row_has_all_that_an_operator_asks_of_a_robot(draw) -> None:
    state = team(looked={"blimp": NOW - 14.0})
    lines = rows(draw, state, 140)
    assert lines[0].split("  ")[0] == "1"
    assert "▶ rover" in lines[0]
    for said in ("drives", "linked", "84%", "seen now", "all well"):
        assert said in lines[0]
    for said in ("2  ", "bob", "LOW 15%", "height 1.2 m", "seen 14 s ago", "! BATTERY LOW"):
        assert said in lines[1]
    for said in ("3  ", "depth 2.0 m", "not seen yet"):
        assert said in lines[2]
    columns = [line.index("linked") for line in lines]
    assert columns == columns[:1] * 3, "the cells of all rows are aligned"


def test_a_robot_without_the_ranges_that_its_body_has_is_not_well(draw) -> None:
    known = {name: each for name, each in TEAM[0].messages.items() if name != RANGES.name}
    for since, said in ((NOW - 0.9 * START_S, "all well"), (NOW - START_S, "! no ranges")):
        link = dataclasses.replace(TEAM[0].link, since=since)
        mute = TEAM[0].with_(link=link, messages=known)
        assert said in rows(draw, team(mute), 140)[0]


def test_a_robot_that_records_nothing_or_hears_no_console_is_not_well(draw) -> None:
    full = RECORD_STATE, RecordState(fault="the disk is full")
    silent = CONTROL_STATE, ControlState(owner=9, operator="bob", silent_s=1.2)
    for message, said in ((full, "! NOT RECORDED"), (silent, "! bob's console is silent")):
        assert said in rows(draw, team(robot("rover", messages=[message])), 140)[0]


def test_a_robot_that_the_operator_peeks_at_has_its_own_mark(draw) -> None:
    lines = rows(draw, team(peeked="blimp"))
    assert "▶ rover" in lines[0]
    assert "» blimp" in lines[1]
    assert "PEEK" in lines[1]
    assert "seen now" not in lines[0]


@for_each("columns", [120, 100, 80, 60, 40, 30, 20, 12])
def test_narrow_terminals_keep_who_it_is_and_what_is_wrong(draw, columns: int) -> None:
    lines = rows(draw, team(), columns)
    for number, (name, line) in enumerate(zip(("rover", "blimp", "rov"), lines, strict=True), 1):
        assert line.startswith(str(number)) or columns < 30
        assert name in line
    if columns >= 30:
        assert "! B" in lines[1]


def test_what_matters_least_goes_first(draw) -> None:
    gone = [
        next(
            columns for columns in range(140, 10, -1) if said not in rows(draw, team(), columns)[1]
        )
        for said in ("magellan", "linked", "bob", "LOW 15%")
    ]
    assert gone == sorted(gone, reverse=True)


def test_a_robot_that_has_reported_no_problems_yet_is_not_called_well(draw) -> None:
    state = team(*(robot(f"r{number}").with_(diagnostics={}) for number in range(1, 6)))
    lines = rows(draw, state, columns=140, height=6)
    assert "not known yet" in lines[0]
    assert lines[2] == "3 more: not known yet"


def test_with_few_rows_the_chosen_robot_and_the_worst_are_shown(draw) -> None:
    eight = [robot(f"r{number}") for number in range(1, 9)]
    eight[5] = robot("r6", battery_fraction=0.05)
    eight[6] = robot("r7", battery_fraction=0.15)
    state = team(*eight, chosen="r3")
    lines = rows(draw, state, height=6)
    assert ["r3" in lines[0], "r6" in lines[1]] == [True, True]
    assert lines[2] == "6 more: 1 of them with problems"
    assert rows(draw, state, height=8)[3] == "5 more: all well"
    whole = rows(draw, state, height=16)
    assert all(f"r{number}" in line for number, line in enumerate(whole, 1))


def test_one_row_names_all_robots_or_counts_the_others(draw) -> None:
    (line,) = rows(draw, team(), 100, 2)
    assert line == "1▶ rover drives  2  blimp ! BATTERY LOW 15%  3  rov stands"
    (line,) = rows(draw, team(), 50, 2)
    assert line == "1▶ rover  2  blimp ! BATTERY LOW 15%  3  rov"
    (line,) = rows(draw, team(), 40, 2)
    assert line == "1▶ rover  2  blimp !  3  rov"
    (line,) = rows(draw, team(), 24, 2)
    assert line == "1▶ rover  2  blimp !  +1"


@for_each(
    ("said", "messages", "motion"),
    [
        ("stands", [], {}),
        ("drives", [], {"motion": MotionState.MOVING}),
        ("surfaces", [doing("surfaces")], {}),
        (
            "holds 1.2 m 034",
            [
                doing(
                    "holds",
                    held(HoldKind.HEIGHT, 1.23),
                    held(HoldKind.HEADING, math.radians(90.0 - 34.0)),
                )
            ],
            {},
        ),
        ("stands", [doing("drives")], {"linear": 0.01}),
        ("STOPPING", [doing("drives")], {"linear": 0.3}),
        ("brakes", [doing("brakes", held(HoldKind.HEIGHT, 1.0, HoldPhase.READY))], {}),
        ("HOLD FAILS: depth", [doing("holds", held(HoldKind.DEPTH, 2.0, HoldPhase.FAILING))], {}),
        ("STOPPED", [doing("holds")], {"motion": MotionState.STOPPED}),
        ("NO DRIVER", [], {"motion": MotionState.NO_DRIVER}),
    ],
)
def test_what_a_robot_does_is_said_in_few_words(said: str, messages: Any, motion: Any) -> None:
    assert does(robot("r", messages=messages, **motion), NOW).text == said


def test_what_a_silent_robot_does_is_not_known() -> None:
    assert does(robot("r", age=4.0), NOW).text == "?"
    lost = robot("r").with_(link=MADE.link(LinkPhase.LOST))
    assert does(lost, NOW).text == "?"


def test_the_words_of_a_silent_robot_are_not_shown_as_present(draw) -> None:
    old = robot("rover", age=4.2, messages=[at(depth=1.0)])
    (line,) = rows(draw, team(old), 140, 2)
    assert "depth" not in line
    assert "%" not in line
    assert "4.2 s OLD" in line
    assert "!! STATE 4.2 s OLD" in line


@pytest.mark.parametrize(
    ("freedoms", "said"),
    [
        ((), "Space STOP · WASD drive · F1 help · Q quit"),
        ((Freedom.HEAVE,), "Space STOP · WASD drive · R F climb · F1 help · Q quit"),
        (
            (Freedom.HEAVE, Freedom.SWAY),
            "Space STOP · WASD drive · R F climb · Q E sideways · F1 help · Q quit",
        ),
    ],
)
def test_a_legend_has_only_the_keys_of_the_robots_freedoms(draw, freedoms, said) -> None:
    text = "Space STOP · WASD drive · {heave}R F climb · {sway}Q E sideways · F1 help · Q quit"
    shown = robot("r")
    motions = tuple(Motion(freedom=each, limit=0.3, acceleration=1.0) for each in freedoms)
    body = dataclasses.replace(described("r").value, motions=motions, cameras=())
    known = {**shown.messages, "GCM_RobotDescription": MADE.received(body)}
    shown = shown.with_(messages=known)
    label = made_by("visualizeLabel", text=text)
    state = team(shown)
    assert words(draw("visualizeLabel", shown, (120, 2), state=state, text=text))[0] == said
    bare = shown.with_(messages={})
    assert "climb" not in words(draw("visualizeLabel", bare, (120, 2), state=state, text=text))[0]
    assert (label.source(shown, state) == label.source(bare, state)) is (not freedoms)
