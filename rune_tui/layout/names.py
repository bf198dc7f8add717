"""The names that every layout may use: capabilities, and inputs of all kinds."""

from __future__ import annotations

import string
import unicodedata
from collections.abc import Mapping

from hub.gcm.capability import Capability
from rune_tui.layout.spec import ControlKind

_INTERVALS_MS = {
    Capability.CON_REAL: 6_000,
    Capability.VIS_VID: 10,
    Capability.NAV_STATE: 10,
    Capability.PRO_MAP: 10_000,
}
CAPABILITY_INTERVALS_MS: Mapping[str, int] = {
    capability.value: _INTERVALS_MS.get(capability, 0) for capability in Capability
}
"""Known capabilities and their shortest time between two requests [ms]."""

MOUSE = "mouse "
"""Prefix of the mouse's inputs; no key's name has it."""

JOYSTICK = "joystick "
"""Prefix of joysticks' inputs; no key's name has it."""
DIRECTIONS = ("up", "right", "down", "left")
"""Where a hat switch can be pushed, in the order of a layout's bindings."""
PRESSED = "pressed"
"""Suffix of an axis that acts as a button."""

TRIGGERS = frozenset({"lefttrigger", "righttrigger"})
"""Roles of axes that are buttons on some pads."""
ONE_SIDED = TRIGGERS | {"throttle"}
"""Roles of axes that go from 0 to 1; all others go from -1 to 1."""
ROLES: Mapping[str, ControlKind] = {
    **dict.fromkeys(("leftx", "lefty", "rightx", "righty"), ControlKind.AXIS),
    **dict.fromkeys(("lefttrigger", "righttrigger", "twist", "throttle"), ControlKind.AXIS),
    **dict.fromkeys(("a", "b", "x", "y", "back", "guide", "start"), ControlKind.BUTTON),
    **dict.fromkeys(("leftshoulder", "rightshoulder"), ControlKind.BUTTON),
    **dict.fromkeys(("leftstick", "rightstick"), ControlKind.BUTTON),
    **dict.fromkeys(("dpup", "dpdown", "dpleft", "dpright"), ControlKind.BUTTON),
    **{f"button{number}": ControlKind.BUTTON for number in range(1, 33)},
    "dpad": ControlKind.HAT,
}
"""Roles of controls, for any device. Of axes, x is positive to the right, y up or away
from the operator, twist clockwise."""

AXIS_USAGES = (
    *("x", "y", "z", "rx", "ry", "rz", "slider", "dial", "wheel"),
    *("vx", "vy", "vz", "vbrx", "vbry", "vbrz", "vno"),
    *("aileron", "aileron trim", "anti-torque", "collective", "dive brake", "elevator"),
    *("elevator trim", "rudder", "throttle", "toe brake", "wing flaps", "accelerator", "brake"),
    *("clutch", "shifter", "steering", "dive plane", "ballast"),
)
"""Names of axes and balls at devices."""
HAT_USAGE = "hat switch"
"""Names of hats at devices."""

NAMED_KEYS = (
    *("up", "down", "left", "right", "space", "enter", "escape", "tab", "backspace"),
    *("home", "end", "pageup", "pagedown", "insert", "delete"),
)
FUNCTION_KEYS = tuple(f"f{number}" for number in range(1, 13))

WAY_OUT = "ctrl+c"
"""The key that ends the console, with any layout."""

KEYS_REPORTED_AS: Mapping[str, str] = {
    "ctrl+h": "backspace",
    "ctrl+i": "tab",
    "ctrl+m": "enter",
}
"""Keys that a terminal cannot distinguish from others, and its report instead."""

CONTROL_KEYS = tuple(
    key for letter in string.ascii_lowercase if (key := f"ctrl+{letter}") not in KEYS_REPORTED_AS
)
_PAD_MARKS = ("decimal", "divide", "multiply", "subtract", "add", "enter", "equal")
_PAD_MOVES = ("left", "right", "up", "down", "pageup", "pagedown", "home", "end", "insert")
KEYPAD_KEYS: Mapping[str, str] = {
    **{f"kp_{digit}": digit for digit in string.digits},
    **dict(zip((f"kp_{mark}" for mark in _PAD_MARKS), (*"./*-+", "enter", "="), strict=True)),
    **{f"kp_{move}": move for move in (*_PAD_MOVES, "delete")},
}
"""Keys of the keypad, and the report of terminals that cannot distinguish them."""
MODIFIER_KEYS = tuple(
    f"{side}_{name}" for side in ("left", "right") for name in ("shift", "control", "alt", "super")
)
RARE_KEYS: Mapping[str, str] = {
    **KEYPAD_KEYS,
    **dict.fromkeys(MODIFIER_KEYS, ""),
    **{f"f{number}": "" for number in range(13, 25)},
}
"""Keys that only terminals with the kitty keyboard protocol report, and the others' report."""

SHIFT, ALT = "shift+", "alt+"
_MOVED_KEYS = ("up", "down", "left", "right", "home", "end", "pageup", "pagedown", "delete")
SHIFT_KEYS = tuple(
    SHIFT + key for key in (*string.ascii_lowercase, *_MOVED_KEYS, "tab", *FUNCTION_KEYS)
)
"""Keys with Shift that every terminal reports; digits and marks with Shift are other characters."""
ALT_KEYS = tuple(
    ALT + key
    for key in (*string.ascii_lowercase, *_MOVED_KEYS, *FUNCTION_KEYS)
    if key not in {"b", "f"}
)
"""Keys with Alt that every terminal reports; B and F look like arrows with Ctrl in some."""
KEYS = (*NAMED_KEYS, *FUNCTION_KEYS, *CONTROL_KEYS, *SHIFT_KEYS, *ALT_KEYS, *RARE_KEYS)
"""Keys with a name; every single printable character in lower case is a key as well."""

_SHORT_NAMES = {
    "solidus": "slash",
    "reverse_solidus": "backslash",
    "commercial_at": "at",
    "hyphen_minus": "minus",
    "plus_sign": "plus",
    "low_line": "underscore",
}


def _long_name(character: str) -> str:
    """The name that Textual gives a punctuation mark: its Unicode name, some shortened."""
    name = unicodedata.name(character).lower().replace("-", "_").replace(" ", "_")
    return _SHORT_NAMES.get(name, name)


KEY_ALIASES: Mapping[str, str] = {_long_name(mark): mark for mark in string.punctuation}
"""Long names of punctuation keys, such as "plus" for "+"."""

KEY_RULE = (
    "a key is one printable character in lower case, ctrl+ and a letter, alt+ and a letter "
    "but b and f, shift+ and a letter, shift+ or alt+ and an arrow, home, end, pageup, pagedown, "
    "delete or f1 to f12, shift+tab, f1 to f24, kp_ and a key "
    "of the keypad, left_ or right_ and shift, control, alt or super, or one of "
    + ", ".join(NAMED_KEYS)
)


def canonical_key(name: str) -> str:
    """The one name of a key with several names: "+" for "plus", "space" for " ", "w" for "W"."""
    if name == " ":
        return "space"
    name = KEY_ALIASES.get(name, name)
    lower = name.lower()
    return lower if len(lower) == len(name) else name


def is_key(name: str) -> bool:
    """Whether a layout may name this key."""
    if name in KEYS or name in KEY_ALIASES:
        return True
    return len(name) == 1 and name.isprintable() and name != " " and canonical_key(name) == name


def joystick_input(joystick: str, control: str, part: str = "") -> str:
    """The name of an input of a joystick.

    Args:
        joystick: Its name in the layout.
        control: Name of the control.
        part: Which of `DIRECTIONS`, for a hat; `PRESSED`, for an axis that is used as a button.
    """
    return f"{JOYSTICK}{joystick} {control} {part}".rstrip()
