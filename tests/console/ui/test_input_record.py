"""A recording says of each input what became of it."""

from __future__ import annotations

import dataclasses

import pytest

from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.dispatch import Dispatch
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.own_records import RUNE_INPUT, InputOutcome, InputRecord
from rune_tui.model.robot_state import LinkPhase, LinkState, RobotState
from rune_tui.ui.input_record import input_record
from tests.console.dispatching import DEMO, down

ROBOT = DEMO.robots[0].name


def state_of(phase: LinkPhase = LinkPhase.CONNECTED, **changes: object) -> ConsoleState:
    robot = RobotState(name=ROBOT, link=LinkState(phase=phase, since=0.0, endpoint="here"))
    state = dataclasses.replace(ConsoleState.at_start(DEMO, 5.0), robots={ROBOT: robot})
    return dataclasses.replace(state, **changes)  # type: ignore[arg-type]  # of several types


def recorded(event: ControlEvent, state: ConsoleState) -> InputRecord:
    dispatch = Dispatch(DEMO)
    effects = dispatch.handle(event, state)
    return input_record(event, dispatch.listeners.of(event), effects, state, 4.5)


@pytest.mark.parametrize(
    ("event", "state", "outcome"),
    [
        (down("w"), state_of(), InputOutcome.SENT),
        (down("space"), state_of(), InputOutcome.SENT),
        (down("w"), state_of(LinkPhase.LOST), InputOutcome.REFUSED),
        (dataclasses.replace(down("w"), stale=True), state_of(), InputOutcome.REFUSED),
        (down("w"), state_of(help=True), InputOutcome.DEAF),
        (dataclasses.replace(down("w"), must_release_first=True), state_of(), InputOutcome.DEAF),
        (down("f1"), state_of(), InputOutcome.NONE),
        (down("ö"), state_of(), InputOutcome.NONE),
    ],
    ids=["drives", "stops", "no link", "stale", "page", "held", "console", "unbound"],
)
def test_the_outcome_of_an_input(
    event: ControlEvent, state: ConsoleState, outcome: InputOutcome
) -> None:
    record = recorded(event, state)
    assert (record.input, record.outcome, record.t_read) == (event.name, outcome, 4.5)
    assert RUNE_INPUT.decode(b"".join(map(bytes, RUNE_INPUT.encode(record)))).outcome is outcome


def test_the_widgets_and_the_robot_of_an_input() -> None:
    record = recorded(down("w"), state_of())
    assert (record.handlers, record.robot) == (("widgetSetSpeed",), ROBOT)


def test_the_place_of_the_mouse() -> None:
    hit = Hit(viewport="camera", x=0.25, y=0.5, robot=ROBOT, in_picture=(0.1, 0.2))
    record = recorded(ControlEvent(name="mouse middle", pressed=True, hits=(hit,)), state_of())
    place = record.viewport, record.x, record.y, record.in_picture, record.robot
    assert place == ("camera", 0.25, 0.5, True, ROBOT)
