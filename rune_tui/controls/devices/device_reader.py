"""Finds devices of the given kinds and reads each in a thread."""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from hub.values import dataclass
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid.reading import Value
from rune_tui.errors import DescriptorError

_logger = logging.getLogger(__name__)

_CHECK_S = 1.0
"""Time between two searches for devices; no library reports new ones [s]."""
_READ_S = 0.1
_PAUSE_S = 0.004
"""Reports are collected for this time, so that a device of 1 kHz does not wake the console at
that rate [s]."""
_MOST_AT_ONCE = 64
"""Reports that the kernel keeps for a reader."""
_CLOSE_S = 2.0


@dataclass(frozen=True, slots=True)
class Scanned:
    """The connected devices, joysticks and others."""

    devices: tuple[DeviceInfo, ...]


@dataclass(frozen=True, slots=True)
class Opened:
    """The device is open; its controls, from its descriptor."""

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


class OpenDevice(Protocol):
    """A device that is read.

    Attributes:
        controls: Its controls; none: it is no joystick.
        descriptor: A HID report descriptor with these controls.
    """

    controls: tuple[PhysicalControl, ...]
    descriptor: bytes

    def read(self, timeout: float) -> tuple[Value, ...] | None:
        """The values of the next report; None: there is none within this time [s].

        Raises:
            Exception: The device is gone, or a fault of its library.
        """

    def close(self) -> None:
        """Give it back."""


class Kind(Protocol):
    """A kind of devices, as the system offers them."""

    def require(self) -> None:
        """Load what it needs.

        Raises:
            HidMissingError: That is not installed.
        """

    def plugged_in(self) -> tuple[DeviceInfo, ...]:
        """All devices of this kind, each once, joysticks and others."""

    def mark(self) -> object:
        """A value that changes with the connected devices; None: the system has none."""

    def open(self, info: DeviceInfo) -> OpenDevice:
        """Open a device.

        Raises:
            PermissionError: This user may not read it.
            OSError: It cannot be opened.
            DescriptorError: Its descriptor is not valid.
        """


class DeviceReader:
    """Searches for devices once a second, and reads the requested ones.

    Its results wait in `news` and in the inboxes.
    """

    def __init__(self, kinds: Sequence[Kind]) -> None:
        """Prepare.

        Args:
            kinds: The kinds of devices; a device of the first kind is not offered by others.
        """
        self._kinds = tuple(kinds)
        self._kind_of: dict[str, Kind] = {}
        self._notify: Callable[[], None] = lambda: None
        self._news: list[News] = []
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._check_now = threading.Event()
        self._readings: dict[str, _Reading] = {}
        self._threads: list[threading.Thread] = []

    def start(self, notify: Callable[[], None]) -> None:
        """Start the search.

        Args:
            notify: Called from other threads when there are news.

        Raises:
            HidMissingError: A library of the first kind is not installed.
        """
        self._kinds[0].require()
        self._notify = notify
        self._run(self._watch, "rune-joysticks")

    def news(self) -> list[News]:
        """The events since the last call, in order."""
        with self._lock:
            news, self._news = self._news, []
        return news

    def read(self, device: DeviceInfo) -> None:
        """Begin to read a device, unless it is read already; `Opened` or `Refused` follows."""
        if device.path not in self._readings:
            reading = self._readings[device.path] = _Reading(
                device, self._kind_of.get(device.path, self._kinds[0]), self._post, self._notify
            )
            self._run(reading.run, f"rune-joystick {device.path}")

    def stop(self, path: str) -> None:
        """Read a device no more."""
        reading = self._readings.pop(path, None)
        if reading is not None:
            reading.ended.set()

    def inbox(self, path: str) -> Inbox | None:
        """The new values of a device in use."""
        reading = self._readings.get(path)
        return None if reading is None else reading.inbox

    def check_now(self) -> None:
        """Search now, not at the next second."""
        self._check_now.set()

    def close(self) -> None:
        """End all threads."""
        self._ended.set()
        self._check_now.set()
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

    def _watch(self) -> None:
        seen: object = None
        devices: tuple[DeviceInfo, ...] = ()
        while not self._ended.is_set():
            self._check_now.clear()
            try:
                # To list devices takes a library tens of milliseconds on some machines.
                marks = [kind.mark() for kind in self._kinds]
                if None in marks or marks != seen:
                    devices, seen = self._plugged_in(), marks
                self._post(Scanned(devices))
            except Exception:  # of the library; devices that are read go on
                _logger.exception("the devices cannot be listed")
            if self._check_now.wait(_CHECK_S):
                seen = None

    def _plugged_in(self) -> tuple[DeviceInfo, ...]:
        found, self._kind_of = plugged_in(self._kinds)
        return found

    def _post(self, news: News) -> None:
        with self._lock:
            self._news.append(news)
        if isinstance(news, Gone):
            self.check_now()
        self._notify()


class _Reading:
    """Reads one device, in a thread."""

    def __init__(
        self,
        device: DeviceInfo,
        kind: Kind,
        post: Callable[[News], None],
        notify: Callable[[], None],
    ) -> None:
        self.ended = threading.Event()
        self.inbox: Inbox | None = None
        self._info = device
        self._kind = kind
        self._post = post
        self._notify = notify

    def run(self) -> None:
        """From opening it to its end."""
        device: OpenDevice | None = None
        try:
            device = self._opened()
            if device is not None:
                self._read_on(device)
        except Exception as error:  # noqa: BLE001 - of the library; held controls must be released
            if not self.ended.is_set():
                self._post(Gone(self._info.path))
                _logger.info("%s is not read any more: %s", self._info.path, error)
        finally:
            if device is not None:
                device.close()

    def _opened(self) -> OpenDevice | None:
        path = self._info.path
        try:
            device = self._kind.open(self._info)
        except OSError as error:
            forbidden = isinstance(error, PermissionError)
            self._post(Refused(path, str(error), forbidden=forbidden))
            return None
        except DescriptorError as error:
            why = f"its report descriptor cannot be read: {error}"
            self._post(Refused(path, why, unsuitable=True))
            return None
        if not device.controls:
            device.close()
            self._post(Refused(path, "it is no joystick", unsuitable=True))
            return None
        self.inbox = Inbox(device.controls)
        self._post(Opened(path, device.controls, device.descriptor))
        return device

    def _read_on(self, device: OpenDevice) -> None:
        """Pass on what waits together, and a report that comes later as soon as it comes."""
        inbox = self.inbox or Inbox(device.controls)
        while not self.ended.is_set():
            fresh, count = False, 0
            while count < _MOST_AT_ONCE and (values := device.read(0.0)) is not None:
                fresh |= inbox.put(values)
                count += 1
            if not count:
                values = device.read(_READ_S)
                if values is None:
                    continue
                fresh = inbox.put(values)
            if fresh:
                self._notify()
            time.sleep(_PAUSE_S)


def plugged_in(kinds: Sequence[Kind]) -> tuple[tuple[DeviceInfo, ...], dict[str, Kind]]:
    """All devices of these kinds, and the kind of each by its path.

    A kind that cannot be listed is left out; the first kind raises.
    """
    found: list[DeviceInfo] = []
    kind_of: dict[str, Kind] = {}
    for kind in kinds:
        try:
            devices = kind.plugged_in()
        except Exception:
            if kind is kinds[0]:
                raise
            _logger.exception("devices of a second kind cannot be listed")
            continue
        found += devices
        kind_of |= {device.path: kind for device in devices}
    return tuple(found), kind_of
