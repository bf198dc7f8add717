"""Every field of the console's own state comes back from a recording exactly."""

from __future__ import annotations

import dataclasses
import math
import typing
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.mapping import PointKind
from hub.gcm.vision import ImageCoding, ImageKind
from rune_tui.errors import LogError
from rune_tui.files.frame_log import OTHERWISE
from rune_tui.model.console_state import ConsoleState, Ghost, Notice, PictureWish
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from rune_tui.model.page import Page
from rune_tui.model.plain_values import from_json, to_json
from rune_tui.model.theme import RED
from rune_tui.model.world import DistanceSource, WorldPoint

HINTS = typing.get_type_hints(ConsoleState)
PLACE = WorldPoint(x=0.1, y=-2.0, uncertainty=1e-9, source=DistanceSource.MAP)
FULL = ConsoleState(
    now=1.0,
    held=("w", "ä"),
    must_release=("s",),
    tap_first=True,
    hold_s=1,
    looked={"blimp": 3.25},
    shown={"map": False},
    zooms={"map": 0.1 + 0.2},
    wishes={"blimp": PictureWish(kind=ImageKind.GREY, coding=ImageCoding.WEBP)},
    cameras={"blimp": "belly"},
    night=frozenset({"b", "a"}),
    trims={"blimp": {"yaw": -0.02}},
    speed_limits={"blimp": 0.25},
    theme=RED,
    notices=(Notice(text='it "is"\n', when=2.5, clock="12:00:00", alarm=True),),
    page=Page(top=3, search="x", typing=True),
    leaving=("a mission runs",),
    unconfirmed={(3, "blimp"): 2},
    overdue={(3, "blimp"): 1},
    ghosts={"blimp": Ghost(kind=PointKind.VICTIM, place=PLACE, until=math.inf)},
    sent_off={"blimp": 7.0},
    joysticks={
        "pad": JoystickState(
            name="pad",
            phase=JoystickPhase.CONNECTED,
            values={"leftx": -1.0},
            waiting=frozenset({"lefty"}),
            measured=None,
            absence=Absence.SILENT,
        )
    },
)


def same(one: Any, other: Any) -> bool:
    """Equal, and of the same kinds; NaN is itself."""
    return repr(one) == repr(other)


@pytest.mark.parametrize("name", sorted({*HINTS} - OTHERWISE))
@pytest.mark.parametrize("state", [ConsoleState(now=0.0), FULL], ids=["empty", "full"])
def test_each_field_comes_back_as_it_was(name: str, state: ConsoleState) -> None:
    value = getattr(state, name)
    back = from_json(HINTS[name], to_json(value))
    assert back == value or same(back, value)


def test_what_is_not_recorded_is_in_the_state() -> None:
    assert {each.name for each in dataclasses.fields(ConsoleState)} >= OTHERWISE


@given(st.floats())
def test_floats_are_exact(number: float) -> None:
    assert same(from_json(float, to_json(number)), number)


@given(st.text() | st.recursive(st.none() | st.booleans() | st.integers(), st.lists).map(str))
def test_other_texts_are_refused_by_our_error(text: str) -> None:
    for name in ("joysticks", "ghosts", "night", "notices", "page", "theme", "held"):
        try:
            from_json(HINTS[name], text)
        except LogError:
            continue


def test_a_deep_text_is_refused() -> None:
    with pytest.raises(LogError):
        from_json(HINTS["looked"], "[" * 100_000)
