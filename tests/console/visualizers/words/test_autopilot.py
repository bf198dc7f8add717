"""What the pane of a vehicle with an autopilot says, and which problems it makes."""

from __future__ import annotations

import math

import pytest

from hub.gcm.autopilot import AutopilotPhase, AutopilotState, UnsafeParameter
from hub.gcm.diagnostics import Severity as Level
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import THEMES
from rune_tui.visualizers.parts.autopilot_words import unsafe_lines
from rune_tui.visualizers.parts.severity import Severity
from rune_tui.visualizers.words.troubles import FAULT_S, troubles
from tests.console.visualizers.conftest import NOW, Draw, words
from tests.support.autopilot import UNSAFE, piloted, rover


def rows(draw: Draw, robot: RobotState, height: int = 60, width: int = 44) -> list[str]:
    drawn = words(draw("visualizeAutopilot", robot, (width, height)))
    return [" ".join(row.split()) for row in drawn if row]


def test_it_says_what_an_operator_asks_first(draw: Draw) -> None:
    assert rows(draw, piloted(rover(), ("EKF3 active", Level.OK))) == [
        "ARMED · guided · follows you",
        "stops: zero 0.9 s, cut 1.4 s",
        "heard 0.4 s ago, echo 27 ms",
        "knows its place, 10 satellites",
        *[row for row in rows(draw, piloted(rover())) if row.startswith("battery")],
        "rover, ArduPilot 4.7.0",
        "EKF3 active",
    ]


@pytest.mark.parametrize(
    ("changes", "row"),
    [
        ({"lost": 0.0}, "heard 0.4 s ago, echo 27 ms"),
        ({"lost": 0.08}, "heard 0.4 s ago, echo 27 ms, 8% lost"),
        ({"lost": 0.51, "round_trip_s": 0.8}, "heard 0.4 s ago, echo 800 ms, 51% lost"),
    ],
)
def test_the_loss_and_the_delay_of_its_link_are_shown(
    draw: Draw, changes: dict[str, float], row: str
) -> None:
    robot = piloted(rover(**changes))
    assert row in rows(draw, robot)
    if "lost" in row:  # the number is the last to be cut
        assert row.partition(", ")[2] in rows(draw, robot, width=26)


def test_what_was_not_read_is_said_and_no_time_to_stop(draw: Draw) -> None:
    unread = UnsafeParameter(name="FS_TIMEOUT", wanted=0.1, why="it waits")
    nothing = {"stops_after_zero_s": math.nan, "stops_after_cut_s": math.nan}
    robot = piloted(rover(unsafe=(UNSAFE, unread), **nothing))
    said = rows(draw, robot, width=60)
    assert "1 unsafe parameter, 1 NOT READ: see help" in said
    assert "TIMES TO STOP NOT KNOWN" in said
    assert [each for each, _ in unsafe_lines(robot)] == [
        "FS_GCS_ENABLE 0, not 1",
        "FS_TIMEOUT was not read, has to be 0.1",
    ]
    state = ConsoleState(now=NOW, robots={robot.name: robot})
    alarms = [each.text for each in troubles(robot, state) if each.severity is Severity.ALARM]
    assert "1 unsafe parameter, 1 NOT READ: see the help" in alarms


@pytest.mark.parametrize("phase", AutopilotPhase)
def test_each_phase_is_said_and_why_it_does_not_move(draw: Draw, phase: AutopilotPhase) -> None:
    why = "" if phase is AutopilotPhase.DRIVING else "because of this"
    head, *rest = rows(draw, piloted(rover(phase=phase, why=why)))
    assert ("because of this" in rest) == bool(why)
    armed = phase in (AutopilotPhase.DRIVING, AutopilotPhase.ELSEWHERE)
    assert head.startswith("ARMED") == armed
    assert head != rows(draw, piloted(rover(phase=AutopilotPhase((phase + 1) % 7))))[0]


def test_armed_is_on_a_ground_of_its_own(draw: Draw) -> None:
    def ground(autopilot: AutopilotState) -> tuple[int, ...]:
        return tuple(draw("visualizeAutopilot", piloted(autopilot), (44, 20)).pixels[0, 40])

    grounds = [
        ground(rover(phase=phase))
        for phase in (AutopilotPhase.DRIVING, AutopilotPhase.DISARMED, AutopilotPhase.GONE)
    ]
    assert len(set(grounds)) == 3
    assert grounds[0][:3] == next(iter(THEMES.values())).warning[:3]


def test_what_is_wrong_is_said(draw: Draw) -> None:
    wrong = rover(
        why="it is in hold, not asked for here: ask it to drive",
        failsafe=1,
        verified=0,
        position=0,
        satellites=255,
        gain=0.5,
        stops_after_cut_s=math.inf,
        unsafe=(UNSAFE,),
    )
    text = " ".join(rows(draw, piloted(wrong, ("Leak Detected", Level.ERROR))))
    for words_ in (
        "A FAILSAFE ACTS",
        "NEVER STOPS after the link is cut",
        "stops 0.9 s after zero",
        "DOES NOT KNOW ITS PLACE",
        "sticks have 50% of their effect",
        "1 unsafe parameter: see help",
        "NOT VERIFIED, its rules follow documents only",
        "Leak Detected",
    ):
        assert words_ in text
    assert "255" not in text


@pytest.mark.parametrize("phase", [AutopilotPhase.ELSEWHERE, AutopilotPhase.DISARMED])
def test_the_key_that_asks_it_to_follow_stands_where_it_does_not(
    draw: Draw, phase: AutopilotPhase
) -> None:
    """The line of keys has no room for it on a small terminal."""
    robot = piloted(rover(phase=phase, why="it is in hold: ask it to drive"))
    state = ConsoleState(now=NOW, inputs={(Purpose.FOLLOW, robot.name): "F"})
    said = words(draw("visualizeAutopilot", robot, (44, 20), state=state))
    key = " (F)" if phase is AutopilotPhase.ELSEWHERE else ""
    assert f"it is in hold: ask it to drive{key}" in said


def test_nothing_is_invented_about_a_vehicle_that_was_never_heard(draw: Draw) -> None:
    unheard = AutopilotState(why="no heartbeat came yet")
    assert rows(draw, piloted(unheard)) == ["NO AUTOPILOT YET", "no heartbeat came yet"]
    assert rows(draw, piloted(None)) == ["no state of the autopilot"]


def test_what_a_silent_vehicle_said_of_itself_is_no_longer_said(draw: Draw) -> None:
    gone = rover(phase=AutopilotPhase.GONE, why="no heartbeat for 4 s", heard_s=4.2, gain=0.5)
    text = "\n".join(rows(draw, piloted(gone)))
    assert "GONE" in text.splitlines()[0]
    assert "heard 4.2 s ago" in text
    for words_ in ("place", "battery", "sticks"):
        assert words_ not in text


def test_without_room_the_reason_stays_and_the_rest_is_counted(draw: Draw) -> None:
    texts = [(f"text {number}", Level.OK) for number in range(9)]
    wrong = rover(why="it is in hold", unsafe=(UNSAFE,))
    drawn = rows(draw, piloted(wrong, *texts), height=10)
    assert drawn[:2] == ["ARMED · guided · follows you", "it is in hold"]
    assert "+" in drawn[-1]
    tall = rows(draw, piloted(wrong, *texts))
    assert tall[-1] == "text 8"
    assert "text 3" not in tall, "only the last ones"


def test_a_narrow_head_keeps_whether_it_is_armed_and_its_mode(draw: Draw) -> None:
    away = rover(phase=AutopilotPhase.ELSEWHERE, mode="smart rtl", why="it is in smart rtl")
    assert rows(draw, piloted(away), width=40)[0] == "ARMED · smart rtl · does not follow"
    assert rows(draw, piloted(away), width=31)[0] == "ARMED · smart rtl · not driven"
    assert rows(draw, piloted(away), width=20)[0] == "ARMED · smart rtl"
    sub = rover(mode="position hold")
    assert rows(draw, piloted(sub), width=31)[0] == "ARMED · position hold · follows"
    assert rows(draw, piloted(sub), width=30)[0] == "ARMED · position hold follows"


def test_times_to_stop_are_those_of_the_modes_that_follow(draw: Draw) -> None:
    def stops(phase: AutopilotPhase) -> str:
        words_ = " ".join(rows(draw, piloted(rover(phase=phase)), width=80))
        return words_.partition(" 0.9 s after zero, 1.4 s after the link is cut")[0][-9:]

    assert stops(AutopilotPhase.DRIVING).endswith("stops")
    assert stops(AutopilotPhase.DISARMED) == "will stop"
    away = piloted(rover(phase=AutopilotPhase.ELSEWHERE, mode="manual"))
    assert "after zero" not in " ".join(rows(draw, away, width=80))


def test_an_old_state_is_marked(draw: Draw) -> None:
    assert "STALE" in rows(draw, piloted(rover(), age=5.0))[0]


def problems(
    autopilot: AutopilotState, *texts: tuple[str, Level], now: float = NOW
) -> dict[str, Severity]:
    robot = piloted(autopilot, *texts)
    found = troubles(robot, ConsoleState(now=now, robots={robot.name: robot}))
    return {part.cause: part.severity for part in found}


def test_that_nothing_stops_it_is_an_alarm_once_it_is_armed() -> None:
    never = {"stops_after_cut_s": math.inf}
    assert problems(rover(**never))["never stops"] is Severity.ALARM
    disarmed = rover(phase=AutopilotPhase.DISARMED, **never)
    assert problems(disarmed)["never stops"] is Severity.WARNING
    assert "never stops" not in problems(rover(stops_after_cut_s=math.nan))
    assert problems(rover(unsafe=(UNSAFE,)))["unsafe parameters"] is Severity.WARNING
    assert "unsafe parameters" not in problems(rover())


def test_faults_that_the_autopilot_reports_are_alarms_for_a_while() -> None:
    texts = [("Leak Detected", Level.ERROR), ("GPS Glitch", Level.WARN)]
    checked = ("PreArm: Gyros inconsistent", Level.ERROR)
    leak = "says Leak Detected"
    assert problems(rover(), *texts)[leak] is Severity.ALARM
    assert [each for each in problems(rover(), *texts, checked) if "says" in each] == [leak]
    assert leak not in problems(rover(), *texts, now=NOW + FAULT_S)


def test_a_place_that_is_lost_is_a_warning_while_it_is_armed() -> None:
    assert problems(rover(position=0))["no place"] is Severity.WARNING
    assert "no place" not in problems(rover())
    assert "no place" not in problems(rover(phase=AutopilotPhase.DISARMED, position=0))
