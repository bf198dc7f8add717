"""A virtual gamepad drives the simulated robot through the real console: no hardware, no fakes."""

from __future__ import annotations

import ctypes
import fcntl
import os
import signal
import struct
import termios
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest

from tests.support.fake_hid import VirtualBed, VirtualDevice, needs_virtual_devices
from tests.system.gamepads import NAME, PAD, console_at, drive, expect_no_driving, forward, report
from tests.system.harness import ConsoleProcess, HubProcess, Observer, expect_stop

pytestmark = needs_virtual_devices


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture(scope="module")
def console(
    lasting_hub: HubProcess, bed: VirtualBed, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ConsoleProcess]:
    with console_at(lasting_hub, bed, tmp_path_factory.mktemp("console")) as started:
        yield started


Plug = Callable[[], VirtualDevice]


@pytest.fixture
def plug(bed: VirtualBed, console: ConsoleProcess) -> Iterator[Plug]:
    """Plugs the pad in, and out at the end."""
    with ExitStack() as stack:

        def plugged() -> VirtualDevice:
            pad = bed.plug(PAD)
            stack.callback(pad.unplug)
            console.wait(lambda: f"{NAME} (DirectInput mode): plugged in" in console.text, 10.0)
            return pad

        yield plugged
    console.wait(lambda: "UNPLUGGED" in console.text or "not plugged" in console.text, 10.0)


@pytest.fixture
def pad(plug: Plug) -> VirtualDevice:
    """Plugged in, nobody touches it."""
    plugged = plug()
    plugged.send(report())
    return plugged


def test_the_stick_drives_as_far_as_it_is_moved_and_its_neutral_stops(
    pad: VirtualDevice, observer: Observer, console: ConsoleProcess
) -> None:
    drive(pad, observer, console)
    console.wait(lambda: forward(console) == "+1.00", 5.0, "the bar does not show it")
    pad.send(report(y=70))
    observer.wait(lambda: 0.05 < observer.truth.linear < 0.3, 10.0, "half is not slower")
    pad.send(report(x=0))
    observer.wait(lambda: observer.truth.angular > 0.5, 10.0, "left does not turn left")
    pad.send(report())
    expect_stop(observer)


def test_a_terminal_that_changes_its_size_is_no_unplug(
    pad: VirtualDevice, observer: Observer, console: ConsoleProcess
) -> None:
    drive(pad, observer, console)
    for columns in (90, 110, 100):
        fcntl.ioctl(console.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 30, columns, 0, 0))
        # The system gives the signal to any thread; here each has it, the device's own too.
        pid = console.process.pid
        for thread in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208 - names are all it wants
            ctypes.CDLL(None).tgkill(pid, int(thread), signal.SIGWINCH)
        console.pump(0.1)
    # A device that was lost and found again has said nothing yet, and its loss is told for a while.
    console.wait(lambda: forward(console) == "+1.00", 10.0, "what the stick said is forgotten")
    assert "is gone" not in console.text


def test_a_stop_of_the_pad_stops_until_the_stick_was_neutral(
    pad: VirtualDevice, observer: Observer, console: ConsoleProcess
) -> None:
    drive(pad, observer, console)
    pad.send(report(y=0, b=True))
    expect_stop(observer)
    pad.send(report(y=10))
    expect_no_driving(observer)
    drive(pad, observer, console)


def test_the_operator_is_led_through_a_calibration_on_the_screen(
    pad: VirtualDevice, console: ConsoleProcess, observer: Observer
) -> None:
    console.type("c")
    for axis in ("lefty", "leftx"):
        steps = (f"{axis} to its maximum", f"{axis} to its minimum", f"let go of {axis}")
        for step, raw in zip(steps, (20, 230, 120), strict=True):
            console.wait(lambda said=step: said in console.text, 10.0, step)
            moved = {axis.removeprefix("left"): raw}
            pad.send(report(**moved))
            pad.send(report(**moved, b=True))
            pad.send(report(**moved))
    console.wait(lambda: "the calibration is in" in console.text, 10.0)
    expect_no_driving(observer)
