"""A joystick of the input layer after the kernel lost events: how it is then, not how it was."""

from __future__ import annotations

import os
import sys
from collections import namedtuple
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from rune_tui.controls.devices.evdev_reader import EvdevDevice
from rune_tui.controls.devices.matching import DeviceInfo
from tests.support.fake_evdev import ABS, AXES, BUTTONS, KEY, A

SYN, REPORT, DROPPED = 0, 0, 3
AHEAD = -32768

About = namedtuple("About", "value min max")
Event = namedtuple("Event", "type code value")


class Pad:
    """What python-evdev has of a device: what it can do is asked once, as there."""

    opened: ClassVar[Pad]

    def __init__(self, path: str) -> None:
        del path
        Pad.opened = self
        self.fd, self.writer = os.pipe()
        self.positions = dict.fromkeys(AXES, 0)
        self.pressed: list[int] = []
        self.waiting: list[Event] = []
        self._able = {ABS: [(code, self.absinfo(code)) for code in AXES], KEY: list(BUTTONS)}

    def capabilities(self, *, absinfo: bool) -> dict[int, Any]:
        assert absinfo
        return self._able

    def absinfo(self, code: int) -> About:
        return About(self.positions[code], *AXES[code])

    def active_keys(self) -> list[int]:
        return self.pressed

    def tell(self, *events: tuple[int, int, int]) -> None:
        self.waiting += [Event(*each) for each in events]
        os.write(self.writer, b"!")

    def read(self) -> Iterator[Event]:
        os.read(self.fd, 1)
        events, self.waiting = self.waiting, []
        return iter(events)

    def close(self) -> None:
        os.close(self.fd)
        os.close(self.writer)


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[EvdevDevice]:
    monkeypatch.setitem(sys.modules, "evdev", SimpleNamespace(InputDevice=Pad))
    opened = EvdevDevice(DeviceInfo(path="pad", vid=0x045E, pid=0x028E))
    yield opened
    opened.close()


def value(device: EvdevDevice, role: str) -> int | None:
    roles = [control.role for control in device.controls]
    values = device.read(1.0)
    assert values is not None
    return dict(values)[roles.index(role)]


def test_after_lost_events_a_stick_is_where_it_is_now(device: EvdevDevice) -> None:
    pad = Pad.opened
    assert value(device, "lefty") == 0
    pad.tell((ABS, 1, AHEAD), (SYN, REPORT, 0))
    assert value(device, "lefty") == AHEAD
    pad.positions[1], pad.pressed = AHEAD // 2, [A]
    pad.tell((SYN, DROPPED, 0), (ABS, 1, AHEAD), (SYN, REPORT, 0))
    assert value(device, "lefty") == AHEAD // 2
    pad.tell((SYN, DROPPED, 0))
    assert value(device, "a") == 1


def test_a_stick_that_moved_since_the_opening_is_seen_where_it_is(device: EvdevDevice) -> None:
    pad = Pad.opened
    pad.positions[1] = AHEAD
    assert value(device, "lefty") == AHEAD
