"""Inputs in words, as people call them, for the help and for lists."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

from rune_tui.layout.names import JOYSTICK, MOUSE, ONE_SIDED, PRESSED, ROLES
from rune_tui.layout.spec import ControlKind, ControlSpec, EventSpec, JoystickSpec

_MOUSE_WORDS = {"wheel": "mouse wheel", "motion": "mouse moves"}
_CONTROL_WORDS: Mapping[str, str] = {
    **{f"{side}{axis}": f"{side} stick" for side in ("left", "right") for axis in "xy"},
    **{f"{side}stick": f"{side} stick pressed" for side in ("left", "right")},
    **{
        f"{side}{what}": f"{side} {what}"
        for side in ("left", "right")
        for what in ("shoulder", "trigger")
    },
    **{f"dp{direction}": f"d-pad {direction}" for direction in ("up", "right", "down", "left")},
    **{f"button{number}": f"button {number}" for number in range(1, 33)},
    **{letter: letter.upper() for letter in "abxy"},
    "dpad": "hat",
}
"""Names of controls by role, for those without a name of their own."""
_SIDEWAYS, _UPRIGHT, _TURNED = ("right", "left"), ("up", "down"), ("clockwise", "counter-clockwise")
_AXIS_WORDS: Mapping[str, tuple[str, str]] = {
    **dict.fromkeys(("leftx", "rightx", "x", "rx"), _SIDEWAYS),
    **dict.fromkeys(("lefty", "righty", "y", "ry"), _UPRIGHT),
    "twist": _TURNED,
}
"""Where axes of a role or usage are moved for a positive and a negative value."""
_ANY_AXIS = ("one way", "the other way")


def ways(
    event: EventSpec, joysticks: Sequence[JoystickSpec], where: str = ""
) -> Iterator[tuple[str, EventSpec]]:
    """The use of an input, in words, and the event with its value.

    An axis has two directions.

    Args:
        event: The input.
        joysticks: Those of the layout.
        where: Where the mouse is meant.
    """
    if event.kind is not ControlKind.AXIS:
        yield _words(event, joysticks, where), event
        return
    name, control = _control(event, joysticks)
    if control.role in ONE_SIDED:
        yield name, event
        return
    for direction, sign in zip(_axis_words(control), (1.0, -1.0), strict=True):
        yield f"{name} {direction}", dataclasses.replace(event, value=sign * event.value)


def _words(event: EventSpec, joysticks: Sequence[JoystickSpec], where: str) -> str:
    if event.kind is not None:
        name, control = _control(event, joysticks)
        part = event.name.split(" ")[3:]
        if part == [PRESSED]:
            part = [] if control.role in ONE_SIDED else [" or ".join(_axis_words(control))]
        named = " ".join((name, *part))
    elif event.name.startswith(MOUSE):
        part_of_mouse = event.name.removeprefix(MOUSE)
        named = _MOUSE_WORDS.get(part_of_mouse, f"{part_of_mouse} click")
    else:
        named = event.name.upper() if len(event.name) == 1 else event.name
    place = where if event.name.startswith(MOUSE) else ""
    return f"{named} goes up{place}" if event.released else f"{named}{place}"


def _control(event: EventSpec, joysticks: Sequence[JoystickSpec]) -> tuple[str, ControlSpec]:
    """The name of a control, with its joystick, by the layout."""
    owner, name = event.name.removeprefix(JOYSTICK).split(" ")[:2]
    (joystick,) = (each for each in joysticks if each.name == owner)
    (control,) = (each for each in joystick.controls if each.name == name)
    own = name not in ROLES or control.role != name
    return f"{owner} {name if own else _CONTROL_WORDS.get(name, name)}", control


def _axis_words(control: ControlSpec) -> tuple[str, str]:
    positive, negative = _AXIS_WORDS.get(control.role or control.usage, _ANY_AXIS)
    return (negative, positive) if control.invert else (positive, negative)
