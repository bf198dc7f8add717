"""The operator gets one notice of each thing that an autopilot does or says."""

from __future__ import annotations

from hub.gcm.autopilot import AutopilotPhase, AutopilotState
from hub.gcm.diagnostics import Severity
from rune_tui.model.autopilot_watch import SETTLED_S, AutopilotWatch
from rune_tui.model.console_state import ConsoleState
from tests.support.autopilot import piloted, rover

DISARMED = rover(phase=AutopilotPhase.DISARMED, why="it is disarmed: arm it", mode="manual")


def notices_of(
    watch: AutopilotWatch,
    autopilot: AutopilotState | None,
    *texts: tuple[str, Severity],
    now: float = 100.0,
) -> list[tuple[str, bool]]:
    notices = watch.look(piloted(autopilot, *texts), ConsoleState(now=now))
    return [(notice.text, notice.alarm) for notice in notices]


def test_each_change_is_one_notice_and_the_first_state_is_none() -> None:
    watch = AutopilotWatch()
    assert notices_of(watch, None) == []
    assert notices_of(watch, DISARMED) == []
    assert notices_of(watch, rover()) == [("it follows you in the mode guided", False)]
    assert notices_of(watch, rover()) == []
    assert notices_of(watch, DISARMED) == [("it is disarmed", False)]


def test_what_takes_the_vehicle_away_is_an_alarm() -> None:
    watch = AutopilotWatch()
    notices_of(watch, rover())
    away = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in hold", failsafe=1)
    assert notices_of(watch, away) == []
    assert notices_of(watch, away, now=100.1 + SETTLED_S) == [("it is in hold", True)]
    assert notices_of(watch, away, now=200.0) == [], "once"
    asked = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in loiter, asked for here")
    assert notices_of(watch, asked, now=300.0) == []
    assert notices_of(watch, asked, now=301.0) == [("it is in loiter, asked for here", False)]
    gone = rover(phase=AutopilotPhase.GONE, why="no heartbeat for 2.5 s")
    assert notices_of(watch, gone) == [("the autopilot is gone: no heartbeat for 2.5 s", True)]


def test_a_refusal_is_an_alarm_with_the_vehicles_reason() -> None:
    watch = AutopilotWatch()
    notices_of(watch, DISARMED)
    refusal = "to arm was refused: Arm: Gyros inconsistent"
    refused = rover(phase=AutopilotPhase.DISARMED, refusal=refusal, why=refusal)
    assert notices_of(watch, refused) == [(refusal, True)]
    assert notices_of(watch, refused) == []


def test_texts_are_notices_by_severity_and_checks_before_arming_come_once() -> None:
    watch = AutopilotWatch()
    texts = [
        ("EKF3 IMU0 origin set", Severity.OK),
        ("PreArm: Gyros inconsistent", Severity.ERROR),
        ("PreArm: Gyros inconsistent", Severity.ERROR),
        ("GPS Glitch", Severity.WARN),
        ("Leak Detected", Severity.ERROR),
    ]
    assert notices_of(watch, DISARMED, *texts) == [
        ("it says: PreArm: Gyros inconsistent", False),
        ("it says: GPS Glitch", False),
        ("it says: Leak Detected", True),
    ]
    assert notices_of(watch, DISARMED, *texts) == []
    again = [*texts, ("Leak Detected", Severity.ERROR)]
    assert notices_of(watch, DISARMED, *again) == [("it says: Leak Detected", True)]


def test_a_mode_on_the_way_to_another_is_no_notice() -> None:
    watch = AutopilotWatch()
    notices_of(watch, rover())
    leaves = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in guided, not asked for here")
    assert notices_of(watch, leaves, now=100.2) == []
    assert notices_of(watch, DISARMED, now=100.4) == [("it is disarmed", False)]
    assert notices_of(watch, rover(), now=200.0) == [("it follows you in the mode guided", False)]


def test_a_refused_mode_is_one_notice() -> None:
    watch = AutopilotWatch()
    notices_of(watch, rover())
    refusal = "the mode loiter was refused: requires position"
    why = f"{refusal}; it is in hold"
    refused = rover(phase=AutopilotPhase.ELSEWHERE, refusal=refusal, why=why)
    assert notices_of(watch, refused, now=101.0) == [(refusal, True)]
    assert notices_of(watch, refused, now=109.0) == []
