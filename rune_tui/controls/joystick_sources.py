"""All devices that the console can read: of this machine and of other machines."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Protocol

from rune_tui.controls.devices.device_reader import News, Scanned
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.remote_pad.far_pads import FarPads
from rune_tui.model.joystick_state import Absence


class Devices(Protocol):
    """The reader of this machine's devices; see `DeviceReader`."""

    def start(self, notify: Callable[[], None]) -> None:
        """Start the search for devices."""

    def news(self) -> list[News]:
        """The events since the last call."""

    def read(self, device: DeviceInfo) -> None:
        """Begin to read a device."""

    def stop(self, path: str) -> None:
        """Read a device no more."""

    def inbox(self, path: str) -> Inbox | None:
        """The new values of a device."""

    def close(self) -> None:
        """End."""


class Sources:
    """One reader for both kinds of devices."""

    def __init__(self, near: Devices, far: FarPads) -> None:
        self._near, self._far = near, far
        self._near_devices: tuple[DeviceInfo, ...] = ()
        self._far_devices: tuple[DeviceInfo, ...] = ()

    def start(self, notify: Callable[[], None]) -> None:
        """Start the search for devices.

        Raises:
            HidMissingError: hidapi is missing; devices of other machines are still read.
        """
        self._far.start(notify)
        self._near.start(notify)

    def news(self) -> list[News]:
        """The events since the last call."""
        news: list[News] = []
        for each in self._near.news():
            if isinstance(each, Scanned):
                self._near_devices = each.devices
            news.append(self._whole(each))
        for each in self._far.news():
            if isinstance(each, Scanned):
                self._far_devices = each.devices
            news.append(self._whole(each))
        return news

    def read(self, device: DeviceInfo) -> None:
        """Begin to read a device."""
        (self._far if device.machine else self._near).read(device)

    def stop(self, path: str) -> None:
        """Read a device no more."""
        self._far.stop(path)
        self._near.stop(path)

    def inbox(self, path: str) -> Inbox | None:
        """The new values of a device."""
        return self._near.inbox(path) or self._far.inbox(path)

    def measured(self, path: str) -> float | None:
        """When the newest state of another machine's device was measured [s]."""
        return self._far.measured(path)

    def absence(self, path: str) -> Absence | None:
        """Why another machine's device is gone; None: not known."""
        return self._far.absence(path)

    def close(self) -> None:
        """End."""
        self._far.close()
        self._near.close()

    def _whole(self, news: News) -> News:
        if not isinstance(news, Scanned):
            return news
        return dataclasses.replace(news, devices=(*self._near_devices, *self._far_devices))
