"""Keys of a vehicle with an autopilot."""

from __future__ import annotations

import dataclasses

from hub.gcm.autopilot import AutopilotPhase, AutopilotState
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.vehicle import VEHICLE_STATE, Arming, VehicleCommand, VehicleOrder, VehicleState
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseRobot, Effect, Notify, SendEffect
from rune_tui.model.state_changes import changed
from rune_tui.widgets.registry import WIDGETS
from rune_tui.widgets.vehicle import AGAIN_S
from rune_tui.widgets.widget import Widget
from tests.console.visualizers.conftest import received
from tests.console.widgets.presses import down, event_spec, widget_of
from tests.support.autopilot import piloted, rover
from tests.support.car import CAR

KEY = event_spec("x")
NEXT = dataclasses.replace(KEY, control="next")
SET = dataclasses.replace(KEY, control="set")


def state(autopilot: AutopilotState | None, now: float = 1.0) -> ConsoleState:
    return ConsoleState(now=now, robots={"magellan": piloted(autopilot)}, chosen="magellan")


def orders(effects: tuple[Effect, ...]) -> list[tuple[VehicleOrder, str]]:
    sent = [effect.value for effect in effects if isinstance(effect, SendEffect)]
    return [(each.order, each.name) for each in sent if isinstance(each, VehicleCommand)]


def ordered(order: str, at: ConsoleState) -> list[tuple[VehicleOrder, str]]:
    return orders(widget_of("widgetAutopilot", "*", order=order).handle(down("x"), KEY, at))


def test_it_is_asked_to_follow_and_to_stay() -> None:
    for phase in (AutopilotPhase.DRIVING, AutopilotPhase.ELSEWHERE, AutopilotPhase.GONE):
        assert ordered("drive", state(rover(phase=phase))) == [(VehicleOrder.DRIVE, "")]
    assert ordered("hold", state(rover())) == [(VehicleOrder.STAY, "")]


def test_an_order_that_would_change_nothing_is_said_instead() -> None:
    assert ordered("drive", state(rover(phase=AutopilotPhase.DISARMED))) == []
    assert ordered("hold", state(rover(holds=""))) == []
    for order in ("drive", "hold"):
        assert ordered(order, state(None)) == []


def press(widget: Widget, event: EventSpec, at: ConsoleState) -> tuple[list[str], list[str]]:
    """The questions on the screen, and the modes that are asked for."""
    effects = widget.handle(down("x"), event, at)
    asks = [e.notice.text for e in effects if isinstance(e, Notify) and e.notice.question_s]
    modes = [name for order, name in orders(effects) if order is VehicleOrder.MODE]
    return [text.partition("?")[0] for text in asks], modes


def widget_with_keys() -> Widget:
    spec = widget_of("widgetMode", "*").spec  # type: ignore[attr-defined]
    keys = (dataclasses.replace(NEXT, name="f2"), dataclasses.replace(SET, name="f3"))
    return WIDGETS["widgetMode"].from_spec(dataclasses.replace(spec, events=keys), "*")


def test_arming_what_is_armed_names_the_key_that_lets_it_follow() -> None:
    for phase, words in (
        (AutopilotPhase.DRIVING, "it is armed already"),
        (AutopilotPhase.ELSEWHERE, "it is armed already: F asks it to follow you"),
    ):
        at = state(rover(phase=phase))
        robot = at.robots["magellan"]
        messages = {
            **robot.messages,
            ROBOT_DESCRIPTION.name: received(dataclasses.replace(CAR, arms=1)),
            VEHICLE_STATE.name: received(VehicleState(arming=Arming.ARMED)),
        }
        robots = {"magellan": robot.with_(messages=messages)}
        keys = {(Purpose.FOLLOW, "magellan"): "F"}
        at = dataclasses.replace(at, robots=robots, inputs=keys)
        (said,) = widget_of("widgetArm", "*").handle(down("x"), KEY, at)
        assert isinstance(said, Notify)
        assert said.notice.text == words


def test_a_mode_is_shown_first_and_set_by_another_key() -> None:
    widget = widget_of("widgetMode", "*")
    known = state(rover())
    assert press(widget, SET, known) == ([], []), "nothing was shown"
    (hint,) = widget_with_keys().handle(down("f3"), SET, known)
    assert isinstance(hint, Notify)
    assert hint.notice.text == "F2 shows a mode first"
    assert press(widget, NEXT, known) == (["MODE hold"], [])
    assert press(widget, NEXT, known) == (["MODE loiter"], [])
    assert press(widget, NEXT, known) == (["MODE hold"], []), "not the present one"
    assert press(widget, SET, known) == ([], ["hold"])
    assert press(widget, SET, known) == ([], []), "once"


def test_a_mode_that_was_shown_is_forgotten() -> None:
    widget = widget_of("widgetMode", "*")
    press(widget, NEXT, state(rover()))
    assert press(widget, SET, state(rover(), now=1.1 + AGAIN_S)) == ([], []), "too late"
    press(widget, NEXT, state(rover(), now=10.0))
    without = state(rover(modes=("guided", "loiter")), now=10.1)
    assert press(widget, SET, without) == ([], []), "it is no longer offered"
    press(widget, NEXT, state(rover(), now=20.0))
    left = changed(state(rover(), now=20.5), ChooseRobot(robot="other"))
    back = changed(dataclasses.replace(left, now=20.6), ChooseRobot(robot="magellan"))
    assert press(widget, SET, back) == ([], []), "the operator looked at another robot"


def test_without_modes_nothing_is_shown() -> None:
    widget = widget_of("widgetMode", "*")
    for known in (None, rover(modes=())):
        assert press(widget, NEXT, state(known)) == ([], [])
    only = state(rover(modes=("guided",)))
    assert press(widget, NEXT, only) == (["MODE guided"], [])
