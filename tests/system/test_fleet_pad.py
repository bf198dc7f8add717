"""A gamepad at a robot's hub drives the robot through a console that sees it in a fleet."""

from __future__ import annotations

import os
import signal
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from tests.support import warm_start
from tests.support.fake_hid import VirtualBed, needs_virtual_devices
from tests.system.fleet_site import Site, stopped_after
from tests.system.gamepads import LAYOUT, PAD, drive, report
from tests.system.harness import ConsoleProcess

_STOPPED_S = 1.0
"""The bar of 0.35 s, with room for a busy machine [s]."""


@pytest.mark.soak
@needs_virtual_devices
def test_gamepad_at_the_robots_hub_drives_by_a_console_of_the_fleet_until_it_dies(
    tmp_path: Path,
) -> None:
    with ExitStack() as stack:
        site = stack.enter_context(closing(Site(tmp_path)))
        there, here = (stack.enter_context(closing(VirtualBed())) for _ in range(2))
        layout = tmp_path / "pad.xml"
        named = LAYOUT.replace('hub="{hub}"', 'fleet="rune/lab"').replace("magellan", "rover")
        layout.write_text(named)
        own = {"XDG_CONFIG_HOME": str(tmp_path), "XDG_STATE_HOME": str(tmp_path)}
        words = ["run", str(layout), "--fleet", site.place]
        console = ConsoleProcess(words, environment=here.environment | own)
        stack.enter_context(closing(console))
        console.wait(lambda: "linked" in console.text, 30.0, "no link")
        pad = there.plug(PAD)
        stack.callback(pad.unplug)
        with (tmp_path / "said.txt").open("w") as said:
            sender = warm_start.start(
                [sys.executable, "-m", "rune_tui", "pad", site.hub.endpoint],
                environment=os.environ | there.environment | own,
                stderr=said.fileno(),
            )
        try:
            pad.send(report(), timeout=20.0)
            console.wait(lambda: "plugged" in console.text, 20.0, "the console does not take it")
            drive(pad, site.observer, console)
            used = lambda: "used by the console of" in (tmp_path / "said.txt").read_text()  # noqa: E731
            console.wait(used, 10.0, "its sender does not know who uses it")
            sender.send_signal(signal.SIGKILL)
            died = time.monotonic()
            stopped_after(site.observer)
            history = site.observer.history
            last = max(when for when, truth in history if truth.commanded_linear != 0.0)
            assert last - died < _STOPPED_S
        finally:
            sender.kill()
            sender.wait()
