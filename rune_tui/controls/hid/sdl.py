"""Roles out of SDL_GameControllerDB, for pads without a profile of Rune.

Its lines count axes and buttons as SDL does on Linux: in the order of the codes that the kernel's
drivers/hid/hid-input.c gives to usages. That order is worked out here from the usages alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from hub.values import dataclass
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.layout.spec import ControlKind

_STICKS = {"leftx", "lefty", "rightx", "righty", "lefttrigger", "righttrigger"}
_BUTTONS = {"a", "b", "x", "y", "back", "guide", "start", "leftshoulder", "rightshoulder"}
_PRESSED = {"leftstick", "rightstick", "dpup", "dpdown", "dpleft", "dpright"}
_ROLES = _STICKS | _BUTTONS | _PRESSED
_AXIS_CODES = {
    "x": 0,
    "y": 1,
    "z": 2,
    "rx": 3,
    "ry": 4,
    "rz": 5,
    "slider": 6,
    "throttle": 6,
    "dial": 7,
    "rudder": 7,
    "wheel": 8,
    "steering": 8,
    "accelerator": 9,
    "brake": 10,
}
_AXIS_CODES_END = 16
_KEY_CODES = {
    "d-pad up": 0x220,
    "d-pad down": 0x221,
    "d-pad left": 0x222,
    "d-pad right": 0x223,
    "volume down": 114,
    "volume up": 115,
    "main menu": 139,
    "back": 158,
    "play": 164,
    "record": 167,
    "home": 172,
}
_FIRST_BUTTON, _MANY_BUTTONS, _BUTTON_CODES_END = 0x130, 0x2C0, 0x300
_UNKNOWN_KEY = 240
_PLACE = re.compile(r"([abh])([0-9]{1,3})(?:\.[0-9]+)?(~?)")
_VENDOR_NUMBERING = 0x8000


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    bus: int
    version: int
    places: Mapping[str, str]


def roles_from_sdl(
    lines: Iterable[str],
    controls: Sequence[PhysicalControl],
    vid: int,
    pid: int,
    bus: int,
) -> tuple[PhysicalControl, ...]:
    """The controls with the roles of the line that fits best; as they are if none fits.

    Lines for other systems count in other ways and are left out, as are places of halves of axes.

    Args:
        lines: Lines of such a file; others are skipped.
        controls: All controls of the device.
        vid: The maker's number.
        pid: The product's.
        bus: As Linux counts: 3 USB, 5 Bluetooth.
    """
    fitting = [line for each in lines if (line := _read(each, vid, pid)) is not None]
    if not fitting:
        return tuple(controls)
    # With the upper bit of the version they count the controls of a vendor's own driver.
    best = min(fitting, key=lambda line: (line.bus != bus, line.version & _VENDOR_NUMBERING))
    order = {
        "a": _in_order(controls, _axis_codes(controls)),
        "b": _in_order(controls, _button_codes(controls)),
        "h": [place for place, each in enumerate(controls) if each.kind is ControlKind.HAT],
    }
    result = [_without_role(each) for each in controls]
    for role, place in best.places.items():
        match = _PLACE.fullmatch(place)
        if match is None or role not in _ROLES:
            continue
        kind, number, inverted = match[1], int(match[2]), bool(match[3])
        if number < len(order[kind]):
            which = order[kind][number]
            result[which] = _with_role(result[which], role, inverted=inverted)
    return tuple(result)


def _read(text: str, vid: int, pid: int) -> _Line | None:
    guid, _, rest = text.strip().partition(",")
    if not re.fullmatch("[0-9a-f]{32}", guid):
        return None
    words = [int.from_bytes(bytes.fromhex(guid[at : at + 4]), "little") for at in range(0, 28, 4)]
    if (words[2], words[3], words[4], words[5]) != (vid, 0, pid, 0):
        return None
    pairs = [part.partition(":") for part in rest.split(",")[1:]]
    places = {name: place for name, _, place in pairs if place}
    if places.pop("platform", "Linux") != "Linux":
        return None
    return _Line(bus=words[0], version=words[6], places=places)


def _with_role(control: PhysicalControl, role: str, *, inverted: bool) -> PhysicalControl:
    if control.kind is ControlKind.HAT:
        return replace(control, role="dpad")
    if control.kind is ControlKind.BUTTON:
        return replace(control, role=role)
    return replace(control, role=role, flipped=(role in {"lefty", "righty"}) != inverted)


def _without_role(control: PhysicalControl) -> PhysicalControl:
    """The same with no other role than a button's number."""
    number = re.fullmatch(r"button ([1-9]|[12]\d|3[0-2])", control.usage)
    flipped = control.flipped and control.role not in {"righty", "throttle"}
    return replace(control, role=f"button{number[1]}" if number else "", flipped=flipped)


def _in_order(controls: Sequence[PhysicalControl], codes: Mapping[int, int]) -> list[int]:
    """Positions in the order in which SDL numbers the codes: keys of keyboards come last."""
    first = min(_KEY_CODES["d-pad up"], _FIRST_BUTTON)
    is_button = {place: controls[place].kind is ControlKind.BUTTON for place in codes}
    return sorted(codes, key=lambda each: (is_button[each] and codes[each] < first, codes[each]))


def _axis_codes(controls: Sequence[PhysicalControl]) -> dict[int, int]:
    """The kernel's code of each axis; of two with the same usage the second gets the next free."""
    wanted = {
        place: _AXIS_CODES[name]
        for place, each in enumerate(controls)
        if each.kind is ControlKind.AXIS and (name := each.usage.partition("#")[0]) in _AXIS_CODES
    }
    return _free_codes(wanted, _AXIS_CODES_END)


def _button_codes(controls: Sequence[PhysicalControl]) -> dict[int, int]:
    wanted = {}
    for place, each in enumerate(controls):
        if each.kind is ControlKind.BUTTON:
            name = each.usage.partition("#")[0]
            word, _, number = name.partition(" ")
            if word == "button":
                index = int(number) - 1
                wanted[place] = index + (_FIRST_BUTTON if index < 16 else _MANY_BUTTONS - 16)
            else:
                wanted[place] = _KEY_CODES.get(name, _UNKNOWN_KEY)
    return _free_codes(wanted, _BUTTON_CODES_END)


def _free_codes(wanted: Mapping[int, int], end: int) -> dict[int, int]:
    taken: dict[int, int] = {}
    for place, first in wanted.items():
        code = next((code for code in range(first, end) if code not in taken), None)
        if code is not None:
            taken[code] = place
    return {place: code for code, place in taken.items()}
