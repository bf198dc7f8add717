"""The mission on a console: its key, its pane, what is told of it, what speaks against leaving."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest

from hub.gcm.mission import MISSION_STATE, MissionAction, MissionState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, MissionEffect, Notify
from rune_tui.model.leaving import reasons_to_stay
from rune_tui.model.mission import MissionWatch
from rune_tui.model.robot_state import Lack, LackKind
from rune_tui.visualizers.words.mission import mission_rows
from rune_tui.visualizers.words.troubles import troubles
from rune_tui.widgets.mission import WAIT_S
from tests.console.visualizers.conftest import received
from tests.console.widgets.presses import down, event_spec, seeing, widget_of

RUNS = MissionState(
    id="20261122-150000", name="cellar", running=1, begun=1e9, running_s=200.0, marks=3,
    map_age_s=4.0,
)  # fmt: skip
FULL = dataclasses.replace(RUNS, unkept=2, fault="the disk is full")
KEY = event_spec("m")


def on(mission: MissionState | None, **changes: Any) -> ConsoleState:
    state = seeing()
    if mission is not None:
        robot = state.robots["magellan"]
        told = {**robot.messages, MISSION_STATE.name: received(mission)}
        state = dataclasses.replace(state, robots={"magellan": robot.with_(messages=told)})
    return dataclasses.replace(state, **changes)


def asked(do: str, mission: MissionState | None, **changes: Any) -> AskEffect:
    (effect,) = widget_of("widgetMission", do=do).handle(down("m"), KEY, on(mission, **changes))
    assert isinstance(effect, AskEffect)
    return effect


def wanted(effects: tuple[Effect, ...]) -> tuple[MissionAction, str]:
    (effect,) = effects
    assert isinstance(effect, MissionEffect)
    return effect.action, effect.name


ENDED = dataclasses.replace(RUNS, running=0)


def test_the_key_begins_a_mission_under_the_name_that_is_typed() -> None:
    question = asked("ask", ENDED)
    for name in ("attic", "", "end"):
        assert wanted(question.answer(name, on(ENDED))) == (MissionAction.BEGIN, name)


@pytest.mark.parametrize("first", [None, ENDED])
def test_a_mission_that_began_while_its_name_was_typed_gets_that_name(
    first: MissionState | None,
) -> None:
    question = asked("ask", first)
    assert wanted(question.answer("attic", on(RUNS))) == (MissionAction.NAME, "attic")
    assert question.answer("", on(RUNS)) == ()


def test_a_name_that_was_typed_too_early_waits_for_the_robot() -> None:
    widget = widget_of("widgetMission", do="ask")
    for known, action in ((ENDED, MissionAction.BEGIN), (RUNS, MissionAction.NAME)):
        (question,) = widget.handle(down("m"), KEY, on(None))
        assert isinstance(question, AskEffect)
        (told,) = question.answer("attic", on(None))
        assert isinstance(told, Notify)
        assert widget.tick(on(None)) == ()
        (again,) = widget.handle(down("m"), KEY, on(None))
        assert isinstance(again, AskEffect)
        assert again.text == "attic"
        assert wanted(widget.tick(on(known))) == (action, "attic")
        assert widget.tick(on(known)) == ()


def test_a_name_that_waits_in_vain_is_told() -> None:
    widget = widget_of("widgetMission", do="ask")
    (question,) = widget.handle(down("m"), KEY, on(None))
    assert isinstance(question, AskEffect)
    began = on(None)
    question.answer("attic", began)
    assert widget.tick(dataclasses.replace(began, now=began.now + 0.9 * WAIT_S)) == ()
    (told,) = widget.tick(dataclasses.replace(began, now=began.now + WAIT_S))
    assert isinstance(told, Notify)
    assert "attic" in told.notice.text
    assert told.notice.alarm


def test_the_key_names_a_mission_that_runs_and_asks_before_it_ends_it() -> None:
    question = asked("ask", RUNS)
    assert question.text == "cellar"
    assert wanted(question.answer("attic", on(RUNS))) == (MissionAction.NAME, "attic")
    assert question.answer("cellar", on(RUNS)) == question.answer("", on(RUNS)) == ()
    (sure,) = question.answer("End", on(RUNS))
    for each in (sure, asked("end", RUNS)):
        assert isinstance(each, AskEffect)
        assert each.answer("end", on(RUNS)) == each.answer("", on(RUNS)) == ()
        assert wanted(each.answer("yes", on(RUNS))) == (MissionAction.END, "")


def test_ending_says_what_is_not_confirmed() -> None:
    assert (
        "2 marks are NOT CONFIRMED"
        in asked("end", RUNS, unconfirmed={(1, "magellan"): 2, (1, "blimp"): 3}).asked
    )


def test_which_key_begins_another_mission_is_said() -> None:
    state = on(ENDED, inputs={(Purpose.MISSION, "magellan"): "M"})
    watch = MissionWatch()
    list(watch.look(on(RUNS).robots["magellan"], on(RUNS)))
    (notice,) = watch.look(state.robots["magellan"], state)
    assert notice.text == "mission cellar is ended, 3 marks kept; M begins another"
    assert _rows_of(ENDED, "M")[1] == "M, a mark, or who takes control, begins one"


def _rows_of(mission: MissionState, key: str) -> list[str]:
    return [part.text for part in mission_rows(mission, 0, key)]


@pytest.mark.parametrize(("do", "mission"), [("begin", RUNS), ("end", None), ("name", None)])
def test_what_cannot_be_is_said(do: str, mission: MissionState | None) -> None:
    (effect,) = widget_of("widgetMission", do=do).handle(down("m"), KEY, on(mission))
    assert isinstance(effect, Notify)


def test_what_is_not_kept_is_an_alarm_everywhere() -> None:
    state = on(FULL)
    robot = state.robots["magellan"]
    assert any("NOT KEPT: the disk is full" in part.text for part in troubles(robot, state))
    assert any("the disk is full" in reason for reason in reasons_to_stay(state))
    assert any("NOT KEPT" in part.text for part in mission_rows(FULL, 0))
    watch = MissionWatch()
    list(watch.look(on(RUNS).robots["magellan"], on(RUNS)))
    (notice,) = watch.look(robot, state)
    assert (notice.text, notice.alarm) == ("NOT KEPT: the disk is full", True)
    (notice,) = watch.look(on(RUNS).robots["magellan"], on(RUNS))
    assert (notice.text, notice.alarm) == ("all of the mission is kept again", False)


def test_who_joins_is_told_of_the_mission_and_of_what_changes() -> None:
    watch = MissionWatch()

    def told(mission: MissionState) -> list[str]:
        state = on(mission)
        return [notice.text for notice in watch.look(state.robots["magellan"], state)]

    assert told(RUNS) == ["mission cellar runs, 3 marks kept"]
    assert told(dataclasses.replace(RUNS, name="attic")) == ["the mission is named attic"]
    moved = dataclasses.replace(RUNS, name="attic", sheet=2, marks=0, earlier=3)
    assert told(moved) == ["sheet 2 of the map begins; 3 marks stay on the sheets before"]
    ended = dataclasses.replace(moved, running=0)
    assert told(ended) == ["mission attic is ended, 3 marks kept"]
    assert told(dataclasses.replace(RUNS, begun=2e9)) == ["mission cellar begins"]


def test_the_pane_says_name_time_marks_and_the_saved_map() -> None:
    assert [part.text for part in mission_rows(RUNS, 0)] == [
        "3 marks kept", "cellar, 3 min", "map saved 4 s ago",
    ]  # fmt: skip
    fresh = dataclasses.replace(RUNS, running_s=3.0, marks=1, map_age_s=math.nan)
    assert [part.text for part in mission_rows(fresh, 0)] == [
        "1 mark kept", "cellar, 3 s", "map not saved yet",
    ]  # fmt: skip
    assert [part.text for part in mission_rows(FULL, 1)][1:] == [
        "NOT KEPT: the disk is full", "3 marks, 2 changes in memory only",
        "cellar, 3 min", "map saved 4 s ago",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("handler", "capability", "said"),
    [
        (
            "widgetAutonomy",
            "AUT_PILOT",
            "no order explore: it does not provide AUT_PILOT: why",
        ),
        ("widgetMission", "PRO_POINTS", "no mission: it does not provide PRO_POINTS: why"),
        (
            "widgetToggleNightMode",
            "VIS_NIGHT",
            "no night mode: it does not provide VIS_NIGHT: why",
        ),
    ],
)
def test_a_robot_that_cannot_do_it_is_asked_nothing_and_the_key_says_why(
    handler: str, capability: str, said: str
) -> None:
    state = on(RUNS)
    robot = state.robots["magellan"]
    link = dataclasses.replace(
        robot.link, lacking={capability: Lack(kind=LackKind.ABSENT, why="why")}
    )
    state = dataclasses.replace(state, robots={"magellan": robot.with_(link=link)})
    (effect,) = widget_of(handler).handle(down("m"), KEY, state)
    assert isinstance(effect, Notify)
    assert effect.notice.text == said
