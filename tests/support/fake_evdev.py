"""A virtual Xbox pad over USB: an input device of the kernel's that is no HID device.

As with `fake_hid`, only programs that a test starts see it; python-evdev in them is real.
"""

from __future__ import annotations

import os
import struct
import tempfile
from collections.abc import Iterable

import pytest

from tests.support.fake_hid import MISSING, VirtualBed, library

NAME = "Microsoft X-Box 360 pad"
STICK, TRIGGER, HAT = (-32768, 32767), (0, 255), (-1, 1)
AXES = {0: STICK, 1: STICK, 2: TRIGGER, 3: STICK, 4: STICK, 5: TRIGGER, 16: HAT, 17: HAT}
BUTTONS = (0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13A, 0x13B, 0x13C, 0x13D, 0x13E)
"""As the driver xpad has them: A, B, X, Y, shoulders, back, start, guide, sticks."""
A, B = BUTTONS[:2]
KEY, ABS = 1, 3
_WORD = 64

needs_virtual_pads = pytest.mark.skipif(library() is None, reason=MISSING)


class VirtualXboxPad:
    """Plugged in from the start to `unplug`."""

    def __init__(self, bed: VirtualBed, number: int = 5) -> None:
        self._bed = bed
        self._node = f"/dev/input/event{number}"
        usb = f"/devices/pci0000:00/0000:00:14.0/usb1/1-{number}/1-{number}:1.0"
        above = f"{usb}/input/input{number}"
        self._places = [f"{above}/event{number}", above, usb]
        bed.call("add_from_string", self._described(usb, number).encode())
        with tempfile.NamedTemporaryFile("w", suffix=".ioctl") as file:
            file.write(self._answers())
            file.flush()
            bed.call("load_ioctl", self._node.encode(), file.name.encode())
        self._master = bed.master_of(self._node)

    def send(self, *events: tuple[int, int, int]) -> None:
        """One report: type, code and value of each event."""
        whole = (*events, (0, 0, 0))
        os.write(self._master, b"".join(struct.pack("<qqHHi", 0, 0, *each) for each in whole))

    def unplug(self) -> None:
        """Pull it out; the program sees the end of it."""
        for place in self._places:
            self._bed.remove(f"/sys{place}")
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, self._master)
        os.close(null)

    def _described(self, usb: str, number: int) -> str:
        return f"""P: {usb}
E: SUBSYSTEM=usb
E: DEVTYPE=usb_interface

P: {usb}/input/input{number}
E: SUBSYSTEM=input
A: name={NAME}
A: phys=usb-0000:00:14.0-7/input0
A: id/vendor=045e
A: id/product=028e
A: id/bustype=0003
A: capabilities/abs={_words(AXES)}
A: capabilities/key={_words(BUTTONS)}
L: device=../..

P: {usb}/input/input{number}/event{number}
N: input/event{number}
E: SUBSYSTEM=input
E: DEVNAME=/dev/input/event{number}
A: dev=13:{64 + number}
L: device=../../input{number}
"""

    def _answers(self) -> str:
        """What the kernel answers when asked (linux/input.h)."""
        return "\n".join(
            (
                f"@DEV {self._node}",
                f"EVIOCGVERSION 0 {struct.pack('<i', 0x10001).hex().upper()}",
                f"EVIOCGID 0 {struct.pack('<4H', 3, 0x45E, 0x28E, 0x114).hex().upper()}",
                f"EVIOCGNAME {len(NAME) + 1} {NAME.encode().ljust(256, bytes(1)).hex().upper()}",
                f"EVIOCGBIT(0) 4 {_bitmap((0, KEY, ABS), 4)}",
                f"EVIOCGBIT({KEY}) 96 {_bitmap(BUTTONS, 96)}",
                f"EVIOCGBIT({ABS}) 96 {_bitmap(AXES, 96)}",
                "EVIOCGEFFECTS 0 00000000",
                f"EVIOCGKEY 96 {_bitmap((), 96)}",
                *(
                    f"EVIOCGABS({code}) 0 {struct.pack('<6i', 0, *ends, 0, 0, 0).hex().upper()}"
                    for code, ends in AXES.items()
                ),
                "",
            )
        )


def _words(bits: Iterable[int]) -> str:
    """As /sys has them: words in hex, the highest first."""
    number, words = sum(1 << bit for bit in bits), []
    while number:
        words.append(f"{number & (1 << _WORD) - 1:x}")
        number >>= _WORD
    return " ".join(reversed(words))


def _bitmap(bits: Iterable[int], size: int) -> str:
    return sum(1 << bit for bit in bits).to_bytes(size, "little").hex().upper()
