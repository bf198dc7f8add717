"""The usages of joysticks, and their names in layouts.

HID Usage Tables 1.5, sections 4 (generic desktop), 5 (simulation), 12 (button), 15 (consumer).
"""

from __future__ import annotations

DESKTOP, SIMULATION, BUTTON, CONSUMER, FIRST_VENDOR = 0x01, 0x02, 0x09, 0x0C, 0xFF00
"""Usage pages."""

MULTI_AXIS = 0x0001_0008
JOYSTICKS = frozenset({0x0001_0004, 0x0001_0005, MULTI_AXIS})
"""Applications of joysticks, gamepads, multi-axis controllers."""
JOYSTICK, GAMEPAD = 0x0001_0004, 0x0001_0005

HAT = 0x0001_0039
UNNAMED = 0x0001_0000
"""The name of the hat on some cheap pads."""

AXES = {
    DESKTOP << 16 | usage: name
    for names, first in (
        ("x y z rx ry rz slider dial wheel", 0x30),
        ("vx vy vz vbrx vbry vbrz vno", 0x40),
    )
    for usage, name in enumerate(names.split(), first)
} | {
    SIMULATION << 16 | usage: name
    for usage, name in {
        0xB0: "aileron",
        0xB1: "aileron trim",
        0xB2: "anti-torque",
        0xB6: "collective",
        0xB7: "dive brake",
        0xB8: "elevator",
        0xB9: "elevator trim",
        0xBA: "rudder",
        0xBB: "throttle",
        0xBF: "toe brake",
        0xC3: "wing flaps",
        0xC4: "accelerator",
        0xC5: "brake",
        0xC6: "clutch",
        0xC7: "shifter",
        0xC8: "steering",
        0xCB: "dive plane",
        0xCC: "ballast",
    }.items()
}
"""Usages with a value along a line."""

_SWITCHES = {
    DESKTOP << 16 | 0x3D: "start",
    DESKTOP << 16 | 0x3E: "select",
    DESKTOP << 16 | 0x85: "main menu",
    DESKTOP << 16 | 0x90: "d-pad up",
    DESKTOP << 16 | 0x91: "d-pad down",
    DESKTOP << 16 | 0x92: "d-pad right",
    DESKTOP << 16 | 0x93: "d-pad left",
    SIMULATION << 16 | 0xC0: "trigger",
    CONSUMER << 16 | 0xB2: "record",
    CONSUMER << 16 | 0xCD: "play",
    CONSUMER << 16 | 0xE9: "volume up",
    CONSUMER << 16 | 0xEA: "volume down",
    CONSUMER << 16 | 0x223: "home",
    CONSUMER << 16 | 0x224: "back",
}


def switch_name(usage: int) -> str:
    """The name of an on-off usage; empty: it is none of a joystick."""
    page, number = usage >> 16, usage & 0xFFFF
    if page == BUTTON and number:
        return f"button {number}"
    if usage in _SWITCHES:
        return _SWITCHES[usage]
    return f"consumer {number:x}" if page == CONSUMER and number else ""
