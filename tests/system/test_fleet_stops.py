"""How soon the last motion is commanded after a part of a fleet died: the bar of all robots."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.system.fleet_site import Site, stopped_after
from tests.system.harness import ConsoleProcess, Observer, drive

STOPPED_S = 0.35
"""Longest time from a death to the last command that is not zero [s]."""
_SAMPLE_S = 0.1
"""Longest time between two samples of the wheels' commands [s]."""
_TRIES, _TRY_S = 5, 3.0
_QUIET_S = 1.0
"""Time after the stop in which no motion may come back [s]."""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    """Another one for each test, so that its robot has room ahead."""
    with closing(Site(tmp_path)) as made:
        yield made


@contextlib.contextmanager
def _driving(console: ConsoleProcess, observer: Observer) -> Iterator[None]:
    """A key is held, and the robot has been driven for a second.

    Where commands fall silent on a busy machine, the robot wants neutral: press again then.
    """
    for _ in range(_TRIES):
        drive(console, observer)
        stopped_after(observer)
        with contextlib.ExitStack() as hand:
            hand.enter_context(console.holding("w"))
            end = time.monotonic() + _TRY_S
            observer.wait(
                lambda end=end: _drives_on(observer) or time.monotonic() > end, 2 * _TRY_S
            )
            if _drives_on(observer):
                yield
                return
        stopped_after(observer)
    pytest.fail("the robot does not drive on")


def _drives_on(observer: Observer) -> bool:
    """Whether each command of the last second was a motion, up to now."""
    since = time.monotonic() - 1.0
    newest = [truth.commanded_linear for when, truth in observer.history if when > since]
    return len(newest) > 20 and min(newest) > 0.0


@pytest.mark.soak
@pytest.mark.parametrize("victim", ["console", "router", "paused router", "gateway"])
def test_no_motion_is_commanded_after_the_bar(site: Site, victim: str) -> None:
    observer = site.observer
    with closing(site.console()) as console:
        with _driving(console, observer):
            died = time.monotonic()
            if victim == "router":
                site.kill_router()
            elif victim == "paused router":
                site.router.send_signal(signal.SIGSTOP)
            else:
                killed = console.process.pid if victim == "console" else site.hub.pids["fleet"]
                os.kill(killed, signal.SIGKILL)
            observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "it is driven on")
            end = time.monotonic() + _QUIET_S
            observer.wait(lambda: time.monotonic() > end, 10.0)
            moving = [when for when, truth in observer.history if truth.commanded_linear != 0.0]
            last = moving[-1] - died
            assert last > -_SAMPLE_S, "it stood before"
            print(f"{victim}: last motion after {last:.3f} s")  # noqa: T201
            assert last <= STOPPED_S
        if victim == "paused router":
            site.router.send_signal(signal.SIGCONT)
