"""Two consoles at one robot: it follows who has control, and everybody can stop it."""

from __future__ import annotations

import itertools
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Any

import pytest
import zmq

from hub.gcm import autonomy, autopilot, navigation
from hub.gcm.catalog import BY_NAME
from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import (
    CONSOLE_HEARTBEAT,
    CONTROL_REFUSAL,
    CONTROL_REQUEST,
    CONTROL_STATE,
    RESTRICTED,
    ConsoleHeartbeat,
    ControlAction,
    ControlRequest,
    ControlState,
)
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import GROUND_TRUTH, Task
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.wire import frames
from tests.support.raw_client import RawClient
from tests.support.waiting import until
from tests.system.harness import (
    STILL,
    ConsoleProcess,
    HubProcess,
    Observer,
    drive,
    expect_stop,
    in_soak,
)

HUB = {"modules": ("driver", "navigation", "vision", "mapping", "autonomy")}
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
    assert "P hands it over, B keeps it" in alice.text
    drive(alice, observer)
    alice.type("w")
    observer.wait(lambda: alice.pump(0.02) or observer.truth.commanded_linear > 0.0, 10.0)
    alice.type("p")
    wait_owner(observer, "bob")
    expect_stop(observer)
    alice.hold("w", HELD_S)
    assert observer.truth.commanded_linear == 0.0
    drive(bob, observer)


@pytest.mark.parametrize("number", [signal.SIGKILL, *in_soak(signal.SIGTERM, signal.SIGHUP)])
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


class Somebody:
    """A client that may have control; it says that it lives."""

    def __init__(self, name: str, hub: HubProcess, observer: Observer, stack: ExitStack) -> None:
        self.client = Client(name, hub.endpoint, loop=observer.client.loop)
        stack.enter_context(closing(self.client))
        self.client.wait_connected(5.0)
        holds = ConsoleHeartbeat(holds=1)
        self.client.every(0.2, lambda: self.client.publish(CONSOLE_HEARTBEAT, holds))

    def want(self, action: ControlAction) -> None:
        request = ControlRequest(action=action, operator=self.client.name)
        answer = self.client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0)
        assert answer.done, answer.text

    def send(self, definition: MessageDefinition[Any], value: Any) -> None:
        self.client.define(definition)
        self.client.wait_defined(5.0)
        self.client.publish(definition, value)
        self.client.wait_published(5.0)


def command_of(definition: MessageDefinition[Any]) -> Any:
    """A command that moves something."""
    if definition is navigation.VELOCITY_COMMAND:
        return TwistStamped.planar(0.3, 0.0)
    if definition is navigation.LANDMARK_CORRECTION:
        return navigation.LandmarkCorrection(x=1.0, y=0.0, seen_x=1.0, seen_y=0.0)
    return definition.type()


def test_nobody_drives_under_a_number_that_is_not_its_own(
    hub: HubProcess, observer: Observer, stack: ExitStack
) -> None:
    """While nobody has control; with the ticket for its number the same client drives."""
    context = zmq.Context[zmq.Socket[bytes]]()
    stack.callback(context.term)
    client = RawClient(context, hub.endpoint, "raw")
    stack.callback(client.close)
    command = navigation.VELOCITY_COMMAND
    sequence = itertools.count(1)

    def send(ticket: str) -> Callable[[float], None]:
        socket = client.connect(zmq.XPUB, client.input_of(Plane.COMMAND), ticket)
        topic = frames.topic(command.name, frames.FAR)
        until(lambda: socket.poll(100) and topic in socket.recv(), 10.0)
        return lambda speed: socket.send(
            frames.pack(
                frames.prefix(command.name, frames.FAR),
                publisher=client.number,
                fingerprint=command.fingerprint,
                sequence=next(sequence),
                stamp_ns=time.monotonic_ns(),
                payload=command.encode(TwistStamped.planar(speed, 0.0)),
            )
        )

    wait_owner(observer, "")
    forge = send("")
    observer.wait(lambda: forge(0.3) or "forged number" in hub.log.read_text(), 10.0, "not refused")
    assert not any(truth.commanded_linear for _, truth in observer.seen[GROUND_TRUTH.name])
    drive = send(client.ticket)
    # Neutral comes first, and by itself: of two commands together the newer one counts.
    speed = itertools.chain(itertools.repeat(0.0, 10), itertools.repeat(0.3))
    observer.wait(
        lambda: drive(next(speed)) or observer.truth.commanded_linear > 0.0, 10.0, "it stands"
    )


def test_modules_refuse_all_that_only_the_owner_may_send(
    hub: HubProcess, observer: Observer, stack: ExitStack
) -> None:
    alice = Somebody("alice", hub, observer, stack)
    alice.want(ControlAction.TAKE)
    wait_owner(observer, "alice")
    refused: set[str] = set()
    observer.client.subscribe(CONTROL_REFUSAL, lambda refusal, _: refused.add(refusal.message))
    observer.client.wait_subscribed(5.0)
    # This robot has no autopilot, so no module of it takes frames for one.
    taken = RESTRICTED - {autopilot.MAVLINK_REQUEST.name}
    for number, name in enumerate(sorted(taken)):
        other = Somebody(f"other-{number}", hub, observer, stack)  # each is told once a second
        other.send(BY_NAME[name], command_of(BY_NAME[name]))
    observer.wait(lambda: refused == taken, 10.0, lambda: f"only {refused}")


def test_what_the_robot_does_by_itself_ends_when_control_is_handed_over(
    hub: HubProcess, observer: Observer, stack: ExitStack
) -> None:
    alice, bob = (Somebody(name, hub, observer, stack) for name in ("alice", "bob"))
    statuses: list[navigation.NavigationStatus] = []
    observer.client.subscribe(
        navigation.NAVIGATION_STATUS, lambda status, _: statuses.append(status)
    )
    alice.want(ControlAction.TAKE)
    wait_owner(observer, "alice")
    alice.send(navigation.TURN_COMMAND, navigation.TurnCommand(angle=6.0))
    observer.wait(lambda: statuses and statuses[-1].task is Task.TURNING, 10.0)
    observer.wait(lambda: control(observer).commander_name == "alice", 10.0)
    bob.want(ControlAction.ASK)
    alice.want(ControlAction.GRANT)
    observer.wait(lambda: statuses[-1].task is Task.CANCELLED, 10.0)
    assert statuses[-1].why == "bob has control now"
    observer.wait(lambda: abs(observer.truth.angular) < STILL, 5.0)


def test_autonomy_drives_for_the_owner_and_holds_when_control_is_handed_over(
    hub: HubProcess, observer: Observer, stack: ExitStack
) -> None:
    alice, bob = (Somebody(name, hub, observer, stack) for name in ("alice", "bob"))
    states: list[autonomy.AutonomyState] = []
    observer.client.subscribe(autonomy.AUTONOMY_STATE, lambda state, _: states.append(state))
    alice.want(ControlAction.TAKE)
    wait_owner(observer, "alice")
    explore = autonomy.AutonomyCommand(behaviour=autonomy.Behaviour.EXPLORE)
    alice.send(autonomy.AUTONOMY_COMMAND, explore)
    observer.wait(lambda: control(observer).commander is autonomy.DrivingMode.AUTONOMY, 20.0)
    bob.want(ControlAction.ASK)
    alice.want(ControlAction.GRANT)
    observer.wait(lambda: states[-1].behaviour is autonomy.Behaviour.HOLD, 10.0)
    assert states[-1].why == "bob has control now"
    assert states[-1].phase is autonomy.Phase.TAKEN_OVER
    observer.wait(lambda: abs(observer.truth.linear) < STILL, 5.0)
    observer.wait(lambda: control(observer).commander is autonomy.DrivingMode.NOBODY, 5.0)
