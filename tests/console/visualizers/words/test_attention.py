"""visualizeAttention: the rows of the queue, and the key that leads to the next alarm."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rune_tui.layout.rules import Purpose
from rune_tui.model.attention import AttentionEntry
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK
from tests.console.visualizers.conftest import NOW, Made, words
from tests.support.cases import for_each

MADE = Made()


def entry(robot: str, text: str, **changes: Any) -> AttentionEntry:
    values: dict[str, Any] = {
        "cause": text,
        "alarm": True,
        "since": NOW - 12.0,
        "raised": NOW - 2.0,
        "times": 1,
        "answered": False,
        "over": False,
    }
    return AttentionEntry(robot=robot, text=text, **values | changes)


QUEUE = (
    entry("rover", "tipped over: roll 87 deg", answered=True),
    entry("blimp", "does not hold its height", times=3),
    entry("rov", "BATTERY LOW 15%", alarm=False, since=NOW - 3.0),
    entry("rov", "tether", over=True),
)


def state(*queue: AttentionEntry) -> ConsoleState:
    robots = {
        name: MADE.robot().with_(name=name, messages={}) for name in ("rover", "blimp", "rov")
    }
    return ConsoleState(
        now=NOW,
        robots=robots,
        chosen="rover",
        attention=queue,
        inputs={(Purpose.NEXT_ALARM, ""): "N"},
    )


def rows(draw: Any, *queue: AttentionEntry, size: tuple[int, int] = (70, 12)) -> list[str]:
    shown = state(*queue)
    return words(draw("visualizeAttention", shown.robots["rover"], size, state=shown))


def test_a_row_says_which_robot_since_when_and_what(draw) -> None:
    assert rows(draw, *QUEUE)[:4] == [
        "    !!  rover  12 s  tipped over: roll 87 deg",
        "N»» !!  blimp  12 s  does not hold its height",
        " »  !   rov    3 s   BATTERY LOW 15%",
        "        rov    12 s  over: tether",
    ]


def test_the_key_of_the_next_alarm_is_where_it_leads(draw) -> None:
    lines = rows(draw, *QUEUE)
    assert [line.startswith("N") for line in lines[:4]] == [False, True, False, False]
    calm = rows(draw, entry("blimp", "leak", answered=True))
    assert calm[0].startswith("N"), "an answered alarm is reached too"
    assert "»" not in calm[0]


def test_an_alarm_without_an_answer_has_a_plate(draw) -> None:
    shown = state(*QUEUE)
    canvas = draw("visualizeAttention", shown.robots["rover"], (70, 12), state=shown)
    plates = [tuple(canvas.pixels[2 * row, 0]) == tuple(DARK.alarm) for row in range(4)]
    assert plates == [False, True, False, False]


@for_each("columns", [70, 40, 29, 20, 12])
def test_narrow_panes_keep_the_robot_and_the_words(draw, columns: int) -> None:
    line = rows(draw, *QUEUE, size=(columns, 12))[1]
    assert "blimp" in line or columns < 20
    assert "does" in line


def test_entries_without_room_are_counted(draw) -> None:
    assert rows(draw, *QUEUE, size=(40, 4))[1].endswith("+2")


def test_an_empty_queue_says_that_all_is_well_once_all_robots_report(draw) -> None:
    assert rows(draw)[0] == "no alarms: all well"
    shown = state()
    silent = shown.robots["rov"].with_(diagnostics={})
    shown = replace(shown, robots={**shown.robots, "rov": silent})
    drawn = words(draw("visualizeAttention", silent, (70, 12), state=shown))
    assert drawn[0] == "no alarms"
