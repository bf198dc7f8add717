"""Joysticks that are no HID devices, through Linux's input layer. Only this file uses evdev."""

from __future__ import annotations

import contextlib
import os
import select
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rune_tui.controls.devices.matching import DeviceInfo, plain_text
from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.controls.hid.kernel_codes import EV_ABS, EV_KEY, Code, KernelPad
from rune_tui.controls.hid.reading import Value

_CLASS = Path("/sys/class/input")
_NODES = Path("/dev/input")
_MISSING = (
    "this joystick speaks no HID, and evdev is not installed: pip install 'robot-user-nexus[evdev]'"
)
_SYN, _REPORT, _DROPPED = 0, 0, 3
"""Type of the event that ends a report, and its codes: complete, or events were lost."""
_LONGEST = 1000
_VIRTUAL = "/devices/virtual/input/"
"""Where Linux keeps input devices that programs made by uinput."""


class EvdevKind:
    """Joysticks of the input layer that are no HID devices; a `device_reader.Kind`."""

    def __init__(self, classes: Path = _CLASS) -> None:
        """Prepare; `classes` is where the system lists input devices."""
        self._classes = classes

    def require(self) -> None:
        """Does nothing: if evdev is missing, `open` reports that."""

    def mark(self) -> object:
        """The nodes of input devices; empty where the system has none."""
        try:
            with os.scandir(self._classes) as entries:
                return sorted((entry.name, entry.inode()) for entry in entries)
        except OSError:
            return ()

    def plugged_in(self) -> tuple[DeviceInfo, ...]:
        """All joysticks of this kind, in the order of their nodes."""
        return tuple(self._found())

    def open(self, info: DeviceInfo) -> EvdevDevice:
        """Open a joystick; errors as `device_reader.Kind` has them."""
        return EvdevDevice(info)

    def _found(self) -> Iterator[DeviceInfo]:
        nodes = self._classes.glob("event*")
        for node in sorted(nodes, key=lambda each: (len(each.name), each.name)):
            about = node / "device"
            axes, keys = _bits(about / "capabilities/abs"), _bits(about / "capabilities/key")
            # `hid_reader` reads HID devices: they have more than the input layer reports.
            is_hid = (about / "device" / "hidraw").exists()
            if is_hid or KernelPad.of(dict.fromkeys(axes, (0, 1)), frozenset(keys)) is None:
                continue
            vid, pid, bus = (_hex(about / "id" / name) for name in ("vendor", "product", "bustype"))
            yield DeviceInfo(
                path=str(_NODES / node.name),
                vid=vid,
                pid=pid,
                serial=plain_text(_text(about / "uniq")),
                name=plain_text(_text(about / "name")),
                port=plain_text(_text(about / "phys")),
                bus=bus,
                virtual=_VIRTUAL in os.path.realpath(about),
            )


class EvdevDevice:
    """A joystick of the input layer that is read.

    Attributes:
        controls: Its controls; none: it is no joystick.
        descriptor: A HID report descriptor with these controls.
    """

    def __init__(self, info: DeviceInfo) -> None:
        self._device = _opened(info.path)
        try:
            capabilities = self._device.capabilities(absinfo=True)
            axes = {code: (about.min, about.max) for code, about in capabilities.get(EV_ABS, [])}
            self._axes = tuple(axes)
            pad = KernelPad.of(axes, frozenset(capabilities.get(EV_KEY, [])))
            self._pad = pad or KernelPad(axes={}, buttons=(), hat=False)
            self.descriptor = self._pad.descriptor
            self._decoder = DeviceDecoder(
                self.descriptor, vid=info.vid, pid=info.pid, bus=info.bus or 3
            )
            self.controls = self._decoder.controls if pad is not None else ()
            self._poll = select.poll()
            self._poll.register(self._device.fd, select.POLLIN)
            self._state: dict[Code, int] = {}
            self._events: Iterator[Any] = iter(())
            self._lost = True  # nothing is known yet
        except BaseException:
            self.close()
            raise

    def read(self, timeout: float) -> tuple[Value, ...] | None:
        """The values of the next report; None: there is none within this time [s].

        The first tells how all controls are when it is opened; one after events were lost, how
        they are then.
        """
        if self._lost:
            return self._everything()
        values = self._next()
        if values is None and self._poll.poll(round(1000.0 * timeout)):
            self._events = self._device.read()
            values = self._next()
        return values

    def close(self) -> None:
        """Give it back."""
        with contextlib.suppress(OSError):
            self._device.close()

    def _next(self) -> tuple[Value, ...] | None:
        """The values after the next whole report among the events that were read."""
        with contextlib.suppress(BlockingIOError):
            for event in self._events:
                if event.type in (EV_ABS, EV_KEY):
                    self._state[event.type, event.code] = event.value
                elif event.type == _SYN and event.code == _DROPPED:
                    self._events = iter(())
                    return self._everything()
                elif event.type == _SYN and event.code == _REPORT:
                    return self._decoder.decode(self._pad.report(self._state))
        return None

    def _everything(self) -> tuple[Value, ...]:
        """Ask the kernel for the state of all controls."""
        self._lost = False
        pressed = set(self._device.active_keys())
        self._state = {(EV_KEY, code): int(code in pressed) for code in self._pad.buttons}
        # `capabilities` has the positions of the moment when the device was opened.
        for code in self._axes:
            self._state[EV_ABS, code] = self._device.absinfo(code).value
        return self._decoder.decode(self._pad.report(self._state))


def _opened(path: str) -> Any:  # noqa: ANN401 - the library has no types
    try:
        import evdev
    except ImportError as error:
        raise OSError(_MISSING) from error
    return evdev.InputDevice(path)


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            return file.read(_LONGEST).decode(errors="replace").strip()
    except OSError:
        return ""


def _hex(path: Path) -> int:
    try:
        return int(_text(path), 16)
    except ValueError:
        return 0


def _bits(path: Path) -> set[int]:
    """The bits that are set in one of the kernel's bitmaps: words in hex, the highest first."""
    try:
        words = [int(word, 16) for word in reversed(_text(path).split())]
    except ValueError:
        return set()
    width = 8 * struct.calcsize("l")
    return {
        place * width + bit
        for place, word in enumerate(words)
        for bit in range(width)
        if word >> bit & 1
    }
