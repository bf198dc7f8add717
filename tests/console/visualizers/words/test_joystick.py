"""visualizeJoystick, and what the status line says of joysticks: all in words."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from rune_tui.visualizers.words.joystick import bar
from tests.console.visualizers.conftest import NOW, Draw, Made, made_by, words
from tests.support.cases import for_each

NAME = "visualizeJoystick"


def knows(**joystick: Any) -> ConsoleState:
    state = JoystickState(**{"name": "pad", "device": "F310", **joystick})
    return ConsoleState(now=NOW, joysticks={"pad": state})


CONNECTED = JoystickPhase.CONNECTED
GONE_THERE = {"phase": JoystickPhase.MISSING, "machine": "desk"}


def test_the_device_and_each_control_are_shown_with_bar_and_number(made: Made, draw: Draw) -> None:
    state = knows(phase=CONNECTED, values={"lefty": 0.5, "leftx": -1.0, "b": 0.0})
    assert words(draw(NAME, made.robot(), (40, 8), state=state)) == [
        "pad F310: plugged in",
        "lefty ·········┃████····· +0.50",
        "leftx █████████┃········· -1.00",
        "b     ·········┃········· +0.00",
    ]


@given(value=st.floats(-1.0, 1.0), length=st.integers(3, 40))
def test_a_bar_is_as_long_as_it_may_be_and_shows_the_side(value: float, length: int) -> None:
    drawn = bar(value, length)
    left, right = drawn.split("┃")
    assert len(left) == len(right) == (length - 1) // 2
    assert "█" not in (right if value < 0 else left)


@for_each(
    ("joystick", "said"),
    [
        ({"phase": JoystickPhase.MISSING}, "pad F310: UNPLUGGED"),
        ({"phase": JoystickPhase.MISSING, "device": ""}, "pad: not plugged in"),
        ({**GONE_THERE, "absence": Absence.SILENT}, "pad F310: SILENT"),
        ({**GONE_THERE, "absence": Absence.ENDED}, "pad F310: ENDED there"),
        ({**GONE_THERE, "absence": Absence.UNPLUGGED}, "pad F310: UNPLUGGED there"),
        ({"phase": JoystickPhase.FORBIDDEN, "why": "put it there"}, "pad F310: NO PERMISSION"),
        ({"phase": JoystickPhase.UNSUITABLE, "why": "no joystick"}, "pad F310: UNUSABLE"),
        ({"phase": CONNECTED, "why": "it has no a"}, "pad F310: it has no a"),
        ({"phase": CONNECTED, "waiting": frozenset("yx")}, "pad F310: LET GO OF x, y FIRST"),
    ],
)
def test_what_is_wrong_is_said_in_words_there_and_in_the_status_line(
    made: Made, draw: Draw, joystick: dict[str, Any], said: str
) -> None:
    state = knows(**joystick)
    shown = words(draw(NAME, made.robot(), (60, 8), state=state))
    assert shown[0] == said
    if joystick.get("why") and joystick["phase"] is not CONNECTED:
        assert shown[1] == joystick["why"]
    status = words(draw("visualizeStatus", made.robot(), (200, 2), state=state))[0]
    assert f"pad {said.partition(': ')[2]}" in status


def test_the_status_line_is_silent_while_all_is_well(made: Made, draw: Draw) -> None:
    status = words(draw("visualizeStatus", made.robot(), (200, 2), state=knows(phase=CONNECTED)))[0]
    assert "pad" not in status


def test_a_joystick_that_the_layout_does_not_have_is_named(made: Made, draw: Draw) -> None:
    state = knows(phase=CONNECTED)
    assert words(draw(NAME, made.robot(), (40, 2), state=state, joystick="pod")) == [
        "the layout has no joystick pod"
    ]
    assert words(draw(NAME, made.robot(), (40, 2), state=ConsoleState(now=NOW)))[0].endswith(
        "no joystick"
    )


def test_the_picture_changes_with_what_is_seen_and_not_with_less(made: Made) -> None:
    shown, robot = made_by(NAME), made.robot()
    one = shown.source(robot, knows(phase=CONNECTED, values={"x": 0.500}))
    assert one == shown.source(robot, knows(phase=CONNECTED, values={"x": 0.501}))
    assert one != shown.source(robot, knows(phase=CONNECTED, values={"x": 0.510}))
    assert one != shown.source(robot, knows(values={"x": 0.500}))


def test_several_lost_joysticks_leave_room_for_the_rest_of_the_status_line(
    made: Made, draw: Draw
) -> None:
    lost = {
        name: JoystickState(name=name, device="F310", phase=JoystickPhase.MISSING)
        for name in ("left", "right", "third")
    }
    state = ConsoleState(now=NOW, joysticks=lost)
    (line,) = words(draw("visualizeStatus", made.robot(), (100, 2), state=state))[:1]
    assert "3 joysticks UNPLUGGED" in line
    assert "STANDING" in line


@pytest.mark.parametrize(("age", "said"), [(0.0, "0.00"), (0.02, "0.00"), (0.13, "0.15")])
def test_what_comes_from_another_machine_has_its_age_in_steps(
    made: Made, draw: Draw, age: float, said: str
) -> None:
    state = knows(phase=CONNECTED, machine="desk", measured=NOW - age)
    assert words(draw(NAME, made.robot(), (40, 4), state=state)) == [
        "pad F310: plugged in",
        f"what it says is {said} s old",
    ]
    source = made_by(NAME).source(made.robot(), state)
    young = knows(phase=CONNECTED, machine="desk", measured=NOW)
    assert (source == made_by(NAME).source(made.robot(), young)) == (said == "0.00")
