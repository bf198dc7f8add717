"""How soon the last motion is commanded after a part of a fleet died: the bar of all robots."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing

import pytest

from tests.conftest import leaving_nothing
from tests.system.fleet_site import Site, stopped_after
from tests.system.harness import Observer, drive

STOPPED_S = 0.35
"""Longest time from a death to the last command that is not zero [s]."""
_SAMPLE_S = 0.1
"""Longest time between two samples of the wheels' commands [s]."""
_QUIET_S = 1.0
"""Time after the stop in which no motion may come back [s]."""


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """The router and the gateway are started again in a test, and stay for the next."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def site(nothing_left_behind: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    del nothing_left_behind
    with closing(Site(tmp_path_factory.mktemp("fleet"))) as made:
        yield made


def _drives_on(observer: Observer) -> bool:
    """Whether each command of the last second was a motion, up to now."""
    since = time.monotonic() - 1.0
    newest = [truth.commanded_linear for when, truth in observer.history if when > since]
    return len(newest) > 20 and min(newest) > 0.0


@pytest.mark.soak
@pytest.mark.timeout(120)
@pytest.mark.parametrize("victim", ["console", "router", "paused router", "gateway"])
def test_no_motion_is_commanded_after_the_bar(site: Site, victim: str) -> None:
    observer = site.observer
    with closing(site.console()) as console:
        drive(console, observer)
        stopped_after(observer)
        with console.holding("w"):
            observer.wait(lambda: _drives_on(observer), 20.0, "it does not drive on")
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
        if victim == "router":
            site.start_router()
        elif victim == "paused router":
            site.router.send_signal(signal.SIGCONT)
