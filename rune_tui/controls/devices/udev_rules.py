"""The udev rule that allows the users of a Linux system to read a joystick; pure."""

from __future__ import annotations

from collections.abc import Iterable

from rune_tui.controls.devices.matching import DeviceInfo

_INPUT = "/dev/input/"
"""Folder of the kernel's input devices, which the system opens for the user at the seat."""
RULE_FILE = "/etc/udev/rules.d/60-rune-joystick.rules"
"""Its number has to be below 73, where the system gives devices to the user at the machine."""


def udev_rule(device: DeviceInfo) -> str:
    """The line for a device; it holds for USB and for Bluetooth."""
    kernels = f"*:{device.vid:04X}:{device.pid:04X}.*"
    return (
        f'KERNEL=="hidraw*", SUBSYSTEM=="hidraw", KERNELS=="{kernels}", '
        'MODE="0660", GROUP="input", TAG+="uaccess"'
    )


def rule_advice(device: DeviceInfo) -> str:
    """The remedy for an unreadable device, in words."""
    if device.path.startswith(_INPUT):
        return "join the group of input devices (sudo usermod -aG input $USER) and log in again"
    return f"put into {RULE_FILE}: {udev_rule(device)}"


def udev_rules(devices: Iterable[DeviceInfo]) -> str:
    """A whole file for these devices, each kind once."""
    lines = [f"# {RULE_FILE}; then: sudo udevadm control --reload && sudo udevadm trigger"]
    for name, rule in {
        udev_rule(device): device.shown for device in devices if not device.path.startswith(_INPUT)
    }.items():
        lines += [f"# {rule}", name]
    return "\n".join(lines) + "\n"
