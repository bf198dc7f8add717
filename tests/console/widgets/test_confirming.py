"""Marks are sent again until the robot confirms them; what it does not keep is an alarm."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from hub.gcm.mapping import (
    POINT_COMMAND,
    POINT_REFUSAL,
    InterestPoint,
    PointAction,
    PointRefusal,
)
from hub.gcm.mission import MISSION_STATE, MissionState
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, MarksWaiting, Notify, SendEffect
from rune_tui.model.leaving import reasons_to_stay
from rune_tui.model.robot_state import LinkPhase
from rune_tui.model.state_changes import changed
from rune_tui.widgets.confirming import AGAIN_S, ANSWER_S
from tests.console.visualizers.conftest import NOW, received
from tests.console.widgets.presses import click, event_spec, marked, points, seeing, widget_of

LEFT = event_spec("mouse left")


def knowing(*marks: InterestPoint, after: float, **others: Any) -> ConsoleState:
    """A console that heard this just now."""
    state = seeing(*marks, now=NOW + after)
    robot = state.robots["magellan"]
    messages = {name: received(value, age=-after) for name, value in others.items()}
    heard = {name: received(each.value, age=-after) for name, each in points(*marks).items()}
    robot = robot.with_(messages={**robot.messages, **heard, **messages})
    return dataclasses.replace(state, robots={"magellan": robot})


def victim(*before: InterestPoint) -> Any:
    widget = widget_of("widgetSetVictim", confirm="off")
    assert sends(widget.handle(click(), LEFT, seeing(*before)))
    return widget


def sends(effects: tuple[Effect, ...]) -> list[SendEffect]:
    found = [effect for effect in effects if isinstance(effect, SendEffect)]
    assert all(effect.definition is POINT_COMMAND for effect in found)
    return found


def alarms(effects: tuple[Effect, ...]) -> list[str]:
    told = [effect.notice for effect in effects if isinstance(effect, Notify)]
    return [notice.text for notice in told if notice.alarm]


def test_a_mark_that_is_not_confirmed_is_sent_again_and_then_an_alarm() -> None:
    widget = victim(marked(4, x=0.0))
    assert not sends(widget.tick(knowing(marked(4, x=0.0), after=AGAIN_S - 0.1)))
    (again,) = sends(widget.tick(knowing(marked(4, x=0.0), after=AGAIN_S)))
    assert (again.value.point.number, again.value.point.x) == (0, 3.0)
    effects = widget.tick(knowing(after=ANSWER_S))
    (text,) = alarms(effects)
    assert "NOT KEPT" in text
    assert len(sends(effects)) == 1
    (waiting,) = [effect for effect in effects if isinstance(effect, MarksWaiting)]
    state = changed(knowing(after=ANSWER_S), waiting)
    assert "1 mark is lost" in reasons_to_stay(state)[0]
    # Once, not each second; and it is confirmed in the end.
    assert alarms(widget.tick(knowing(after=60.0))) == []
    effects = widget.tick(knowing(marked(9), after=61.0))
    (told,) = [effect.notice.text for effect in effects if isinstance(effect, Notify)]
    assert "victim 9 is marked" in told
    (waiting,) = [effect for effect in effects if isinstance(effect, MarksWaiting)]
    assert reasons_to_stay(changed(state, waiting)) == ()
    assert widget.tick(knowing(after=120.0)) == ()


def test_without_a_link_it_waits_and_is_sent_when_there_is_one() -> None:
    widget = victim()
    lost = knowing(after=20.0)
    robot = lost.robots["magellan"]
    cut = robot.with_(link=dataclasses.replace(robot.link, phase=LinkPhase.LOST))
    assert not sends(widget.tick(dataclasses.replace(lost, robots={"magellan": cut})))
    assert len(sends(widget.tick(knowing(after=21.0)))) == 1


def test_a_mark_in_the_robots_memory_only_is_not_confirmed() -> None:
    widget = victim()
    unkept = dataclasses.replace(marked(5), kept=0)
    full = {MISSION_STATE.name: MissionState(running=1, fault="the disk is full")}
    assert not alarms(widget.tick(knowing(unkept, after=0.1, **full)))
    effects = widget.tick(knowing(unkept, after=ANSWER_S, **full))
    assert alarms(effects) == [
        "the victim at 3.0, -1.0 m is in the robot's memory only: the disk is full"
    ]
    assert not sends(effects)
    effects = widget.tick(knowing(marked(5), after=ANSWER_S + 1.0))
    assert any("is marked" in each.notice.text for each in effects if isinstance(each, Notify))


def test_a_refused_mark_is_given_up() -> None:
    widget = victim()
    number = seeing().robots["magellan"].link.number
    refusal = PointRefusal(sender=number, number=0, text="there are 128 already")
    widget.tick(knowing(after=0.5, **{POINT_REFUSAL.name: refusal}))
    assert not sends(widget.tick(knowing(after=AGAIN_S + 1.0)))
    other = victim()
    refusal = PointRefusal(sender=number + 1, number=0, text="of somebody else")
    other.tick(knowing(after=0.5, **{POINT_REFUSAL.name: refusal}))
    assert sends(other.tick(knowing(after=AGAIN_S + 1.0)))


def test_a_mark_of_another_sheet_is_lost_and_says_so() -> None:
    widget = widget_of("widgetSetVictim", confirm="off")
    first = {MISSION_STATE.name: MissionState(running=1, sheet=1)}
    widget.handle(click(), LEFT, knowing(after=0.0, **first))
    second = {MISSION_STATE.name: MissionState(running=1, sheet=2)}
    effects = widget.tick(knowing(after=5.0, **second))
    (text,) = alarms(effects)
    assert "LOST" in text
    assert not sends(effects)


@pytest.mark.parametrize("handler", ["widgetEditMark", "widgetRemoveMark"])
def test_changes_and_removals_are_sent_again_with_the_version_they_change(handler: str) -> None:
    widget = widget_of(handler)
    mark = dataclasses.replace(marked(2), version=3)
    effects = widget.handle(click(), LEFT, seeing(mark))
    for effect in effects:
        if isinstance(effect, AskEffect):
            effects = effect.answer("behind the door", seeing(mark))
    (first,) = sends(effects)
    assert first.value.point.version == 3
    (again,) = sends(widget.tick(knowing(mark, after=AGAIN_S)))
    assert again.value is first.value
    removed = first.value.action is PointAction.REMOVE
    now = () if removed else (dataclasses.replace(mark, version=4),)
    effects = widget.tick(knowing(*now, after=AGAIN_S + 0.5))
    (text,) = [effect.notice.text for effect in effects if isinstance(effect, Notify)]
    assert text == ("victim 2 is removed" if removed else "victim 2 is changed")
