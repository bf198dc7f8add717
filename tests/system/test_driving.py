"""A person at the keyboard drives the robot: measured in ground truth, seen on the screen."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from tests.system.conftest import console_of
from tests.system.harness import STILL, ConsoleProcess, HubProcess, Observer, drive


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture(scope="module")
def lasting_console(
    lasting_hub: HubProcess, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ConsoleProcess]:
    with closing(console_of(lasting_hub.endpoint, tmp_path_factory.mktemp("console"))) as started:
        started.wait_for_picture()
        yield started


@pytest.fixture
def console(lasting_console: ConsoleProcess) -> ConsoleProcess:
    """Has the focus; no key is down, and the robot stands."""
    lasting_console.type("\x1b[I")
    lasting_console.wait(lambda: "STANDING" in lasting_console.text, 10.0)
    return lasting_console


def test_w_drives_forward_and_letting_go_stops(console: ConsoleProcess, observer: Observer) -> None:
    before = observer.truth
    console.hold_until("w", lambda: observer.truth.x - before.x > 0.2)
    assert abs(observer.truth.y - before.y) < 0.1
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 5.0, "it drives on")
    assert observer.truth.commanded_linear == 0.0


def test_the_picture_changes_when_the_robot_moves(
    console: ConsoleProcess, observer: Observer
) -> None:
    before = console.colours()
    console.hold_until("a", lambda: observer.truth.theta > 0.3)
    console.wait(
        lambda: sum(console.colours()[cell] != before[cell] for cell in before) > len(before) / 4,
        5.0,
        "the picture stays",
    )


def test_s_drives_back_and_a_and_d_turn(console: ConsoleProcess, observer: Observer) -> None:
    console.hold_until("s", lambda: observer.truth.linear < -0.2)
    console.hold_until("d", lambda: observer.truth.angular < -0.2)
    console.hold_until("a", lambda: observer.truth.angular > 0.2)


def test_space_stops_at_once_and_the_held_key_no_longer_drives(
    console: ConsoleProcess, observer: Observer
) -> None:
    drive(console, observer)
    console.type(" ")
    console.hold("w", 0.5)
    assert observer.truth.commanded_linear == 0.0
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 5.0)


def test_the_status_line_says_what_the_robot_does(console: ConsoleProcess) -> None:
    console.wait(lambda: "STANDING" in console.text, 10.0)
    console.hold_until("w", lambda: "MOVING" in console.text)
    console.wait(lambda: "STANDING" in console.text, 10.0)


def test_j_turns_the_camera_to_the_left(console: ConsoleProcess) -> None:
    console.type("jj")
    console.wait(lambda: "left" in console.text, 5.0)


def test_q_quits_with_the_terminal_restored(
    hub: HubProcess, start_console: Callable[..., ConsoleProcess]
) -> None:
    console = start_console(hub.endpoint)
    console.wait_for_picture()
    assert console.quit() == 0


def test_losing_the_focus_lets_go_of_all_keys(console: ConsoleProcess, observer: Observer) -> None:
    drive(console, observer)
    console.type("\x1b[O")
    # Sooner than the key would count as released for want of repeats alone.
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "it drives on")


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
