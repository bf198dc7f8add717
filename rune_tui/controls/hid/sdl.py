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
_WHOLE_AXES = {"leftx", "lefty", "rightx", "righty"}
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
_PLACE = re.compile(r"([abh])([0-9]{1,3})(?:\.([0-9]{1,2}))?(~?)")
_HALF = re.compile(r"([+-])a([0-9]{1,3})")
_HAT_BITS = {"dpup": "1", "dpright": "2", "dpdown": "4", "dpleft": "8"}
_LONGEST_NAME = 11
"""Bytes of a device's name in a GUID."""
_VENDOR_NUMBERING = 0x8000


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    bus: int
    version: int
    places: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class SdlRoles:
    """The controls of a device with the roles of its line.

    Attributes:
        controls: The controls.
        left_out: Roles of the line that Rune cannot give; its own guess counts for these.
    """

    controls: tuple[PhysicalControl, ...]
    left_out: tuple[str, ...] = ()


def guid_end(vid: int, pid: int, name: str) -> str:
    """The part of a device's GUIDs that follows bus and checksum and is always the same, in hex.

    A device without numbers has the beginning of its name there.
    """
    if vid or pid:
        return b"".join(number.to_bytes(4, "little") for number in (vid, pid)).hex()
    return name.encode()[:_LONGEST_NAME].hex()


def roles_from_sdl(
    lines: Iterable[str],
    controls: Sequence[PhysicalControl],
    vid: int,
    pid: int,
    bus: int,
    name: str = "",
) -> SdlRoles:
    """The controls with the roles of the line that fits best; as they are if none fits.

    Lines for other systems count in other ways and are left out. One control has one role here. So
    a half of an axis has none, except where a line names both halves of one stick's axis.

    Args:
        lines: Lines of such a file; others are skipped.
        controls: All controls of the device.
        vid: The maker's number.
        pid: The product's.
        bus: As Linux counts: 3 USB, 5 Bluetooth.
        name: The device's name.
    """
    end = guid_end(vid, pid, name)
    fitting = [line for each in lines if (line := _read(each, end)) is not None]
    if not fitting:
        return SdlRoles(controls=tuple(controls))
    # With the upper bit of the version they count the controls of a vendor's own driver.
    best = min(fitting, key=lambda line: (line.bus != bus, line.version & _VENDOR_NUMBERING))
    order = {
        "a": _in_order(controls, _axis_codes(controls)),
        "b": _in_order(controls, _button_codes(controls)),
        "h": [place for place, each in enumerate(controls) if each.kind is ControlKind.HAT],
    }
    given: dict[int, tuple[str, bool]] = {}
    left_out = []
    for role, place in _whole_axes(best.places).items():
        which = _control_at(role, place, order)
        hat = which is not None and controls[which].kind is ControlKind.HAT
        if which is None or (which in given and not hat):
            left_out.append(role)
        else:
            given[which] = ("dpad" if hat else role, place.endswith("~"))
    result = [_without_role(each) for each in controls]
    for which, (role, inverted) in given.items():
        result[which] = _with_role(result[which], role, inverted=inverted)
    _keep_guess(result, controls, given, left_out)
    return SdlRoles(controls=tuple(result), left_out=tuple(left_out))


def _whole_axes(places: Mapping[str, str]) -> dict[str, str]:
    """Places by role; two halves of one axis that are two halves of one role are a whole one."""
    whole = {role: place for role, place in places.items() if role in _ROLES}
    for role in _STICKS:
        halves = [_HALF.fullmatch(places.get(f"{sign}{role}", "")) for sign in "+-"]
        if halves[0] and halves[1] and halves[0][2] == halves[1][2]:
            if halves[0][1] != halves[1][1]:
                whole[role] = f"a{halves[0][2]}" + ("" if halves[0][1] == "+" else "~")
        elif any(f"{sign}{role}" in places for sign in "+-"):
            whole.setdefault(role, "")
    return whole


def _control_at(role: str, place: str, order: Mapping[str, Sequence[int]]) -> int | None:
    """Position of the control at a place of a line; None: it has none, or cannot have the role."""
    match = _PLACE.fullmatch(place)
    if match is None or int(match[2]) >= len(order[match[1]]):
        return None
    kind, bit = match[1], match[3]
    if kind == "h":
        fits = _HAT_BITS.get(role) == bit
    else:
        fits = role in _STICKS if kind == "a" else role not in _WHOLE_AXES
    return order[kind][int(match[2])] if fits else None


def _keep_guess(
    result: list[PhysicalControl],
    controls: Sequence[PhysicalControl],
    given: Mapping[int, object],
    left_out: Iterable[str],
) -> None:
    """Keep the guessed roles that the line has but cannot give; and those of the left stick."""
    wanted = {"dpad" if role in _HAT_BITS else role for role in left_out} | {"leftx", "lefty"}
    taken = {each.role for each in result}
    for which, guessed in enumerate(controls):
        if which not in given and guessed.role in wanted - taken:
            result[which] = guessed


def _read(text: str, end: str) -> _Line | None:
    guid, _, rest = text.strip().lstrip("\ufeff").partition(",")
    guid = guid.lower()
    if not re.fullmatch("[0-9a-f]{32}", guid) or not end or not guid.startswith(end, 8):
        return None
    words = [int.from_bytes(bytes.fromhex(guid[at : at + 4]), "little") for at in range(0, 28, 4)]
    pairs = [part.partition(":") for part in rest.split(",")[1:]]
    places = {name: place for name, _, place in pairs if place}
    if places.pop("platform", "Linux") != "Linux" or places.get("hint", "").startswith("!"):
        return None  # the line without "!" names buttons by the letters on them, as Rune does
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
