"""HID devices through hidapi: connected devices and their reports. Only this file uses hidapi."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rune_tui.controls.devices.matching import JOYSTICK_USAGES, DeviceInfo, plain_text
from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.controls.hid.reading import Value
from rune_tui.errors import ConsoleError

_LONGEST_REPORT = 4096
_BUSES = {1: 3, 2: 5}
"""The kernel's numbers of USB and Bluetooth, by hidapi's."""

_HIDRAW = Path("/sys/class/hidraw")
"""Where Linux lists HID devices."""

_one_at_a_time = threading.Lock()
"""hidapi keeps the last error of all calls but `read` in one place."""


class HidMissingError(ConsoleError, ImportError):
    """hidapi is not installed, or cannot be loaded."""


def hidapi() -> Any:  # noqa: ANN401 - an untyped library
    """The library; on Linux its half for the kernel's own driver.

    The other half, over libusb, would take a device away from the kernel and sees no Bluetooth.

    Raises:
        HidMissingError: There is none.
    """
    try:
        try:
            import hidraw as hid
        except ImportError:
            import hid
    except ImportError as error:
        text = "joysticks need hidapi; install it with pip install 'robot-user-nexus[console]'"
        raise HidMissingError(text) from error
    if not hasattr(hid, "enumerate") or not hasattr(hid, "device"):
        text = "the installed module hid is not hidapi; uninstall the package hid, keep hidapi"
        raise HidMissingError(text)
    return hid


def plugged_in() -> tuple[DeviceInfo, ...]:
    """All HID devices, each once.

    Raises:
        HidMissingError: There is no hidapi.
    """
    hid = hidapi()
    with _one_at_a_time:
        found = hid.enumerate()
    devices: dict[str, dict[str, Any]] = {}
    joysticks: set[str] = set()
    for entry in found:  # one for each collection of each device
        path = os.fsdecode(entry["path"])
        devices.setdefault(path, entry)
        if (entry["usage_page"], entry["usage"]) in JOYSTICK_USAGES:
            joysticks.add(path)
    return tuple(
        DeviceInfo(
            path=path,
            vid=entry["vendor_id"],
            pid=entry["product_id"],
            serial=plain_text(entry["serial_number"]),
            name=plain_text(entry["product_string"]),
            joystick=path in joysticks,
            port=_port(path),
            bus=_BUSES.get(entry.get("bus_type", 0), 0),
        )
        for path, entry in devices.items()
    )


class HidKind:
    """HID devices; a `device_reader.Kind`."""

    def require(self) -> None:
        """Load hidapi.

        Raises:
            HidMissingError: There is none.
        """
        hidapi()

    def plugged_in(self) -> tuple[DeviceInfo, ...]:
        """All HID devices, each once."""
        return plugged_in()

    def mark(self) -> object:
        """The nodes of HID devices; None where the system lists none."""
        return _nodes()

    def open(self, info: DeviceInfo) -> HidDevice:
        """Open a device; errors as `device_reader.Kind` has them."""
        return HidDevice(info)


class HidDevice:
    """A HID device that is read.

    Attributes:
        controls: Its controls; none: it is no joystick.
        descriptor: Its report descriptor.
    """

    def __init__(self, info: DeviceInfo) -> None:
        self._device = hidapi().device()
        try:
            self._decoder = _open(self._device, info)
        except BaseException:
            self.close()
            raise
        self.controls = self._decoder.controls
        self.descriptor = self._decoder.descriptor

    def read(self, timeout: float) -> tuple[Value, ...] | None:
        """The values of the next report; None: there is none within this time [s]."""
        # Without a time-out hidapi does not wait, as the device does not block.
        wait_ms = round(1000.0 * timeout)
        report = (
            self._device.read(_LONGEST_REPORT, wait_ms)
            if wait_ms
            else self._device.read(_LONGEST_REPORT)
        )
        return self._decoder.decode(bytes(report)) if report else None

    def close(self) -> None:
        """Give it back."""
        with _one_at_a_time:
            self._device.close()


def _open(device: Any, info: DeviceInfo) -> DeviceDecoder:  # noqa: ANN401 - of an untyped library
    """Open a device.

    Raises:
        PermissionError: This user may not read it.
        OSError: It cannot be opened.
        DescriptorError: Its descriptor is not valid.
    """
    try:
        with _one_at_a_time:
            device.open_path(os.fsencode(info.path))
            descriptor = bytes(device.get_report_descriptor())
        device.set_nonblocking(1)
    except OSError as error:
        with _one_at_a_time:
            why = str(device.error() or error)
        forbidden = "ermission" in why or (
            sys.platform == "linux"
            and Path(info.path).exists()
            and not os.access(info.path, os.R_OK)
        )
        raise (PermissionError if forbidden else OSError)(why) from error
    return DeviceDecoder(descriptor, vid=info.vid, pid=info.pid, bus=info.bus or 3)


def _nodes() -> object:
    """A value that changes with the connected devices; None: the system has none."""
    try:
        with os.scandir(_HIDRAW) as entries:
            return sorted((entry.name, entry.inode()) for entry in entries)
    except OSError:
        return None


def _port(path: str) -> str:
    """The port of a device, on Linux; hidapi does not report it."""
    about = _HIDRAW / Path(path).name / "device/uevent"
    try:
        lines: Iterable[str] = about.read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    return next((line[9:] for line in lines if line.startswith("HID_PHYS=")), "")
