"""The joysticks of this machine, of all kinds that its system has."""

from __future__ import annotations

import sys

from rune_tui.controls.devices.device_reader import DeviceReader, Kind, plugged_in
from rune_tui.controls.devices.evdev_reader import EvdevKind
from rune_tui.controls.devices.hid_reader import HidKind
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.hid.device_controls import PhysicalControl


def kinds() -> tuple[Kind, ...]:
    """HID devices first; on Linux then those that the kernel reads and that are not HID."""
    return (HidKind(), EvdevKind()) if sys.platform == "linux" else (HidKind(),)


def lists_devices() -> bool:
    """Whether this system lists any device; if not, that it lists no joystick says nothing."""
    return sys.platform != "linux" or any(kind.mark() for kind in kinds())


def reader() -> DeviceReader:
    """The reader of this machine's devices."""
    return DeviceReader(kinds())


def joysticks_here() -> tuple[DeviceInfo, ...]:
    """All devices that declare to be joysticks, in the order of their numbers.

    Raises:
        HidMissingError: There is no hidapi.
    """
    found, _ = plugged_in(kinds())
    return tuple(device for device in found if device.joystick)


def controls_of(info: DeviceInfo) -> tuple[PhysicalControl, ...]:
    """The controls of a device; opens it for a moment.

    Raises:
        HidMissingError: There is no hidapi.
        PermissionError: This user may not read it.
        OSError: It cannot be opened.
        DescriptorError: Its descriptor is not valid.
    """
    _, kind_of = plugged_in(kinds())
    kind = kind_of.get(info.path)
    if kind is None:
        text = f"{info.path} is not plugged in any more"
        raise OSError(text)
    device = kind.open(info)
    try:
        return device.controls
    finally:
        device.close()
