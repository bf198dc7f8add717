"""Whatever module dies, the robot stops.

Times are generous here; benchmarks/start.py measures them.
"""

from __future__ import annotations

import os
import signal

from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive, expect_stop
from tests.waiting import until


def _hold_on(console: ConsoleProcess, observer: Observer) -> None:
    """Keep the key down, as who has not noticed does."""
    for _ in range(10):
        console.hold("w", 0.05)
        observer.client.listen(0.01)


def test_whatever_dies_the_robot_stops_and_drives_again_from_neutral(
    hub: HubProcess, console: ConsoleProcess, observer: Observer
) -> None:
    """Navigation hangs, then is killed, then the driver; each begins with a robot that drives."""
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
    until(lambda: "the driver began anew" in hub.log.read_text(), 10.0, meanwhile=console.pump)
    assert observer.truth.commanded_linear == 0.0
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")
    drive(console, observer)
