"""The team view in text files: three robots, their alarms, and a peek, at every size of the layout.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/console
"""

from __future__ import annotations

import dataclasses
import math
import os
from typing import Any

import numpy as np

from hub.gcm.body import ROBOT_DESCRIPTION, Freedom, HoldKind, Motion
from hub.gcm.diagnostics import Diagnostics, DiagnosticStatus, Severity
from hub.gcm.flight import ALTITUDE, Altitude
from hub.gcm.imu import IMU, Imu
from hub.gcm.ranges import RANGES
from hub.gcm.vehicle import VEHICLE_STATE, HoldPhase, HoldState, VehicleState
from rune_tui.compositor.picture import plain_text
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ChooseRobot, Effect, Peek
from rune_tui.model.joystick_state import JoystickPhase, JoystickState
from rune_tui.model.robot_state import LinkPhase, Received, RobotState
from rune_tui.model.state_changes import changed
from rune_tui.model.theme import DARK
from rune_tui.view import View
from tests.console.dispatching import stops
from tests.console.situations import NOW, ROOT, robot, shipped
from tests.support.cases import for_each
from tests.support.magellan import magellan_body

SNAPSHOTS = ROOT / "tests" / "golden" / "team"
LAYOUT = shipped("land-sea-air")
SIZES = [(160, 48), (120, 40), (100, 30), (80, 24), (40, 12)]


def afloat(role: str, name: str, *freedoms: Freedom, **state: Any) -> RobotState:
    """A robot without wheels and ranges that holds its depth or height."""
    motions = tuple(Motion(freedom=each, limit=0.5, acceleration=0.5) for each in freedoms)
    body = dataclasses.replace(
        magellan_body(), name=name, kind=f"simulated-{name}", motions=motions, ranges=(), bumpers=()
    )
    messages = {
        ROBOT_DESCRIPTION.name: body,
        ALTITUDE.name: Altitude(stamp=0.0, climb=0.0, **state.pop("level")),
        IMU.name: Imu.of(roll=0.02, pitch=-0.05),
        VEHICLE_STATE.name: VehicleState(activity="holds", holds=state.pop("holds")),
    }
    made = robot(role, **state)
    known = {name: each for name, each in made.messages.items() if name != RANGES.name}
    received = {
        name: Received(value=value, measured=NOW - 0.1, number=1)
        for name, value in messages.items()
    }
    return made.with_(messages={**known, **received}, map=None)


def held(kind: HoldKind, target: float, phase: HoldPhase = HoldPhase.HOLDING) -> HoldState:
    return HoldState(kind=kind, phase=phase, target=target)


BLIMP = afloat(
    "blimp",
    "blimp",
    Freedom.SURGE,
    Freedom.HEAVE,
    Freedom.YAW,
    level={"above_ground": 1.24},
    holds=(held(HoldKind.HEIGHT, 1.2), held(HoldKind.HEADING, math.radians(56.0))),
    battery_fraction=0.15,
)
ROV = afloat(
    "submarine",
    "rov",
    Freedom.SURGE,
    Freedom.SWAY,
    Freedom.HEAVE,
    Freedom.YAW,
    level={"depth": 0.8},
    holds=(held(HoldKind.DEPTH, 1.5, HoldPhase.FAILING),),
)
NOT_HELD = DiagnosticStatus(
    level=Severity.WARN, name="hold depth", message="does not hold its depth: 0.7 m too high"
)
ROV = ROV.with_(
    diagnostics={
        5: Received(value=Diagnostics(status=(NOT_HELD,)), measured=NOW - 0.1, number=1),
    }
)
LOST = robot("rover", age=7.0, phase=LinkPhase.LOST, since=NOW - 7.0)


def state(*robots: RobotState) -> ConsoleState:
    start = dataclasses.replace(
        ConsoleState.at_start(LAYOUT, NOW - 14.0, "ada"),
        robots={each.name: each for each in robots},
        releases_reported=True,
    )
    return dataclasses.replace(changed(start, ChooseRobot(robot="blimp")), now=NOW)


CALM = state(robot("rover"), BLIMP, ROV)
SCENES = {
    "alarms": state(LOST, BLIMP, ROV),
    "peek": changed(CALM, Peek(robot="submarine")),
}


def drawn(shown: ConsoleState, size: tuple[int, int]) -> str:
    view = View(LAYOUT, spent=lambda: 0.0)
    view.resize(*size)
    cells = view.render(shown)
    assert cells is not None
    return plain_text(cells)


@for_each("size", SIZES)
@for_each("scene", sorted(SCENES))
def test_the_team_looks_as_it_did(scene: str, size: tuple[int, int]) -> None:
    text = drawn(SCENES[scene], size)
    path = SNAPSHOTS / f"{scene}-{size[0]}x{size[1]}.txt"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    assert text == path.read_text()


@for_each("size", SIZES)
def test_the_team_and_its_alarms_are_in_sight_at_every_size(size: tuple[int, int]) -> None:
    for cover in ({}, {"full": "camera"}, {"help": True}):
        text = drawn(dataclasses.replace(SCENES["alarms"], **cover), size).replace(".", " ")
        assert "LINK LOST" in text, cover
        assert "BATTERY LOW" in text or "▶ blimp !" in text, cover
        if size[0] >= 100 or (size[0] >= 80 and not cover):
            assert all(name in text for name in ("magellan", "blimp", "rov")), cover


def test_a_hold_that_fails_is_an_alarm_with_the_name_of_its_robot() -> None:
    view = View(LAYOUT, spent=lambda: 0.0)
    view.resize(120, 40)
    for chosen, answered in (("rover", False), ("submarine", True)):
        cells = view.render(changed(CALM, ChooseRobot(robot=chosen)))
        assert cells is not None
        (entry,) = (each for each in view.attention if each.cause == "hold depth")
        assert (entry.robot, entry.answered) == ("submarine", answered)
        strip = plain_text(cells).splitlines()[3]
        assert "rov" in strip
        assert "! does not hold its depth" in strip


@for_each("size", SIZES)
def test_a_peek_is_said_beside_the_picture(size: tuple[int, int]) -> None:
    assert "PEEK" not in drawn(CALM, size)
    assert "PEEK" in drawn(SCENES["peek"], size)
    *_, status = drawn(changed(SCENES["alarms"], Peek(robot="submarine")), size).splitlines()
    assert "PEEK" in status, "the banner covers the title of the picture"


@for_each("chosen", ["rover", "blimp", "submarine"])
@for_each("size", SIZES)
def test_the_keys_that_the_console_waits_for_are_said_at_every_size(
    chosen: str, size: tuple[int, int]
) -> None:
    keys = "LET GO OF pageup w"
    whole = {False: f"{keys} FOR 1 s FIRST", True: f"{keys}, TAP, THEN HOLD"}
    for tap_first, words in whole.items():
        shown = dataclasses.replace(
            changed(CALM, ChooseRobot(robot=chosen)),
            must_release=("pageup", "w"),
            tap_first=tap_first,
            releases_reported=False,
        )
        *_, status = drawn(shown, size).splitlines()
        assert (words if size[0] >= 80 else keys) in status
    waiting = JoystickState(name="pad", phase=JoystickPhase.CONNECTED, waiting=frozenset({"lefty"}))
    *_, status = drawn(dataclasses.replace(CALM, joysticks={"pad": waiting}), size).splitlines()
    assert "pad LET GO OF lefty FIRST" in status


def test_the_alarm_of_another_robot_covers_one_row_of_the_picture() -> None:
    plates = {}
    for chosen in ("blimp", "rover"):
        shown = changed(SCENES["alarms"], ChooseRobot(robot=chosen))
        view = View(LAYOUT, spent=lambda: 0.0)
        view.resize(160, 48)
        cells = view.render(shown)
        assert cells is not None
        red = np.all(cells.pixels[:, 0, :3] == DARK.alarm[:3], axis=1)
        plates[chosen] = int(red.sum()) // 2
    assert plates == {"blimp": 1, "rover": 3}


def pressed(dispatch: Dispatch, name: str, shown: ConsoleState) -> tuple[Effect, ...]:
    return dispatch.handle(ControlEvent(name=name, pressed=True), shown)


def test_a_gamepad_chooses_goes_to_the_next_alarm_and_stops() -> None:
    dispatch, view = Dispatch(LAYOUT), View(LAYOUT, spent=lambda: 0.0)
    view.resize(120, 40)
    view.render(SCENES["alarms"])
    shown = dataclasses.replace(SCENES["alarms"], attention=view.attention)
    choices = {"rightshoulder": "submarine", "leftshoulder": "rover"}
    for button, robot_after in choices.items():
        (choice,) = pressed(dispatch, f"joystick pad {button}", shown)
        assert isinstance(choice, ChooseRobot)
        assert changed(shown, choice).chosen == robot_after
    assert stops(pressed(dispatch, "joystick pad b", shown)) == ["blimp"]
    assert stops(pressed(dispatch, "joystick pad x", shown)) == ["rover", "blimp", "submarine"]


def test_space_stops_the_chosen_robot_shift_and_a_digit_one_and_zero_all() -> None:
    dispatch = Dispatch(LAYOUT)
    assert stops(pressed(dispatch, "space", CALM)) == ["blimp"]
    assert stops(pressed(dispatch, "0", CALM)) == ["rover", "blimp", "submarine"]
    for role, keys in {"rover": "!", "blimp": '@"', "submarine": "#£§"}.items():
        for key in keys:
            assert stops(pressed(dispatch, key, CALM)) == [role]


def test_keys_of_freedoms_that_the_robot_lacks_are_not_in_the_legend() -> None:
    wide = (200, 48)
    legends = []
    for name in ("rover", "blimp", "submarine"):
        shown = changed(CALM, ChooseRobot(robot=name))
        legends.append(drawn(shown, wide).splitlines()[0])
    assert ["climb" in each for each in legends] == [False, True, True]
    assert ["sideways" in each for each in legends] == [False, False, True]
