"""A gamepad that speaks no HID drives the robot, and its end stops it."""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

from tests.support import warm_start
from tests.support.fake_evdev import ABS, NAME, VirtualXboxPad, needs_virtual_pads
from tests.support.fake_hid import VirtualBed
from tests.system.gamepads import console_at, forward
from tests.system.harness import ConsoleProcess, HubProcess, Observer, expect_stop

pytestmark = needs_virtual_pads

NEUTRAL, AHEAD = (ABS, 1, 0), (ABS, 1, -32768)


def test_an_xbox_pad_is_listed_drives_and_its_end_stops_the_robot(
    hub: HubProcess, observer: Observer, bed: VirtualBed, tmp_path: Path
) -> None:
    pad = VirtualXboxPad(bed)
    command = [sys.executable, "-m", "rune_tui", "joytest", "--list", "--json"]
    listing = warm_start.run(command, environment=os.environ | bed.environment)
    (told,) = [each for each in json.loads(listing.stdout) if each["name"] == NAME]
    assert not told["trouble"]
    assert {"leftx", "righttrigger", "dpad", "start"} <= {each["role"] for each in told["controls"]}
    with console_at(hub, bed, tmp_path) as console:
        for _ in range(5):  # commands of a busy machine may fall silent: then push again
            pad.send(NEUTRAL)
            console.wait(lambda: forward(console) == "+0.00", 10.0, "it is not seen at rest")
            console.pump(0.3)
            pad.send(AHEAD)
            if _drives(console, observer):
                break
        assert _drives(console, observer)
        pad.unplug()
        expect_stop(observer)


def _drives(console: ConsoleProcess, observer: Observer) -> bool:
    """Whether the robot drives within a few seconds."""
    end = time.monotonic() + 5.0
    while time.monotonic() < end and observer.truth.linear < 0.3:
        console.pump(0.02)
        observer.client.listen(0.01)
    return observer.truth.linear >= 0.3
