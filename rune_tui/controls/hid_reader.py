"""Real devices: what is plugged in, and a thread for each that is read. Only this uses hidapi."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rune_tui.controls.hid.device_controls import DeviceDecoder, PhysicalControl
from rune_tui.controls.joystick.inbox import Inbox
from rune_tui.controls.joystick.matching import JOYSTICK_USAGES, DeviceInfo, plain_text
from rune_tui.errors import ConsoleError, DescriptorError

_logger = logging.getLogger(__name__)

_LOOK_S = 1.0
"""Between two looks for devices; hidapi tells of none by itself [s]."""
_READ_MS = 100
_PAUSE_S = 0.004
"""How long what comes is gathered, so that a device of 1 kHz wakes nobody a thousand times [s]."""
_MOST_AT_ONCE = 64
"""Reports that the kernel keeps for a reader."""
_LONGEST_REPORT = 4096
_CLOSE_S = 2.0
_BUSES = {1: 3, 2: 5}
"""The kernel's numbers of USB and Bluetooth, by hidapi's."""

_HIDRAW = Path("/sys/class/hidraw")
"""Where Linux lists HID devices."""

_one_at_a_time = threading.Lock()
"""hidapi keeps the last error of all calls but `read` in one place."""


class HidMissingError(ConsoleError, ImportError):
    """hidapi is not installed, or cannot be loaded."""


@dataclass(frozen=True, slots=True)
class Scanned:
    """These devices are plugged in, joysticks and others."""

    devices: tuple[DeviceInfo, ...]


@dataclass(frozen=True, slots=True)
class Opened:
    """A device is being read; of what descriptor its controls are."""

    path: str
    controls: tuple[PhysicalControl, ...]
    descriptor: bytes = b""


@dataclass(frozen=True, slots=True)
class Refused:
    """A device cannot be read, and why."""

    path: str
    why: str
    forbidden: bool = False
    unsuitable: bool = False


@dataclass(frozen=True, slots=True)
class Gone:
    """A device that was read gives nothing any more."""

    path: str


News = Scanned | Opened | Refused | Gone


def hidapi() -> Any:  # noqa: ANN401 - an untyped library
    """The library; on Linux the half of it that goes through the kernel's own driver.

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


def joysticks_here() -> tuple[DeviceInfo, ...]:
    """All that is plugged in and says that it is a joystick, in the order of their numbers.

    Raises:
        HidMissingError: There is no hidapi.
    """
    return tuple(device for device in plugged_in() if device.joystick)


def controls_of(info: DeviceInfo) -> tuple[PhysicalControl, ...]:
    """What a device has; opens it for a moment.

    Raises:
        HidMissingError: There is no hidapi.
        PermissionError: This user may not read it.
        OSError: It cannot be opened.
        DescriptorError: It describes its reports in a way that makes no sense.
    """
    device = hidapi().device()
    try:
        return _open(device, info).controls
    finally:
        with _one_at_a_time:
            device.close()


class HidReader:
    """Looks for devices once a second, and reads those that it is told to.

    Everything it finds out waits in `news` and in the inboxes.
    """

    def __init__(self) -> None:
        self._notify: Callable[[], None] = lambda: None
        self._news: list[News] = []
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._look_now = threading.Event()
        self._readings: dict[str, _Reading] = {}
        self._threads: list[threading.Thread] = []

    def start(self, notify: Callable[[], None]) -> None:
        """Begin to look.

        Args:
            notify: Is called, in other threads, when there is something new.

        Raises:
            HidMissingError: There is no hidapi.
        """
        hidapi()
        self._notify = notify
        self._run(self._look_out, "rune-joysticks")

    def news(self) -> list[News]:
        """What has happened since the last call, in its order."""
        with self._lock:
            news, self._news = self._news, []
        return news

    def read(self, device: DeviceInfo) -> None:
        """Begin to read a device, unless that is going on; `Opened` or `Refused` follows."""
        if device.path not in self._readings:
            reading = self._readings[device.path] = _Reading(device, self._tell, self._notify)
            self._run(reading.run, f"rune-joystick {device.path}")

    def stop(self, path: str) -> None:
        """Read a device no more."""
        reading = self._readings.pop(path, None)
        if reading is not None:
            reading.ended.set()

    def inbox(self, path: str) -> Inbox | None:
        """What has come from a device that is read."""
        reading = self._readings.get(path)
        return None if reading is None else reading.inbox

    def look_now(self) -> None:
        """Look for devices without waiting for the next second."""
        self._look_now.set()

    def close(self) -> None:
        """End all threads."""
        self._ended.set()
        self._look_now.set()
        for path in list(self._readings):
            self.stop(path)
        for thread in self._threads:
            thread.join(_CLOSE_S)

    def _run(self, work: Callable[[], None], name: str) -> None:
        def deaf() -> None:
            # A signal, such as that of a resized terminal, would end a read as an unplug does.
            if hasattr(signal, "pthread_sigmask"):
                signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
            work()

        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=deaf, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _look_out(self) -> None:
        seen: object = None
        devices: tuple[DeviceInfo, ...] = ()
        while not self._ended.is_set():
            self._look_now.clear()
            try:
                # To list devices takes the library tens of milliseconds on some machines.
                if (nodes := _nodes()) is None or nodes != seen:
                    devices, seen = plugged_in(), nodes
                self._tell(Scanned(devices))
            except Exception:  # of the library; devices that are read go on
                _logger.exception("the devices cannot be listed")
            if self._look_now.wait(_LOOK_S):
                seen = None

    def _tell(self, news: News) -> None:
        with self._lock:
            self._news.append(news)
        if isinstance(news, Gone):
            self.look_now()
        self._notify()


class _Reading:
    """Reads one device, in a thread."""

    def __init__(
        self, device: DeviceInfo, tell: Callable[[News], None], notify: Callable[[], None]
    ) -> None:
        self.ended = threading.Event()
        self.inbox: Inbox | None = None
        self._info = device
        self._tell = tell
        self._notify = notify

    def run(self) -> None:
        """From opening it to its end."""
        device = hidapi().device()
        try:
            decoder = self._opened(device)
            if decoder is None:
                return
            self._read_on(device, decoder)
        except Exception as error:  # noqa: BLE001 - of the library; what is held has to be let go
            if not self.ended.is_set():
                self._tell(Gone(self._info.path))
                _logger.info("%s is not read any more: %s", self._info.path, error)
        finally:
            with _one_at_a_time:
                device.close()

    def _opened(self, device: Any) -> DeviceDecoder | None:  # noqa: ANN401 - of an untyped library
        path = self._info.path
        try:
            decoder = _open(device, self._info)
        except OSError as error:
            forbidden = isinstance(error, PermissionError)
            self._tell(Refused(path, str(error), forbidden=forbidden))
            return None
        except DescriptorError as error:
            why = f"its report descriptor cannot be read: {error}"
            self._tell(Refused(path, why, unsuitable=True))
            return None
        if not decoder.joystick:
            self._tell(Refused(path, "it is no joystick", unsuitable=True))
            return None
        self.inbox = Inbox(decoder.controls)
        self._tell(Opened(path, decoder.controls, decoder.descriptor))
        return decoder

    def _read_on(self, device: Any, decoder: DeviceDecoder) -> None:  # noqa: ANN401 - as above
        inbox = self.inbox or Inbox(decoder.controls)
        while not self.ended.is_set():
            report = device.read(_LONGEST_REPORT, _READ_MS)
            if not report:
                continue
            fresh, room = False, _MOST_AT_ONCE
            while report:
                fresh |= inbox.put(decoder.decode(bytes(report)))
                room -= 1
                report = device.read(_LONGEST_REPORT) if room else None
            if fresh:
                self._notify()
            time.sleep(_PAUSE_S)


def _open(device: Any, info: DeviceInfo) -> DeviceDecoder:  # noqa: ANN401 - as above
    """Open a device.

    Raises:
        PermissionError: This user may not read it.
        OSError: It cannot be opened.
        DescriptorError: It describes its reports in a way that makes no sense.
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
    """What changes when a device comes or goes; None where the system has no such thing."""
    try:
        with os.scandir(_HIDRAW) as entries:
            return sorted((entry.name, entry.inode()) for entry in entries)
    except OSError:
        return None


def _port(path: str) -> str:
    """Where a device is plugged in, where Linux tells; hidapi does not."""
    about = _HIDRAW / Path(path).name / "device/uevent"
    try:
        lines: Iterable[str] = about.read_text("utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    return next((line[9:] for line in lines if line.startswith("HID_PHYS=")), "")
