"""Whatever dies, the robot stops. Times are generous here; benchmarks/start.py measures them."""

from __future__ import annotations

import os
import signal

import pytest

from hub.gcm import navigation
from tests.system.harness import ConsoleProcess, HubProcess, Observer, in_soak
from tests.waiting import until

STILL = 1e-3


def _drive(console: ConsoleProcess, observer: Observer) -> None:
    console.hold_until("w", lambda: observer.truth.linear > 0.2)


def _expect_stop(observer: Observer) -> None:
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0, "the wheels are driven on")
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 2.0, "it rolls on")


@pytest.mark.parametrize(
    "number", [signal.SIGKILL, signal.SIGSTOP, *in_soak(signal.SIGTERM, signal.SIGHUP)]
)
def test_console_gone_robot_stops(
    console: ConsoleProcess, observer: Observer, number: signal.Signals
) -> None:
    _drive(console, observer)
    console.process.send_signal(number)
    _expect_stop(observer)
    if number is signal.SIGSTOP:
        # Awake again, it must not drive off with the key that was held before.
        observer.history.clear()
        console.process.send_signal(signal.SIGCONT)
        console.pump(1.0)
        observer.wait(lambda: len(observer.history) > 40, 5.0)
        assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)


def test_keys_typed_while_the_console_was_stopped_do_not_drive(
    console: ConsoleProcess, observer: Observer
) -> None:
    console.process.send_signal(signal.SIGSTOP)
    observer.history.clear()
    console.type("wwwwwwwwww")
    observer.wait(lambda: len(observer.history) > 30, 5.0)
    console.process.send_signal(signal.SIGCONT)
    console.pump(0.5)
    observer.wait(lambda: len(observer.history) > 60, 5.0)
    assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_navigation_gone_robot_stops(
    hub: HubProcess, console: ConsoleProcess, observer: Observer, number: signal.Signals
) -> None:
    _drive(console, observer)
    os.kill(hub.pids["navigation"], number)
    for _ in range(10):
        console.hold("w", 0.05)
        observer.client.listen(0.01)
    _expect_stop(observer)
    if number is signal.SIGSTOP:
        os.kill(hub.pids["navigation"], signal.SIGCONT)


def test_navigation_comes_back_and_waits_for_neutral(
    hub: HubProcess, console: ConsoleProcess, observer: Observer
) -> None:
    _drive(console, observer)
    os.kill(hub.pids["navigation"], signal.SIGKILL)
    _expect_stop(observer)
    console.wait(lambda: "STANDING" in console.text or "WAITING" in console.text, 10.0)
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")
    _drive(console, observer)


def test_driver_comes_back_and_waits_for_neutral(
    hub: HubProcess, console: ConsoleProcess, observer: Observer
) -> None:
    _drive(console, observer)
    os.kill(hub.pids["driver"], signal.SIGKILL)
    until(lambda: "the driver began anew" in hub.log.read_text(), 10.0, meanwhile=console.pump)
    assert observer.truth.commanded_linear == 0.0
    console.wait(lambda: "STANDING" in console.text, 10.0, "neutral commands do not reach it")
    _drive(console, observer)


def test_a_stop_from_anyone_stops_until_keys_are_let_go(
    console: ConsoleProcess, observer: Observer
) -> None:
    _drive(console, observer)
    observer.client.define(navigation.STOP)
    observer.client.wait_defined(5.0)
    observer.client.publish(navigation.STOP, navigation.Stop(reason="a test"))
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0)
    console.hold("w", 0.5)
    assert observer.truth.commanded_linear == 0.0
    console.pump(1.0)
    _drive(console, observer)
