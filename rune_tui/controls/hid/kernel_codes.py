"""Turns a gamepad of Linux's input layer into a HID report descriptor and its reports; pure.

Pads without HID, such as Xbox pads over USB, are read by drivers of the kernel, which give
event codes. Written as HID, they go through all that HID joysticks go through: roles, calibration,
and the way to another machine. The codes are those of the kernel's `input-event-codes.h`; what they
mean on a gamepad says its `gamepad.rst`. The driver xpad gives 0x133 for X and 0x134 for Y, which
are the numbers 4 and 5 that Android has for them.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Final

from hub.values import dataclass

EV_KEY, EV_ABS = 1, 3
"""Types of events: buttons, axes."""
ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ = range(6)
ABS_HAT0X, ABS_HAT0Y = 0x10, 0x11
BTN_JOYSTICK, BTN_GAMEPAD, BTN_DIGITAL = 0x120, 0x130, 0x140

_DESKTOP, _SIMULATION, _BUTTON = 0x01, 0x02, 0x09
_ACCELERATOR, _BRAKE = (_SIMULATION, 0xC4), (_SIMULATION, 0xC5)
_USAGES: Final[Mapping[int, tuple[int, int]]] = {
    **{code: (_DESKTOP, 0x30 + code) for code in range(6)},
    0x06: (_SIMULATION, 0xBB),  # throttle
    0x07: (_SIMULATION, 0xBA),  # rudder
    0x08: (_SIMULATION, 0xC8),  # steering wheel
    0x09: _ACCELERATOR,
    0x0A: _BRAKE,
}
_HAT: Final = bytes.fromhex("0501 0939 1500 2507 7504 9501 8142  7504 9501 8101")
_DIRECTIONS: Final = {
    (0, -1): 0,
    (1, -1): 1,
    (1, 0): 2,
    (1, 1): 3,
    (0, 1): 4,
    (-1, 1): 5,
    (-1, 0): 6,
    (-1, -1): 7,
}
"""Clockwise from up; the kernel counts right and down."""
_NO_DIRECTION: Final = 8

Code = tuple[int, int]
"""Type and code of an event."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelPad:
    """The controls of a device, by the kernel's codes.

    Attributes:
        axes: Least and greatest value by code, without those of the hat.
        buttons: Codes, in their order.
        hat: Whether it has one.
    """

    axes: Mapping[int, tuple[int, int]]
    buttons: tuple[int, ...]
    hat: bool

    @classmethod
    def of(cls, axes: Mapping[int, tuple[int, int]], keys: frozenset[int]) -> KernelPad | None:
        """The controls of a device with these axes and keys; None: it is no joystick."""
        buttons = tuple(sorted(key for key in keys if BTN_JOYSTICK <= key < BTN_DIGITAL))
        if not buttons or not {ABS_X, ABS_Y} <= axes.keys():
            return None
        known = {code: axes[code] for code in sorted(axes.keys() & _USAGES.keys())}
        usable = {code: ends for code, ends in known.items() if ends[0] < ends[1]}
        return cls(axes=usable, buttons=buttons, hat={ABS_HAT0X, ABS_HAT0Y} <= axes.keys())

    @property
    def gamepad(self) -> bool:
        """Whether its driver reports a gamepad, so that its buttons have meanings."""
        return any(code >= BTN_GAMEPAD for code in self.buttons)

    @property
    def descriptor(self) -> bytes:
        """A HID report descriptor with its axes, its hat and its buttons."""
        parts = [bytes((0x05, _DESKTOP, 0x09, 0x05 if self.gamepad else 0x04, 0xA1, 0x01))]
        for code, (low, high) in self.axes.items():
            page, usage = self._usage(code)
            ends = struct.pack("<BiBi", 0x17, low, 0x27, high)
            parts.append(bytes((0x05, page, 0x09, usage)) + ends + bytes.fromhex("7520 9501 8102"))
        if self.hat:
            parts.append(_HAT)
        parts.append(bytes((0x05, _BUTTON)) + bytes.fromhex("1500 2501 7501 9501"))
        parts += [bytes((0x09, self._number(code), 0x81, 0x02)) for code in self.buttons]
        parts.append(bytes((0x95, -len(self.buttons) % 8, 0x81, 0x01, 0xC0)))
        return b"".join(parts)

    def report(self, state: Mapping[Code, int]) -> bytes:
        """The report of this descriptor for the newest value of each event."""
        axes = [
            min(high, max(low, state.get((EV_ABS, code), 0)))
            for code, (low, high) in self.axes.items()
        ]
        pressed = sum(
            bool(state.get((EV_KEY, code), 0)) << place for place, code in enumerate(self.buttons)
        )
        right, down = (_sign(state.get((EV_ABS, code), 0)) for code in (ABS_HAT0X, ABS_HAT0Y))
        direction = bytes((_DIRECTIONS.get((right, down), _NO_DIRECTION),)) if self.hat else b""
        buttons = pressed.to_bytes((len(self.buttons) + 7) // 8, "little")
        return struct.pack(f"<{len(axes)}i", *axes) + direction + buttons

    def _usage(self, code: int) -> tuple[int, int]:
        """Page and usage of an axis; beside a right stick, z and rz are triggers."""
        if self.gamepad and {ABS_RX, ABS_RY} <= self.axes.keys() and code in (ABS_Z, ABS_RZ):
            return _BRAKE if code == ABS_Z else _ACCELERATOR
        return _USAGES[code]

    @staticmethod
    def _number(code: int) -> int:
        """The number of a button, from 1."""
        first = BTN_GAMEPAD if code >= BTN_GAMEPAD else BTN_JOYSTICK
        return code - first + 1


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)
