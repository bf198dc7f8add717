"""`rune demo`: one command, everything moves, nothing stays behind."""

from __future__ import annotations

import signal
from contextlib import ExitStack, closing

import pytest

from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, family, gone, in_soak


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


@pytest.mark.parametrize("number", [signal.SIGKILL, *in_soak(signal.SIGTERM, signal.SIGHUP)])
def test_its_hub_ends_with_it_however_it_ends(demo: ConsoleProcess, number: signal.Signals) -> None:
    demo.wait_for_picture()
    processes = family(demo.process.pid)
    demo.process.send_signal(number)
    demo.wait_ended()
    until(lambda: gone(processes), 10.0, "processes are left")
