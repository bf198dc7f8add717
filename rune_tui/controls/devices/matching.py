"""Which device is which joystick of the layout; pure."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence

from hub.values import dataclass
from rune_tui.layout.spec import JoystickSpec

JOYSTICK_USAGES = frozenset({(1, 4), (1, 5), (1, 8)})
"""Usage page and usage of joysticks, gamepads and devices with many axes (HID usage tables)."""
_LONGEST_NAME = 80


def plain_text(text: str | None) -> str:
    """A text of a device, without characters that harm a terminal or a file."""
    return "".join(filter(str.isprintable, text or "")).strip()[:_LONGEST_NAME]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceInfo:
    """A device that is plugged in.

    Attributes:
        path: Its name in the system; it changes when the device is plugged in again.
        vid: The vendor's number.
        pid: The product's number.
        serial: Its serial number; empty: it has none.
        name: The product's name.
        joystick: Whether it declares to be a joystick, gamepad or wheel.
        port: Its port; empty: the system does not report it.
        bus: Linux's number of the bus: 3 USB, 5 Bluetooth; 0: not reported.
        machine: The machine at which it is plugged in; empty: this one.
        virtual: Whether a program of this machine made it, often as a copy of a real one.
    """

    path: str
    vid: int
    pid: int
    serial: str = ""
    name: str = ""
    joystick: bool = True
    port: str = ""
    bus: int = 0
    machine: str = ""
    virtual: bool = False

    @property
    def shown(self) -> str:
        """Its name for an operator."""
        name = self.name or f"device {self.vid:04x}:{self.pid:04x}"
        return f"{name} at {self.machine}" if self.machine else name

    @property
    def key(self) -> str:
        """The key under which its calibration is stored."""
        return f"{self.vid:04x}:{self.pid:04x}:{self.serial}"


def is_meant(spec: JoystickSpec, device: DeviceInfo) -> bool:
    """Whether a device is one that the layout can mean, joystick or not."""
    return (
        spec.vid in {None, device.vid}
        and spec.pid in {None, device.pid}
        and spec.serial in {"", device.serial}
        and (not spec.device or fnmatch.fnmatch(device.name.lower(), spec.device.lower()))
        and (device.joystick or is_particular(spec))
    )


def is_particular(spec: JoystickSpec) -> bool:
    """Whether the layout means a certain kind of device, not just any joystick."""
    return spec.vid is not None or bool(spec.serial or spec.device)


def assigned(
    specs: Sequence[JoystickSpec],
    devices: Sequence[DeviceInfo],
    last: Mapping[str, DeviceInfo],
) -> Mapping[str, DeviceInfo]:
    """The device of each joystick that has one, by the joystick's name; none has two.

    The rules, in this order:

    1. A joystick keeps its device while that is plugged in.
    2. A device that is plugged in again goes to its last joystick, found by its serial number, else
       by its port.
    3. The other devices go to the other joysticks in the order of the layout. Joysticks with more
       conditions come first. Devices of this machine come first, those that a program made last.
    4. A joystick that had a device of one machine gets no device of another machine: another person
       may use that.

    Args:
        specs: The joysticks of the layout.
        devices: The devices that are plugged in.
        last: The last device of each joystick, by the joystick's name.
    """
    found: dict[str, DeviceInfo] = {}
    free = sorted(devices, key=_order)
    by_care = sorted(specs, key=lambda spec: (not spec.serial, spec.vid is None, not spec.device))
    for same in (_same_path, _same_serial, _same_port, _same_kind, _any):
        for spec in by_care:
            before = last.get(spec.name)
            for device in [] if spec.name in found else free:
                there = before is None or before.machine == device.machine
                if there and is_meant(spec, device) and same(before, device):
                    found[spec.name] = device
                    free.remove(device)
                    break
    return found


def _order(device: DeviceInfo) -> tuple[str, bool, bool, str, str]:
    """Devices of this machine first; copies made by programs after what may be their original."""
    return device.machine, device.virtual, not device.port, device.port, device.path


def _same_kind(before: DeviceInfo | None, device: DeviceInfo) -> bool:
    return before is not None and (before.vid, before.pid) == (device.vid, device.pid)


def _same_path(before: DeviceInfo | None, device: DeviceInfo) -> bool:
    return before is not None and before == device


def _same_serial(before: DeviceInfo | None, device: DeviceInfo) -> bool:
    return before is not None and bool(before.serial) and before.key == device.key


def _same_port(before: DeviceInfo | None, device: DeviceInfo) -> bool:
    return (
        before is not None
        and bool(before.port)
        and before.port == device.port
        and _same_kind(before, device)
    )


def _any(_before: DeviceInfo | None, _device: DeviceInfo) -> bool:
    return True
