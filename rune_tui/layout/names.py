"""The names a layout may use whatever is installed: capabilities, keys, the mouse's parts."""

from __future__ import annotations

import string
import unicodedata
from collections.abc import Mapping

from hub.gcm.capability import Capability

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

MOUSE_PARTS = ("left", "middle", "right", "wheel", "motion")
"""What of a mouse can wake a widget."""
MOUSE = "mouse "
"""What the names of the mouse's inputs begin with; no key's name does."""

NAMED_KEYS = (
    *("up", "down", "left", "right", "space", "enter", "escape", "tab", "backspace"),
    *("home", "end", "pageup", "pagedown", "insert", "delete"),
)
FUNCTION_KEYS = tuple(f"f{number}" for number in range(1, 13))

WAY_OUT = "ctrl+c"
"""The key that ends the console, whatever a layout says."""

KEYS_REPORTED_AS: Mapping[str, str] = {
    "ctrl+h": "backspace",
    "ctrl+i": "tab",
    "ctrl+m": "enter",
}
"""Keys that a terminal cannot tell from others, and what it reports instead."""

CONTROL_KEYS = tuple(
    key for letter in string.ascii_lowercase if (key := f"ctrl+{letter}") not in KEYS_REPORTED_AS
)
KEYS = (*NAMED_KEYS, *FUNCTION_KEYS, *CONTROL_KEYS)
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
    "a key is one printable character in lower case, ctrl+ and a letter, f1 to f12, or one of "
    + ", ".join(NAMED_KEYS)
)


def canonical_key(name: str) -> str:
    """The one name of a key that goes by several: "+" for "plus", "space" for " ", "w" for "W"."""
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
