"""`rune demo`: one command, everything moves, nothing stays behind."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

import psutil
import pytest

from rune_tui.ui.ending import LEAVE_S
from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, family, gone, in_soak

F8 = "\x1b[19~"
RELEASED_S = 0.8
"""Time after which the console counts a key as released [s]."""


@pytest.fixture
def demo(stack: ExitStack) -> ConsoleProcess:
    return stack.enter_context(closing(ConsoleProcess(["demo"], columns=120, rows=40)))


def test_shows_a_picture_drives_and_leaves_nothing_behind(demo: ConsoleProcess) -> None:
    demo.wait_for_picture()
    # Console, hub, its reaper, the warmed parent, and the five modules that the layout wants.
    demo.wait(lambda: len(family(demo.process.pid)) == 9, 10.0)
    processes = family(demo.process.pid)
    demo.wait(lambda: "STANDING" in demo.text, 10.0)
    demo.hold_until("w", lambda: "MOVING" in demo.text)
    assert demo.quit() == 0
    until(lambda: gone(processes), 10.0, "processes are left")


@pytest.mark.soak
def test_drives_a_vehicle_with_a_simulated_autopilot(stack: ExitStack) -> None:
    command = ["demo", "--autopilot", "rover"]
    demo = stack.enter_context(closing(ConsoleProcess(command, columns=140, rows=45)))
    demo.wait_for_picture()
    demo.wait(lambda: "it is disarmed: arm it" in demo.text, 15.0)
    processes = family(demo.process.pid)
    for key in ("t", F8, F8):
        demo.type(key)
        released = time.monotonic() + RELEASED_S  # the console gets no release
        demo.wait(lambda released=released: time.monotonic() > released, 10.0)
    demo.wait(lambda: "ARMED · guided" in demo.text, 10.0)
    demo.hold_until("w", lambda: "MOVING" in demo.text)
    assert demo.quit() == 0
    until(lambda: gone(processes), 10.0, "processes are left")


@pytest.mark.parametrize("number", [signal.SIGKILL, *in_soak(signal.SIGTERM, signal.SIGHUP)])
def test_its_hub_ends_with_it_however_it_ends(demo: ConsoleProcess, number: signal.Signals) -> None:
    demo.wait_for_picture()
    processes = family(demo.process.pid)
    demo.process.send_signal(number)
    demo.wait_ended()
    until(lambda: gone(processes), 10.0, "processes are left")


@contextmanager
def suspended(*processes: psutil.Process) -> Iterator[None]:
    """Keep processes from running."""
    try:
        for process in processes:
            process.suspend()
        yield
    finally:
        for process in processes:
            with suppress(psutil.NoSuchProcess):
                process.resume()


@pytest.mark.soak
def test_its_hubs_end_in_parallel_and_later_than_a_terminal_that_blocks_may(
    stack: ExitStack,
) -> None:
    console = ConsoleProcess(["demo", "land-sea-air"], columns=120, rows=40)
    demo = stack.enter_context(closing(console))
    demo.wait_for_picture()
    processes = family(demo.process.pid)
    first, second, third = psutil.Process(demo.process.pid).children()
    with suspended(first, third):
        demo.type("q")
        ends = time.monotonic() + LEAVE_S
        demo.wait(lambda: gone([second]), 20.0)
        assert first.is_running(), "a hub waits for another one's end"
        assert third.is_running(), "a hub waits for another one's end"
        demo.wait(lambda: time.monotonic() > ends or demo.process.poll() is not None, 10.0)
    assert demo.wait_ended() == 0
    until(lambda: gone(processes), 10.0, "processes are left")
