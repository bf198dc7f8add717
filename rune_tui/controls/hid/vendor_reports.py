"""Reports that a descriptor calls the maker's own affair, though they hold sticks and buttons.

Drivers switch these devices to such reports; the layouts are those of SDL's drivers
SDL_hidapi_ps4.c, SDL_hidapi_ps5.c and SDL_hidapi_switch.c.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rune_tui.controls.hid.channels import Channel
from rune_tui.controls.hid.reading import Reading, ReportSlot

_SONY, _NINTENDO = 0x054C, 0x057E
_DUALSHOCK_4, _DUALSENSE, _SWITCH_PRO = {0x05C4, 0x09CC, 0x0BA0}, {0x0CE6, 0x0DF2}, {0x2009}
_BLUETOOTH = 5

Places = Mapping[str, tuple[int, int]]
"""First bit, after the report id, and length of controls, by usage [bits]."""


def _in_bytes(first: int, usages: str, hat: int) -> dict[str, tuple[int, int]]:
    """Axes of a byte each from byte `first` on, at byte `hat` a hat of four bits and buttons."""
    places = {usage: (8 * place, 8) for place, usage in enumerate(usages.split(), first)}
    places["hat switch"] = (8 * hat, 4)
    return places | {f"button {number}": (8 * hat + 3 + number, 1) for number in range(1, 15)}


# Two bytes of flags, then as over USB; the triggers stand behind the buttons.
_DUALSHOCK_4_PLACES = _in_bytes(2, "x y z rz", 6) | {"rx": (72, 8), "ry": (80, 8)}
_DUALSENSE_PLACES = _in_bytes(1, "x y z rz rx ry", 8)
_SWITCH_STICKS = {"x": (40, 12), "y": (52, 12), "z": (64, 12), "rz": (76, 12)}
_SWITCH_STICKS |= {"rx": (64, 12), "ry": (76, 12)}  # name of the right one over Bluetooth
_SWITCH_BUTTONS = (18, 19, 16, 17, 38, 22, 39, 23, 24, 25, 27, 26, 28, 29)
"""Bits of: B A Y X, L R ZL ZR, minus, plus, left and right stick, home, capture."""
_SWITCH_HAT = (32, 4)
"""One bit each for down, up, right and left."""
_HAT_OF_BITS = {2: 0, 6: 1, 4: 2, 5: 3, 1: 4, 9: 5, 8: 6, 10: 7}
_STICKS: tuple[int | None, ...] = tuple(value << 4 for value in range(4096))
"""12 bits widened to the 16 bits of the descriptor."""
_STICKS_UP = _STICKS[::-1]
"""The same for a value that grows upward, unlike the descriptor's."""


def read_vendor_reports(
    channels: Sequence[Channel], *, vid: int, pid: int, bus: int
) -> dict[int, Reading]:
    """The content of such reports, by report id."""
    if vid == _SONY and bus == _BLUETOOTH and pid in _DUALSHOCK_4:
        # Only if the first bit is set there is a state in it, not sound.
        slots = _slots(channels, _DUALSHOCK_4_PLACES)
        return dict.fromkeys(range(0x11, 0x1A), Reading(slots, prefix=1, needed=(1, 0x80)))
    if vid == _SONY and bus == _BLUETOOTH and pid in _DUALSENSE:
        return {0x31: Reading(_slots(channels, _DUALSENSE_PLACES), prefix=1)}
    if vid == _NINTENDO and pid in _SWITCH_PRO:
        return {0x30: Reading(_switch_slots(channels), prefix=1)}
    return {}


def _slots(channels: Sequence[Channel], places: Places) -> list[ReportSlot]:
    slots = []
    for position, channel in enumerate(channels):
        if channel.name in places:
            bit, size = places[channel.name]
            limits = (channel.minimum, channel.maximum) if size == 4 else None
            slots.append(ReportSlot(position=position, bit=bit, size=size, limits=limits))
    return slots


def _switch_slots(channels: Sequence[Channel]) -> list[ReportSlot]:
    """As far as the descriptor has the ranges that its makers give it."""
    places: dict[str, tuple[int, int]] = _SWITCH_STICKS | {"hat switch": _SWITCH_HAT}
    places |= {f"button {number}": (bit, 1) for number, bit in enumerate(_SWITCH_BUTTONS, 1)}
    slots = []
    for position, channel in enumerate(channels):
        bit, size = places.get(channel.name, (0, 0))
        table = None
        if size == 12 and (channel.minimum, channel.maximum) == (0, 0xFFFF):
            table = _STICKS_UP if channel.name in {"y", "rz", "ry"} else _STICKS
        elif size == 4 and channel.maximum - channel.minimum == 7:
            hats = (_HAT_OF_BITS.get(bits) for bits in range(16))
            table = tuple(None if hat is None else channel.minimum + hat for hat in hats)
        if table is not None or size == 1:
            slots.append(ReportSlot(position=position, bit=bit, size=size, table=table))
    return slots
