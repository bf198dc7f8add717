"""Which control is the left stick, the trigger, the twist: guessed from usages and from profiles.

The guess follows the common order of gamepads: of 95 sticks and triggers of real devices it names
94 as SDL's database of game controllers does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rune_tui.controls.hid import usages
from rune_tui.controls.hid.channels import Channel
from rune_tui.controls.hid.profiles import find_profile
from rune_tui.layout.spec import ControlKind

Axes = Mapping[str, Channel]

_OTHERS = {
    "hat switch": "dpad",
    "d-pad up": "dpup",
    "d-pad down": "dpdown",
    "d-pad left": "dpleft",
    "d-pad right": "dpright",
    "main menu": "guide",
    "start": "start",
    "select": "back",
    "back": "back",
    "home": "guide",
} | {f"button {number}": f"button{number}" for number in range(1, 33)}
_STICKS_ONLY = frozenset({"slider", "throttle", "rudder"})
"""Usages that no gamepad has."""


def find_roles(channels: Sequence[Channel], *, vid: int, pid: int) -> tuple[str, ...]:
    """The role of each control, "" for none; no role is given twice."""
    axes = {each.name: each for each in channels if each.kind is ControlKind.AXIS}
    guessed = _OTHERS | {name: role for role, name in _axis_roles(axes).items()}
    pedals = {"accelerator", "brake"} <= axes.keys()
    known = find_profile(vid, pid, gamepad=pedals and _application(channels) == usages.GAMEPAD)
    roles = [""] * len(channels)
    # A trigger that is an axis and a button too is the axis; the button keeps its number. Of two
    # axes with the same usage the profile knows which one is meant.
    for position in sorted(
        range(len(channels)),
        key=lambda each: (
            channels[each].kind is not ControlKind.AXIS,
            channels[each].name not in known,
        ),
    ):
        name = channels[position].name
        wanted = (known.get(name, ""), guessed.get(name, ""))
        roles[position] = next((role for role in wanted if role not in roles), "")
    return tuple(roles)


def _application(channels: Sequence[Channel]) -> int:
    return channels[0].field.application if channels else 0


def _axis_roles(axes: Axes) -> dict[str, str]:
    """The axis of each role."""
    application = _application(list(axes.values()))
    if application == usages.MULTI_AXIS:
        roles = {"leftx": "x", "lefty": "y", "twist": "rz"}
    elif application == usages.JOYSTICK and _is_flight_stick(axes):
        roles = {"leftx": "x", "lefty": "y"} | _lever_roles(axes)
    else:
        roles = {"leftx": "x", "lefty": "y"} | _right_roles(axes)
    if "x" not in axes and "steering" in axes:
        roles["leftx"] = "steering"
    return {role: name for role, name in roles.items() if name in axes}


def _is_flight_stick(axes: Axes) -> bool:
    pad = {"z", "rz"} <= axes.keys() or {"rx", "ry"} <= axes.keys()
    return not pad or not _STICKS_ONLY.isdisjoint(axes)


def _lever_roles(axes: Axes) -> dict[str, str]:
    """Twist and throttle; the slider of a stick that has a z is a small one beside it."""
    throttle = next((name for name in ("throttle", "z", "slider") if name in axes), "")
    twist = "rz" if "rz" in axes else "rudder"
    return {
        "twist": twist,
        "throttle": throttle,
        "lefttrigger": "brake",
        "righttrigger": "accelerator",
    }


def _right_roles(axes: Axes) -> dict[str, str]:
    """The right stick and the triggers of a gamepad."""
    z_pair, r_pair = ("z", "rz"), ("rx", "ry")
    has_z, has_r = (set(pair) <= axes.keys() for pair in (z_pair, r_pair))
    if "accelerator" in axes or "brake" in axes or not (has_z and has_r):
        stick = z_pair if has_z else r_pair
        triggers = ("brake", "accelerator")
    elif _like_left_stick(axes, "rx") and not _like_left_stick(axes, "z"):
        stick, triggers = r_pair, z_pair
    else:
        stick, triggers = z_pair, r_pair
    return dict(
        zip(("rightx", "righty", "lefttrigger", "righttrigger"), stick + triggers, strict=True)
    )


def _like_left_stick(axes: Axes, name: str) -> bool:
    """Whether an axis has the size and range of the left stick's."""
    first, other = axes.get("x"), axes[name]
    return first is not None and (first.field.size, first.minimum, first.maximum) == (
        other.field.size,
        other.minimum,
        other.maximum,
    )
