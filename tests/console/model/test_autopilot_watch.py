"""The operator is told once each what an autopilot does and says."""

from __future__ import annotations

from hub.gcm.autopilot import AutopilotPhase, AutopilotState
from hub.gcm.diagnostics import Severity
from rune_tui.model.autopilot_watch import SETTLED_S, AutopilotWatch
from rune_tui.model.console_state import ConsoleState
from tests.support.autopilot import piloted, rover

DISARMED = rover(phase=AutopilotPhase.DISARMED, why="it is disarmed: arm it", mode="manual")


def told(
    watch: AutopilotWatch,
    autopilot: AutopilotState | None,
    *texts: tuple[str, Severity],
    now: float = 100.0,
) -> list[tuple[str, bool]]:
    notices = watch.look(piloted(autopilot, *texts), ConsoleState(now=now))
    return [(notice.text, notice.alarm) for notice in notices]


def test_changes_are_told_once_and_the_first_state_is_none() -> None:
    watch = AutopilotWatch()
    assert told(watch, None) == []
    assert told(watch, DISARMED) == []
    assert told(watch, rover()) == [("it follows you in the mode guided", False)]
    assert told(watch, rover()) == []
    assert told(watch, DISARMED) == [("it is disarmed", False)]


def test_what_takes_the_vehicle_away_is_an_alarm() -> None:
    watch = AutopilotWatch()
    told(watch, rover())
    away = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in hold", failsafe=1)
    assert told(watch, away) == []
    assert told(watch, away, now=100.1 + SETTLED_S) == [("it is in hold", True)]
    assert told(watch, away, now=200.0) == [], "once"
    asked = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in loiter, asked for here")
    assert told(watch, asked, now=300.0) == []
    assert told(watch, asked, now=301.0) == [("it is in loiter, asked for here", False)]
    gone = rover(phase=AutopilotPhase.GONE, why="no heartbeat for 2.5 s")
    assert told(watch, gone) == [("the autopilot is gone: no heartbeat for 2.5 s", True)]


def test_a_refusal_is_an_alarm_with_the_vehicles_reason() -> None:
    watch = AutopilotWatch()
    told(watch, DISARMED)
    refusal = "to arm was refused: Arm: Gyros inconsistent"
    refused = rover(phase=AutopilotPhase.DISARMED, refusal=refusal, why=refusal)
    assert told(watch, refused) == [(refusal, True)]
    assert told(watch, refused) == []


def test_texts_are_told_by_severity_and_checks_before_arming_once() -> None:
    watch = AutopilotWatch()
    texts = [
        ("EKF3 IMU0 origin set", Severity.OK),
        ("PreArm: Gyros inconsistent", Severity.ERROR),
        ("PreArm: Gyros inconsistent", Severity.ERROR),
        ("GPS Glitch", Severity.WARN),
        ("Leak Detected", Severity.ERROR),
    ]
    assert told(watch, DISARMED, *texts) == [
        ("it says: PreArm: Gyros inconsistent", False),
        ("it says: GPS Glitch", False),
        ("it says: Leak Detected", True),
    ]
    assert told(watch, DISARMED, *texts) == []
    again = [*texts, ("Leak Detected", Severity.ERROR)]
    assert told(watch, DISARMED, *again) == [("it says: Leak Detected", True)]


def test_a_mode_on_the_way_to_another_is_not_told() -> None:
    watch = AutopilotWatch()
    told(watch, rover())
    leaves = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in guided, not asked for here")
    assert told(watch, leaves, now=100.2) == []
    assert told(watch, DISARMED, now=100.4) == [("it is disarmed", False)]
    assert told(watch, rover(), now=200.0) == [("it follows you in the mode guided", False)]


def test_a_refused_mode_is_told_once() -> None:
    watch = AutopilotWatch()
    told(watch, rover())
    refusal = "the mode loiter was refused: requires position"
    why = f"{refusal}; it is in hold"
    refused = rover(phase=AutopilotPhase.ELSEWHERE, refusal=refusal, why=why)
    assert told(watch, refused, now=101.0) == [(refusal, True)]
    assert told(watch, refused, now=109.0) == []
