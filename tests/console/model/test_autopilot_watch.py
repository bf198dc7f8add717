"""The operator is told once each what an autopilot does and says."""

from __future__ import annotations

from hub.gcm.autopilot import AutopilotPhase, AutopilotState
from hub.gcm.diagnostics import Severity
from rune_tui.model.autopilot_watch import AutopilotWatch
from rune_tui.model.console_state import ConsoleState
from tests.support.autopilot import piloted, rover

STATE = ConsoleState(now=100.0)
DISARMED = rover(phase=AutopilotPhase.DISARMED, why="it is disarmed: arm it", mode="manual")


def told(watch: AutopilotWatch, autopilot: AutopilotState | None, *texts: tuple[str, Severity]):
    notices = watch.look(piloted(autopilot, *texts), STATE)
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
    assert told(watch, away) == [("it is in hold", True)]
    asked = rover(phase=AutopilotPhase.ELSEWHERE, why="it is in loiter, asked for here")
    assert told(watch, asked) == [("it is in loiter, asked for here", False)]
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
