"""The names a layout may use: visualizer functions, widget handlers, keys.

Plain tables, so that a layout can be checked without the code behind the names.
"""

from __future__ import annotations

import string
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field

from hub.gcm.capability import Capability


@dataclass(frozen=True, slots=True, kw_only=True)
class OptionRule:
    """A number that a layout may give.

    Attributes:
        default: Its value where the layout is silent.
        least: Smallest value allowed.
        most: Largest value allowed.
        unit: Its unit; empty for a plain number.
        meaning: What it does, for the reference.
    """

    default: float
    least: float
    most: float
    unit: str
    meaning: str


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualizerRule:
    """What a layout may say of a visualizer.

    Attributes:
        message: The message it draws; empty if it draws none.
        text: Whether it shows the attribute `text`.
        option: Its numeric option, if it has one.
    """

    message: str
    text: bool = False
    option: OptionRule | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class HandlerRule:
    """What a layout may say of a widget handler.

    Attributes:
        controls: What its events move; empty if there is nothing to choose.
        options: Its options, by name.
        needs_robot: Whether it commands a robot, and so belongs into a viewport.
    """

    controls: tuple[str, ...] = ()
    options: Mapping[str, OptionRule] = field(default_factory=dict)
    needs_robot: bool = True


VISUALIZERS: Mapping[str, VisualizerRule] = {
    "visualizeCameraImage": VisualizerRule(message="GCM_Common_Image"),
    "visualizeRangeData": VisualizerRule(
        message="GCM_RobotState",
        option=OptionRule(
            default=0.0, least=0.0, most=100.0, unit="m", meaning="range at the rim; 0 means 3 m"
        ),
    ),
    "visualizePanData": VisualizerRule(message="GCM_CameraState"),
    "visualizeTiltData": VisualizerRule(message="GCM_CameraState"),
    "visualizeStatus": VisualizerRule(message="GCM_RobotState"),
    "visualizeLabel": VisualizerRule(message="", text=True),
}

HANDLERS: Mapping[str, HandlerRule] = {
    "widgetSetSpeed": HandlerRule(
        controls=("translate", "rotate"),
        options={
            "linear": OptionRule(
                default=0.5, least=0.0, most=10.0, unit="m/s", meaning="speed at value 1"
            ),
            "angular": OptionRule(
                default=1.0, least=0.0, most=10.0, unit="rad/s", meaning="turn rate at value 1"
            ),
        },
    ),
    "widgetStop": HandlerRule(),
    "widgetAdjustPan": HandlerRule(
        options={
            "step_deg": OptionRule(
                default=5.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, to the left"
            )
        }
    ),
    "widgetAdjustTilt": HandlerRule(
        options={
            "step_deg": OptionRule(
                default=3.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, upwards"
            )
        }
    ),
    "widgetAdjustZoom": HandlerRule(
        options={
            "step": OptionRule(
                default=0.05, least=0.001, most=1.0, unit="", meaning="change a press, of 0 to 1"
            )
        }
    ),
    "widgetHomePTZ": HandlerRule(),
    "widgetQuit": HandlerRule(needs_robot=False),
}

CAPABILITY_INTERVALS_MS: Mapping[str, int] = {
    capability.value: 66 if capability is Capability.VIS_VID else 0 for capability in Capability
}
"""Known capabilities and their shortest time between two requests [ms]."""

NAMED_KEYS = (
    *("up", "down", "left", "right", "space", "enter", "escape", "tab", "backspace"),
    *("home", "end", "pageup", "pagedown", "insert", "delete"),
)
FUNCTION_KEYS = tuple(f"f{number}" for number in range(1, 13))

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
