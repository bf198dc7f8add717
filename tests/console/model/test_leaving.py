"""The console asks before it ends if something would be lost, or go on with nobody at it."""

from __future__ import annotations

import dataclasses

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotState
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.navigation import MotionState
from hub.gcm.vehicle import VEHICLE_STATE, Arming, VehicleState
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskToLeave
from rune_tui.model.leaving import ORDERED_S, question, reasons_to_stay
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from rune_tui.model.state_changes import changed
from tests.console.states import robot_of
from tests.console.visualizers.conftest import received
from tests.support.cases import for_each
from tests.support.messages import robot_state

MINE, OTHERS = 7, 8


def robot(motion: MotionState, owner: int = MINE) -> RobotState:
    control = ControlState(owner=owner)
    return robot_of(
        name="magellan",
        link=LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="", number=MINE),
        navigation=Received(value=robot_state(motion=motion), measured=0.0, number=1),
        messages={CONTROL_STATE.name: Received(value=control, measured=0.0, number=1)},
    )


def reasons(motion: MotionState = MotionState.STANDING, owner: int = MINE, **changes: str):
    state = ConsoleState(now=0.0, robots={"magellan": robot(motion, owner)})
    return reasons_to_stay(dataclasses.replace(state, **changes))


def test_nothing_speaks_against_the_end_of_a_console_whose_robot_stands():
    assert reasons() == ()
    assert reasons_to_stay(ConsoleState(now=0.0)) == ()


def test_a_recording_and_a_robot_that_goes_by_itself_do():
    assert reasons(recording="run.mcap") == ("the recording ends",)
    (alone,) = reasons(MotionState.GOING)
    assert alone == "magellan goes on by itself, and nobody watches it"
    assert len(reasons(MotionState.GOING, recording="run.mcap")) == 2


@for_each("motion", [each for each in MotionState if each is not MotionState.GOING])
def test_a_robot_that_its_operator_drives_stops_by_itself(motion: MotionState):
    assert reasons(motion) == ()


def test_what_another_console_has_the_robot_do_is_its_own_matter():
    assert reasons(MotionState.GOING, OTHERS) == ()


def armed(owner: int, **vehicle: Arming) -> tuple[str, ...]:
    known = robot(MotionState.STANDING, owner)
    messages = {
        **known.messages,
        AUTOPILOT_STATE.name: received(AutopilotState()),
        VEHICLE_STATE.name: received(VehicleState(**vehicle)),
    }
    keys = {(Purpose.DISARM, "magellan"): "f9"}
    robots = {"magellan": known.with_(messages=messages)}
    return reasons_to_stay(ConsoleState(now=0.0, robots=robots, inputs=keys))


def test_a_vehicle_that_stays_armed_speaks_against_the_end():
    assert armed(MINE, arming=Arming.ARMED) == (
        "magellan STAYS ARMED, and nobody drives it (F9 disarms it)",
    )
    assert armed(MINE, arming=Arming.DISARMED) == armed(OTHERS, arming=Arming.ARMED) == ()


def test_the_question_says_what_happens_and_how_to_answer():
    assert question(()) == ""
    assert question(("the recording ends",)) == (
        "QUIT? Then the recording ends. Q or enter: quit. Any other key: stay."
    )


def test_the_question_comes_before_the_help():
    helped = ConsoleState(now=0.0, help=True)
    asked = changed(helped, AskToLeave(reasons=("the recording ends",)))
    assert (asked.leaving, asked.help) == (("the recording ends",), False)
    assert changed(asked, AskToLeave(reasons=())).leaving == ()


def test_a_robot_that_was_just_sent_off_counts_as_going_before_it_reports_so():
    state = ConsoleState(now=10.0, robots={"magellan": robot(MotionState.STANDING)})
    sent = dataclasses.replace(state, sent_off={"magellan": 10.0 - 0.9 * ORDERED_S})
    assert len(reasons_to_stay(sent)) == 1
    long_ago = dataclasses.replace(state, sent_off={"magellan": 10.0 - 1.1 * ORDERED_S})
    assert reasons_to_stay(long_ago) == ()
