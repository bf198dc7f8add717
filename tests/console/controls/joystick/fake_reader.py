"""A reader of devices that are not there."""

from __future__ import annotations

from collections.abc import Callable

from rune_tui.controls.devices.device_reader import News
from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.model.joystick_state import Absence
from tests.console.controls.joystick.pads import PAD


class FakeReader:
    """What the hardware would say."""

    def __init__(self) -> None:
        self.started = 0
        self.told: list[News] = []
        self.asked: list[str] = []
        self.inboxes: dict[str, Inbox] = {}
        self.ages: dict[str, float] = {}
        self.absences: dict[str, Absence] = {}

    def start(self, notify: Callable[[], None]) -> None:
        self.notify = notify
        self.started += 1

    def news(self) -> list[News]:
        told, self.told = self.told, []
        return told

    def read(self, device: DeviceInfo) -> None:
        if device.path not in self.inboxes:
            self.asked.append(device.path)
            self.inboxes[device.path] = Inbox(PAD)

    def stop(self, path: str) -> None:
        self.inboxes.pop(path, None)

    def inbox(self, path: str) -> Inbox | None:
        return self.inboxes.get(path)

    def measured(self, path: str) -> float | None:
        return self.ages.get(path)

    def absence(self, path: str) -> Absence | None:
        return self.absences.get(path)

    def close(self) -> None:
        self.inboxes.clear()
