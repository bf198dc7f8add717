"""Two consoles at one robot: it follows who has control, and everybody can stop it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import ExitStack, closing

import pytest

from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.navigation import GROUND_TRUTH
from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive, expect_stop

HELD_S = 1.5
Start = Callable[[str], ConsoleProcess]


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture
def observer(hub: HubProcess, stack: ExitStack) -> Observer:
    """Sees ground truth and who has control."""
    return stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH, CONTROL_STATE)))


@pytest.fixture
def start(hub: HubProcess, stack: ExitStack) -> Start:
    """Start somebody's console."""

    def started(operator: str) -> ConsoleProcess:
        arguments = ["run", "demo", "--hub", hub.endpoint]
        environment = {"LOGNAME": operator}
        console = ConsoleProcess(arguments, columns=160, environment=environment)
        stack.enter_context(closing(console))
        console.wait(lambda: "STANDING" in console.text or "has control" in console.text, 20.0)
        return console

    return started


def control(observer: Observer) -> ControlState:
    state: ControlState = observer.seen[CONTROL_STATE.name][-1][1]
    return state


def wait_owner(observer: Observer, operator: str) -> None:
    observer.wait(
        lambda: control(observer).operator == operator, 15.0, lambda: str(control(observer))
    )


def test_wheels_follow_the_owner_only_and_anybody_stops_them(
    start: Start, observer: Observer
) -> None:
    alice, bob = start("alice"), start("bob")
    drive(alice, observer)
    wait_owner(observer, "alice")
    bob.wait(lambda: "alice has control" in bob.text, 10.0)
    observer.history.clear()
    for _ in range(round(HELD_S / 0.1)):
        alice.hold("w", 0.05)
        bob.hold("s", 0.05)
        observer.client.listen(0.01)
    commanded = [truth.commanded_linear for _, truth in observer.history]
    assert min(commanded) >= 0.0 < max(commanded)
    assert "you have control" not in bob.text
    bob.type(" ")
    bob.pump(0.1)
    expect_stop(observer)
    assert control(observer).operator == "alice"


def test_who_asks_is_given_control_and_the_robot_stands_until_they_drive(
    start: Start, observer: Observer
) -> None:
    alice, bob = start("alice"), start("bob")
    drive(alice, observer)
    wait_owner(observer, "alice")
    bob.wait(lambda: "alice has control" in bob.text, 10.0)
    bob.type("t")
    bob.wait(lambda: "you ask alice" in bob.text, 10.0)
    alice.wait(lambda: "bob ASKS FOR CONTROL" in alice.text, 10.0)
    assert "Y grants O denies" in alice.text
    drive(alice, observer)
    alice.type("wy")
    wait_owner(observer, "bob")
    expect_stop(observer)
    alice.hold("w", HELD_S)
    assert observer.truth.commanded_linear == 0.0
    drive(bob, observer)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_console_of_the_owner_is_gone_and_the_other_one_takes_over_a_robot_at_rest(
    start: Start, observer: Observer, number: signal.Signals
) -> None:
    alice, bob = start("alice"), start("bob")
    drive(alice, observer)
    wait_owner(observer, "alice")
    alice.process.send_signal(number)
    expect_stop(observer)
    wait_owner(observer, "")
    bob.wait(lambda: "nobody has control" in bob.text, 10.0)
    drive(bob, observer)
    wait_owner(observer, "bob")
