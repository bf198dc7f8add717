"""Whatever becomes of the console, the robot stops.

Times are generous here; benchmarks/start.py measures them.
"""

from __future__ import annotations

import signal

import pytest

from hub.gcm import navigation
from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive, expect_stop, in_soak


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.mark.parametrize(
    "number", [signal.SIGKILL, signal.SIGSTOP, *in_soak(signal.SIGTERM, signal.SIGHUP)]
)
def test_console_gone_robot_stops(
    console: ConsoleProcess, observer: Observer, number: signal.Signals
) -> None:
    drive(console, observer)
    console.process.send_signal(number)
    expect_stop(observer)
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


def test_a_stop_from_anyone_stops_until_keys_are_let_go(
    console: ConsoleProcess, observer: Observer
) -> None:
    drive(console, observer)
    observer.client.define(navigation.STOP)
    observer.client.wait_defined(5.0)
    observer.client.publish(navigation.STOP, navigation.Stop(reason="a test"))
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0)
    console.hold("w", 0.5)
    assert observer.truth.commanded_linear == 0.0
    console.pump(1.0)
    drive(console, observer)
