"""What a recording says about an operator with several robots."""

from __future__ import annotations

import dataclasses
import math

import pytest

from rune_tui.model.attention import AttentionQueue, Problem
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseRobot, Peek
from rune_tui.model.state_changes import changed
from rune_tui.model.team_events import RUNE_TEAM, TeamEvent, TeamEventKind, TeamWatch

START = ConsoleState(now=10.0, chosen="rover")
LEAK = Problem(robot="rov", cause="leak", text="water in the hull", alarm=True)


def at(state: ConsoleState, now: float) -> ConsoleState:
    return dataclasses.replace(state, now=now)


def described(events: list[TeamEvent]) -> list[tuple[str, str, float]]:
    return [(each.kind.name, each.robot, round(each.after_s, 3)) for each in events]


def test_the_time_from_a_choice_to_the_first_command_is_said_once() -> None:
    watch = TeamWatch()
    assert described(list(watch.look(START)))[0][:2] == ("CHOSEN", "rover")
    assert list(watch.look(at(START, 11.0))) == []
    assert described(list(watch.command("blimp", at(START, 11.5)))) == []
    assert described(list(watch.command("rover", at(START, 12.0)))) == [("COMMANDED", "rover", 2.0)]
    assert list(watch.command("rover", at(START, 12.1))) == []
    chosen = changed(at(START, 20.0), ChooseRobot(robot="blimp"))
    assert described(list(watch.command("blimp", at(chosen, 20.0)))) == [
        ("CHOSEN", "blimp", 10.0),
        ("COMMANDED", "blimp", 0.0),
    ]


def test_a_peek_is_no_choice() -> None:
    watch = TeamWatch()
    list(watch.look(START))
    peeking = changed(at(START, 14.0), Peek(robot="rov"))
    assert described(list(watch.look(peeking))) == [("PEEKED", "rov", 4.0)]
    assert list(watch.look(changed(peeking, Peek()))) == []


def test_alarms_have_the_times_of_their_rise_answer_and_end() -> None:
    watch, queue = TeamWatch(), AttentionQueue()
    list(watch.look(START))

    def events(now: float, *problems: Problem, seen: str = "rover") -> list[tuple[str, str, float]]:
        entries = queue.look(problems, seen, now)
        return described(list(watch.look(dataclasses.replace(START, now=now, attention=entries))))

    assert events(20.0, LEAK) == [("RAISED", "rov", 0.0)]
    assert events(25.0, LEAK) == []
    assert events(30.0, LEAK) == [("RAISED", "rov", 10.0)]
    assert events(33.0, LEAK, seen="rov") == [("ANSWERED", "rov", 3.0)]
    assert events(50.0) == [("OVER", "rov", 30.0)]


@pytest.mark.parametrize("after", [1.5, math.nan])
def test_an_event_can_be_recorded(after: float) -> None:
    event = TeamEvent(kind=TeamEventKind.RAISED, robot="rov", cause="leak", after_s=after)
    decoded = RUNE_TEAM.decode(b"".join(RUNE_TEAM.encode(event)))
    assert (decoded.robot, decoded.cause, decoded.kind) == ("rov", "leak", TeamEventKind.RAISED)
