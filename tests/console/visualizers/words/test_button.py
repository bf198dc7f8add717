"""visualizeButton: what can be clicked at, and what it turns."""

from __future__ import annotations

import dataclasses

import pytest

from hub.gcm.navigation import Assistance
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.theme import DARK, LIGHT
from tests.console.visualizers.conftest import NOW, made_by, words

STATE = ConsoleState(now=NOW, chosen="magellan")


@pytest.fixture
def button(made, draw):
    """A button with this text and these options."""

    def show(text, size=(20, 6), *, state=STATE, age=0.1, assistance=Assistance.ON, **options):
        navigation = made.received(made.navigation(assistance=assistance), age)
        robot = made.robot(navigation=navigation)
        return draw("visualizeButton", robot, size, state=state, text=text, **options)

    return show


def said(canvas) -> str:
    return " ".join(" ".join(words(canvas)).split())


def test_a_button_says_its_text_amid_a_plate(button) -> None:
    assert words(button("HOME")) == ["", "        HOME", ""]


@pytest.mark.parametrize(
    ("shows", "changes", "before", "after"),
    [
        ("night", {"night": frozenset({"magellan"})}, "eye: off", "eye: on"),
        ("help", {"help": True}, "eye: off", "eye: on"),
        ("chosen", {"chosen": "blimp"}, "eye: on", "eye: off"),
    ],
)
def test_a_button_says_whether_what_it_turns_is_on(button, shows, changes, before, after) -> None:
    assert said(button("eye", shows=shows)) == before
    assert said(button("eye", shows=shows, state=dataclasses.replace(STATE, **changes))) == after


def test_a_button_of_the_assistance_says_what_the_robot_told(button) -> None:
    assert said(button("assist", shows="assistance")) == "assist: on"
    assert said(button("assist", shows="assistance", assistance=Assistance.OFF)) == "assist: off"


def test_what_the_robot_told_dims_when_old_and_counts_no_more_when_stale(button) -> None:
    fresh, old, stale = (button("assist", shows="assistance", age=age) for age in (0.9, 1.1, 3.1))
    assert said(fresh) == said(old)
    assert fresh.pixels.sum() > old.pixels.sum()
    assert said(stale) == "assist: ?"
    assert (button("HOME", age=9.0).pixels == button("HOME").pixels).all()


def test_a_button_looks_pressed_while_its_key_is_held(button) -> None:
    held = ConsoleState(now=NOW, held=("h",))
    assert said(button("HOME", state=held)) == "HOME"
    pressed = button("HOME", state=held, key="H")
    assert said(pressed) == "> HOME <"
    assert tuple(pressed.pixels[2, 2]) == DARK.ink


@pytest.mark.parametrize(
    ("width", "text"), [(20, "assist: on"), (9, "assist on"), (7, "assist+"), (4, "ass…")]
)
def test_the_state_is_said_in_the_room_there_is(button, width, text) -> None:
    assert said(button("assist", (width, 2), shows="assistance")) == text


def test_a_buttons_token_changes_with_its_face_only(made) -> None:
    shown = made_by("visualizeButton", text="assist", shows="assistance", key="x")

    def token(state=STATE, age=0.1, **changes):
        robot = made.robot(navigation=made.received(made.navigation(**changes), age))
        return shown.source(robot, state)

    assert token() == token(linear=0.5, age=0.2)
    tokens = {
        token(),
        token(age=1.5),
        token(age=3.5),
        token(assistance=Assistance.OFF),
        token(dataclasses.replace(STATE, held=("x",))),
        token(dataclasses.replace(STATE, theme=LIGHT)),
    }
    assert len(tokens) == 6
    assert token(dataclasses.replace(STATE, held=("y",))) == token()
