"""Whatever module dies, the robot stops.

Times are generous here; benchmarks/start.py measures them.
"""

from __future__ import annotations

import os
import signal

import psutil

from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive, expect_stop


def _hold_on(console: ConsoleProcess, observer: Observer) -> None:
    """Keep the key down, as who has not noticed does."""
    for _ in range(10):
        console.hold("w", 0.05)
        observer.client.listen(0.01)


def test_whatever_dies_the_robot_stops_and_drives_again_from_neutral(
    hub: HubProcess, console: ConsoleProcess, observer: Observer
) -> None:
    """Navigation hangs, then is killed; the driver is killed, then hangs; each time it drives."""
    drive(console, observer)
    os.kill(hub.pids["navigation"], signal.SIGSTOP)
    _hold_on(console, observer)
    expect_stop(observer)
    os.kill(hub.pids["navigation"], signal.SIGCONT)

    drive(console, observer)
    os.kill(hub.pids["navigation"], signal.SIGKILL)
    _hold_on(console, observer)
    expect_stop(observer)
    console.wait(lambda: "STANDING" in console.text or "WAITING" in console.text, 10.0)
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")

    drive(console, observer)
    os.kill(hub.pids["driver"], signal.SIGKILL)
    until(lambda: _new_drivers(hub) == 1, 10.0, meanwhile=console.pump)
    assert observer.truth.commanded_linear == 0.0
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")

    drive(console, observer)
    os.kill(_driver(hub), signal.SIGSTOP)
    until(
        lambda: "driver hung: silent for 1 s" in hub.log.read_text(), 10.0, meanwhile=console.pump
    )
    until(lambda: _new_drivers(hub) == 2, 10.0, meanwhile=console.pump)
    assert observer.truth.commanded_linear == 0.0
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")
    drive(console, observer)


def _new_drivers(hub: HubProcess) -> int:
    """How often navigation has reported a driver that restarted."""
    return hub.log.read_text().count("the driver restarted")


def _driver(hub: HubProcess) -> int:
    """The process of the driver now."""
    modules = psutil.Process(hub.process.pid).children(recursive=True)
    (driver,) = [each.pid for each in modules if "hub.modules.driver" in each.cmdline()]
    return driver
