"""What the operator is told when links, capabilities and joysticks come and go."""

from __future__ import annotations

from typing import Any

import pytest

from hub.gcm.supervision import (
    CAPABILITY_REPORTS,
    CapabilityPhase,
    CapabilityReport,
    CapabilityReports,
)
from rune_tui.model.change_notifier import GRACE_S, ChangeNotifier
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from rune_tui.model.robot_state import Lack, LinkPhase
from tests.console.states import ABSENT, BROKEN, COMING
from tests.console.visualizers.conftest import Made, received


def seen(
    watch: ChangeNotifier, phase: LinkPhase, running: str = "", *, now: float = 1.0, **lacking: Lack
) -> list[Any]:
    reports = tuple(
        CapabilityReport(
            name=name, phase=CapabilityPhase.RUNNING, module="", modules="", wanted_by=""
        )
        for name in running.split()
    )
    value = CapabilityReports(robot="magellan", capabilities=reports)
    robot = Made().robot(
        link=Made.link(phase, lacking=lacking),
        messages={CAPABILITY_REPORTS.name: received(value)},
    )
    return list(watch.look(ConsoleState(now=now, robots={"magellan": robot}, clock="12:00:00")))


def texts(notices: list[Any]) -> list[tuple[str, bool]]:
    return [(notice.text, notice.alarm) for notice in notices]


def test_a_link_is_told_when_it_comes_is_lost_and_comes_again():
    watch = ChangeNotifier()
    assert seen(watch, LinkPhase.CONNECTING) == []
    assert texts(seen(watch, LinkPhase.CONNECTED)) == [("linked", False)]
    assert seen(watch, LinkPhase.CONNECTED) == []
    (lost,) = seen(watch, LinkPhase.LOST)
    assert (lost.alarm, lost.robot, lost.clock) == (True, "magellan", "12:00:00")
    assert seen(watch, LinkPhase.LOST) == []
    assert texts(seen(watch, LinkPhase.CONNECTED)) == [("linked again", False)]


def test_a_capability_that_is_missing_is_told_once_and_so_is_its_return():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED)
    why = BROKEN
    alarm = [(f"it does not provide VIS_VID: {why.why}", True)]
    assert seen(watch, LinkPhase.CONNECTED, VIS_VID=why) == [], "a hub that starts begins so"
    assert seen(watch, LinkPhase.CONNECTED, VIS_VID=why, now=1.0 + 0.9 * GRACE_S) == []
    assert texts(seen(watch, LinkPhase.CONNECTED, VIS_VID=why, now=1.1 + GRACE_S)) == alarm
    assert seen(watch, LinkPhase.CONNECTED, VIS_VID=why, now=2.0 + GRACE_S) == []
    again = [("it provides VIS_VID again", False)]
    assert texts(seen(watch, LinkPhase.CONNECTED, "VIS_VID")) == again


def test_a_start_is_no_alarm_and_a_restart_is():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED)
    assert seen(watch, LinkPhase.CONNECTED, VIS_VID=COMING) == []
    assert seen(watch, LinkPhase.CONNECTED, "VIS_VID") == []
    (alarm,) = seen(watch, LinkPhase.CONNECTED, VIS_VID=COMING)
    assert alarm.alarm


def test_what_a_robot_is_made_without_is_said_once_and_is_no_alarm():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED)
    seen(watch, LinkPhase.CONNECTED, PRO_MAP=ABSENT)
    said = [("it does not provide PRO_MAP: this robot has no module for it", False)]
    later = 1.1 + GRACE_S
    assert texts(seen(watch, LinkPhase.CONNECTED, PRO_MAP=ABSENT, now=later)) == said
    assert seen(watch, LinkPhase.CONNECTED, PRO_MAP=ABSENT, now=later + 60.0) == []


def test_what_only_some_bodies_have_is_not_missed_without_such_a_part():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED)
    seen(watch, LinkPhase.CONNECTED, DRV_JOINT=ABSENT, DRV_MODE=ABSENT)
    later = 1.1 + GRACE_S
    assert seen(watch, LinkPhase.CONNECTED, DRV_JOINT=ABSENT, DRV_MODE=ABSENT, now=later) == []
    (alarm,) = seen(watch, LinkPhase.CONNECTED, DRV_JOINT=BROKEN, now=2.0 + GRACE_S)
    assert alarm.alarm, "a module that should be there is missed"


def test_a_capability_that_was_there_and_whose_module_is_gone_is_an_alarm():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED, "VIS_VID")
    (gone,) = seen(watch, LinkPhase.CONNECTED, VIS_VID=ABSENT)
    assert gone.alarm


def test_a_lost_link_says_nothing_of_capabilities():
    watch = ChangeNotifier()
    seen(watch, LinkPhase.CONNECTED, "VIS_VID")
    (lost,) = seen(watch, LinkPhase.LOST, VIS_VID=COMING)
    assert "link" in lost.text


def test_a_message_with_a_value_out_of_its_range_is_told_once():
    watch = ChangeNotifier()

    def look(unfit: dict[str, str]) -> list[tuple[str, bool]]:
        robot = Made().robot(link=Made.link(unfit=unfit))
        return texts(list(watch.look(ConsoleState(now=1.0, robots={"magellan": robot}))))

    look({})
    text = "GCM_RobotState.x is 1e+308, not -1e+06 to 1e+06 m"
    assert look({"GCM_RobotState": text}) == [(text, True)]
    assert look({"GCM_RobotState": text}) == []


def told_of(
    watch: ChangeNotifier, phase: JoystickPhase, device: str = "F310", why: str = "", **more: Any
) -> Any:
    pad = JoystickState(name="pad", device=device, phase=phase, why=why, **more)
    return texts(list(watch.look(ConsoleState(now=1.0, joysticks={"pad": pad}))))


@pytest.mark.parametrize(
    ("absence", "text"),
    [
        (Absence.SILENT, "pad is silent: nothing comes from F310 at desk"),
        (Absence.ENDED, "pad has ended: F310 at desk is no longer sent"),
        (Absence.UNPLUGGED, "pad is unplugged: F310 at desk is gone"),
    ],
)
def test_what_became_of_a_joystick_of_another_machine_is_said(absence: Absence, text: str) -> None:
    watch = ChangeNotifier()
    told_of(watch, JoystickPhase.CONNECTED, "F310 at desk", machine="desk")
    gone = told_of(watch, JoystickPhase.MISSING, "F310 at desk", machine="desk", absence=absence)
    assert gone == [(text, True)]


def test_a_joystick_is_told_of_when_it_comes_and_goes():
    watch = ChangeNotifier()
    assert told_of(watch, JoystickPhase.MISSING, "") == []
    assert told_of(watch, JoystickPhase.CONNECTED) == [("pad is F310", False)]
    assert told_of(watch, JoystickPhase.CONNECTED) == []
    assert told_of(watch, JoystickPhase.MISSING) == [("pad is unplugged: F310 is gone", True)]
    assert told_of(watch, JoystickPhase.MISSING) == []


def test_a_joystick_that_cannot_be_used_is_told_of_once_with_the_reason():
    watch = ChangeNotifier()
    forbidden = [("pad cannot be used: no permission", True)]
    assert told_of(watch, JoystickPhase.FORBIDDEN, why="no permission") == forbidden
    assert told_of(watch, JoystickPhase.FORBIDDEN, why="no permission") == []
    lacking = [("pad is F310, it has no rightx", True)]
    assert told_of(watch, JoystickPhase.CONNECTED, why="it has no rightx") == lacking


def test_a_robot_that_cannot_be_followed_takes_no_other_away(caplog: pytest.LogCaptureFixture):
    watch, whole = ChangeNotifier(), Made().robot(link=Made.link(LinkPhase.CONNECTED))
    wrong = {CAPABILITY_REPORTS.name: received(None)}  # no value of this message
    robots = {"rover": whole.with_(name="rover", messages=wrong), "magellan": whole}
    state = ConsoleState(now=1.0, robots=robots)
    fault = ("its state cannot be compared with the last one; the log says why", True)
    assert texts(list(watch.look(state))) == [fault, ("linked", False)]
    assert watch.look(state) == ()
    assert len([record for record in caplog.records if record.exc_info]) == 1
