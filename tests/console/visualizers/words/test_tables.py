"""visualizeMarks, visualizeModules, visualizeCapabilities: lists that a robot sends."""

from __future__ import annotations

import math
import time
from typing import Any

import pytest

from hub.gcm.mapping import INTEREST_POINTS, PointKind
from hub.gcm.supervision import CAPABILITY_REPORTS, MODULE_REPORTS, CapabilityPhase, ModulePhase
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK
from tests.console.states import ABSENT, BROKEN, COMING
from tests.console.visualizers.conftest import made_by, words
from tests.console.visualizers.known import (
    capabilities,
    capability,
    module,
    modules,
    point,
    points,
)

LISTS: dict[str, tuple[Any, Any, str]] = {
    "visualizeMarks": (INTEREST_POINTS, points(point(1)), "list of marks"),
    "visualizeModules": (MODULE_REPORTS, modules(module("driver")), "module list"),
    "visualizeCapabilities": (
        CAPABILITY_REPORTS,
        capabilities(capability("NAV_MOVE")),
        "capability list",
    ),
}


@pytest.fixture
def listed(made, draw):
    """The rows of a list of this message."""

    def rows(name, value, size=(90, 20), *, age=0.1, lacking=None) -> list[str]:
        robot = made.robot(
            messages={LISTS[name][0].name: made.received(value, age)},
            link=made.link(lacking=lacking or {}),
        )
        return [row for row in words(draw(name, robot, size)) if row]

    return rows


@pytest.mark.parametrize("name", LISTS)
def test_a_list_that_never_came_is_named(made, draw, name) -> None:
    text = words(draw(name, made.robot(), (50, 2)))[0].strip()
    assert text == f"no {LISTS[name][2]} from magellan"


@pytest.mark.parametrize(("name", "pause"), [("visualizeMarks", 5.0), ("visualizeModules", 1.0)])
def test_a_list_is_old_only_when_the_next_is_overdue(made, draw, name, pause) -> None:
    definition, value, _ = LISTS[name]

    def ink(age: float) -> int:
        robot = made.robot(messages={definition.name: made.received(value, age)})
        return int(draw(name, robot, (60, 12)).ink.sum())

    assert ink(0.0) == ink(pause + 0.9) > ink(pause + 1.1)


@pytest.mark.parametrize("name", LISTS)
def test_a_stale_list_says_its_age(listed, name) -> None:
    assert "STALE 30 s" in listed(name, LISTS[name][1], age=30.0)[0]


@pytest.mark.parametrize("name", LISTS)
def test_a_lists_token_changes_with_its_rows_and_their_age_only(made, name) -> None:
    definition, value, _ = LISTS[name]
    shown, state = made_by(name), ConsoleState(now=made.now)

    def token(value, age=0.1, number=1):
        received = made.received(value, age, number)
        return shown.source(made.robot(messages={definition.name: received}), state)

    empty = {"visualizeMarks": points(), "visualizeModules": modules()}
    assert token(value) == token(value, 0.5, 2)
    assert token(value) != token(empty.get(name, capabilities()))
    assert token(value, 0.9) == token(value, 1.1) != token(value, 30.0)


def test_marks_are_listed_newest_first_with_all_that_is_known_of_them(listed) -> None:
    stamp = 1_700_000_000.0
    clock = time.strftime("%H:%M:%S", time.localtime(stamp))
    sure = {"uncertainty": 0.125, "distance": 2.5}
    first = point(1, stamp=stamp, note="under the table", **sure)
    assert listed("visualizeMarks", points(first, point(12, PointKind.LANDMARK)), (100, 8)) == [
        "1 victim, 1 landmark",
        "12  landmark  2.30, -1.10                                 anna",
        f" 1  victim    2.30, -1.10  ±0.12 m  from 2.5 m  {clock}  anna  under the table",
    ]


def test_marks_keep_how_far_off_they_may_be_where_room_is_short_and_words_longer(listed) -> None:
    sure = {"uncertainty": 0.125, "distance": 2.5}
    bare, worded = point(1, **sure), point(1, note="under the table", **sure)
    assert listed("visualizeMarks", points(bare), (36, 8))[1:] == [
        " 1 V  2.30, -1.10  ±0.12 m  anna"
    ]
    assert listed("visualizeMarks", points(worded), (36, 8))[1:] == [
        " 1 V  2.30, -1.10  under the table"
    ]


def test_marks_keep_number_kind_and_place_on_twenty_columns(listed) -> None:
    value = points(point(1, note="under the table"), point(12, PointKind.LANDMARK))
    rows = ["1 victim, 1 landmark", "12 L  2.30, -1.10", " 1 V  2.30, -1.10"]
    assert listed("visualizeMarks", value, (20, 8)) == rows
    assert listed("visualizeMarks", value, (20, 2)) == ["12 L  2.30, -1.10 +1"]
    assert listed("visualizeMarks", value, (10, 8))[0] == "1 v, 1 l"


def test_no_mark_yet_is_told_from_no_list(listed) -> None:
    assert listed("visualizeMarks", points()) == ["nothing marked yet"]


def test_modules_have_a_row_each_and_trouble_in_capitals(listed) -> None:
    value = modules(
        module("driver"),
        module("vision", ModulePhase.FAILED, why="it ended too often", processor=math.nan),
    )
    assert listed("visualizeModules", value) == [
        "module  phase    starts  cpu  memory  why",
        "driver  running  1       3%   42 MB   wanted by rune",
        "vision  FAILED   1            42 MB   it ended too often",
    ]


def test_where_room_is_short_the_reason_stands_below_a_module_in_trouble(listed) -> None:
    value = modules(
        module("navigation"), module("vision", ModulePhase.FAILED, why="it ended too often")
    )
    assert listed("visualizeModules", value, (20, 12)) == [
        "module      phase",
        "navigation  running",
        "vision      FAILED",
        "  it ended too often",
    ]


def test_capabilities_that_are_wanted_come_first_and_of_these_the_missing(listed) -> None:
    value = capabilities(
        capability("AUT_PILOT", CapabilityPhase.AVAILABLE, "autonomy"),
        capability("NAV_MOVE", module="navigation", wanted="rune"),
        capability("VIS_VID", CapabilityPhase.UNAVAILABLE, "vision", wanted="rune"),
        capability("PRO_MAP", CapabilityPhase.STARTING, "mapping", wanted="rune"),
    )
    assert listed("visualizeCapabilities", value) == [
        "VIS_VID    MISSING   for rune  cannot start vision",
        "PRO_MAP    starting  for rune  mapping",
        "NAV_MOVE   runs      for rune  navigation",
        "AUT_PILOT  idle                autonomy",
    ]


def test_a_capability_that_the_layout_wants_and_no_module_has_is_listed(listed) -> None:
    value = capabilities(capability("NAV_MOVE", module="navigation", wanted="rune"))
    lacking = {"VIS_NIGHT": ABSENT, "NAV_GOAL": BROKEN, "NAV_MOVE": COMING}
    assert listed("visualizeCapabilities", value, (30, 12), lacking=lacking) == [
        "NAV_GOAL   MISSING",
        "  its modules cannot be",
        "  started",
        "VIS_NIGHT  none",
        "NAV_MOVE   runs",
    ]


def test_what_consoles_provide_is_not_called_missing(listed) -> None:
    value = capabilities(capability("CON_REAL", CapabilityPhase.UNAVAILABLE, wanted="rune"))
    assert listed("visualizeCapabilities", value) == ["the robot can do nothing"]


@pytest.mark.parametrize(
    ("width", "head"), [(90, "1 NOT KEPT, 2 victims"), (18, "1 NOT KEPT, 2 v")]
)
def test_a_mark_that_is_not_on_the_robots_disk_is_a_caution(made, draw, width, head) -> None:
    marks = made.received(points(point(1), point(2, kept=0)))
    canvas = draw("visualizeMarks", made.robot(messages={INTEREST_POINTS.name: marks}), (width, 8))
    rows = words(canvas)
    assert rows[0] == head
    sign = "NOT KEPT" if width == 90 else " 2 V!"
    assert [sign in row for row in rows[1:3]] == [True, False]
    inks = [tuple(canvas.ink[row, 1].tolist()) for row in range(3)]
    assert [ink == DARK.warning for ink in inks] == [True, True, False]


def test_what_the_body_has_no_parts_for_comes_last_and_is_no_alarm(made, draw) -> None:
    value = capabilities(
        capability("DRV_ARM", CapabilityPhase.UNAVAILABLE, wanted="rune"),
        capability("VIS_VID", CapabilityPhase.UNAVAILABLE, wanted="rune"),
        capability("NAV_MOVE", wanted="rune"),
    )
    messages = {CAPABILITY_REPORTS.name: made.received(value)}
    canvas = draw("visualizeCapabilities", made.robot(messages=messages), (70, 8))
    rows = words(canvas)
    assert [row.split()[0] for row in rows[:3]] == ["VIS_VID", "NAV_MOVE", "DRV_ARM"]
    assert "this body has no parts for it" in rows[2]
    assert tuple(canvas.ink[2, 0].tolist()) == DARK.faint
