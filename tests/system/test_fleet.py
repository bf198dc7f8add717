"""Robots in a fleet: real hubs with their gateways, a real router, operators of the protocol."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hub.doors.fleet.gateway import FleetGateway
from hub.gcm import navigation
from hub.gcm.catalog import MESSAGES
from hub.gcm.control import CONTROL_STATE, ControlAction, ControlRequest
from hub.gcm.pad import PAD_STATE, PadState
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.robots.fleet_table import FleetTable
from hub.zenoh.attachment import Attachment, unpack
from hub.zenoh.fleet_keys import KeyKind
from hub.zenoh.fleet_session import FleetWay, open_fleet_session
from hub.zenoh.settings import RouterPlace, client_settings
from tests.support.ports import free_port
from tests.support.waiting import until
from tests.system.fleet_operator import FleetOperator
from tests.system.harness import HubProcess, Observer, in_soak

_STOPPED_S = 1.0
"""The house's 0.35 s, with room for a busy machine [s]."""


class RouterProcess:
    """`rune-hub fleet router`."""

    def __init__(self) -> None:
        self.place = RouterPlace(scheme="tcp", host="127.0.0.1", port=free_port())
        self.start()

    def start(self) -> None:
        command = [sys.executable, "-m", "hub", "fleet", "router", "--listen", str(self.place)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        assert str(self.place) in self.process.stdout.readline()

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


class Robots:
    """Robots of a fleet, and its router."""

    def __init__(self, folder: Path, *names: str) -> None:
        self.router = RouterProcess()
        self.hubs = {}
        for name in names:
            (folder / name).mkdir()
            tables = f'\n[fleet]\nrouter = "{self.router.place}"\nname = "{name}"\n'
            self.hubs[name] = HubProcess(
                folder / name, tables=tables, modules=("driver", "navigation")
            )

    def close(self) -> None:
        for hub in self.hubs.values():
            hub.close()
        self.router.kill()


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robots]:
    fleet = Robots(tmp_path_factory.mktemp("fleet"), "magellan", "pioneer")
    yield fleet
    fleet.close()


@pytest.fixture
def alice(robots: Robots) -> Iterator[FleetOperator]:
    operator = FleetOperator(robots.router.place, "magellan")
    operator.join()
    yield operator
    operator.close()


@pytest.fixture
def observer(robots: Robots) -> Iterator[Observer]:
    made = Observer(robots.hubs["magellan"].endpoint, navigation.GROUND_TRUTH, CONTROL_STATE)
    yield made
    made.close()


def _state(observer: Observer) -> Any:
    return observer.seen[CONTROL_STATE.name][-1][1]


def _drive(alice: FleetOperator, observer: Observer) -> None:
    try:
        alice.take_control()
    except RuntimeError as error:  # a router that went on sends queries to sessions that ended
        if error.args[0] != "QueryTimeoutError":
            raise
        alice.wait(lambda: alice.robots[alice.robot] and alice.known)
        alice.take_control()
    alice.drive_until(lambda: observer.client.listen(0.0) or observer.truth.linear > 0.2)


def _stands_soon(observer: Observer) -> float:
    began = time.monotonic()
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "the wheels are driven on")
    return time.monotonic() - began


# First, because the robots of the others would not be idle beside it.
@pytest.mark.parametrize("victims", [("gateway", "router"), *in_soak(("paused router",) * 3)])
def test_robot_stops_when_gateway_or_router_is_killed_and_is_there_again(
    tmp_path: Path, victims: tuple[str, ...]
) -> None:
    with contextlib.ExitStack() as stack:
        robots = stack.enter_context(contextlib.closing(Robots(tmp_path, "magellan")))
        hub = robots.hubs["magellan"]
        observer = Observer(hub.endpoint, navigation.GROUND_TRUTH, CONTROL_STATE)
        stack.callback(observer.close)
        alice = FleetOperator(robots.router.place, "magellan")
        stack.callback(alice.close)
        alice.join()
        for victim in victims:
            _drive(alice, observer)
            if victim == "router":
                robots.router.kill()
            elif victim == "paused router":
                robots.router.process.send_signal(signal.SIGSTOP)
            else:
                os.kill(hub.pids["fleet"], signal.SIGKILL)
            assert _stands_soon(observer) < _STOPPED_S
            alice.drive_until(lambda: not alice.robots["magellan"])  # into a line that is full
            if victim == "router":
                robots.router.start()
            elif victim == "paused router":
                robots.router.process.send_signal(signal.SIGCONT)
            alice.wait(lambda: alice.robots["magellan"], why=f"no robot after {victim}")
            alice.wait(lambda: alice.known, why=f"no session after {victim}")
            observer.wait(lambda: _state(observer).owner == 0, 5.0, "control is not free")
            again = observer.history[-1][0] + 1.0
            while observer.history[-1][0] < again:  # it drives from neutral only
                alice.drive(0.3)
                observer.client.listen(0.05)
                alice.loop.listen(0.0)
                assert observer.truth.commanded_linear == 0.0
        _drive(alice, observer)
        alice.stop()
        assert _stands_soon(observer) < _STOPPED_S


def test_operator_drives_by_a_client_of_its_own_and_sees_states_of_the_robot(
    alice: FleetOperator, observer: Observer
) -> None:
    alice.wait(lambda: set(alice.robots) == {"magellan", "pioneer"})
    came: list[tuple[str, float]] = []
    now = lambda: time.monotonic_ns() + alice.offset_ns  # noqa: E731
    for kind in (KeyKind.STATE, KeyKind.THIN):
        alice.line.subscribe(
            alice.key(kind, message=navigation.ROBOT_STATE.name),
            lambda key, _, header: came.append((key.split("/")[3], unpack(header).age(now()))),
        )
    _drive(alice, observer)
    alice.wait(lambda: {kind for kind, _ in came} == {"state", "thin"})
    assert min(age for _, age in came) < 0.5
    state = _state(observer)
    assert (state.owner, state.operator) == (
        alice.numbers[f"{alice.principal}/{alice.session}"],
        "alice",
    )
    assert state.owner_name.startswith("alice@fleet")
    alice.stop()
    assert _stands_soon(observer) < _STOPPED_S


def test_gamepad_at_the_robots_hub_reaches_consoles_of_the_fleet(
    robots: Robots, alice: FleetOperator
) -> None:
    came: list[int] = []
    key = alice.key(KeyKind.STATE, message=PAD_STATE.name)
    alice.line.subscribe(key, lambda _, said, __: came.append(PAD_STATE.decode(said).session))
    with contextlib.closing(Client("rune-pad", robots.hubs["magellan"].endpoint)) as pad:
        pad.wait_connected(10.0)

        def sent() -> bool:
            pad.publish(PAD_STATE, PadState(session=9))
            pad.listen(0.02)
            return bool(came)

        alice.wait(sent, why="no state of the gamepad")
    assert came[0] == 9


def test_operator_that_is_gone_leaves_a_robot_that_stands_and_is_free(
    alice: FleetOperator, observer: Observer
) -> None:
    _drive(alice, observer)
    alice.close()
    assert _stands_soon(observer) < _STOPPED_S
    observer.wait(lambda: _state(observer).owner == 0, 5.0, "control is not free")


def test_commands_that_are_old_repeated_or_not_allowed_do_nothing_and_the_operator_reads_why(
    robots: Robots, alice: FleetOperator, observer: Observer
) -> None:
    alice.take_control()
    alice.drive(0.0, age=5.0)
    alice.wait(lambda: any("s old and is not obeyed" in each for each in alice.refusals))
    wall = FleetOperator(robots.router.place, "magellan", name="wall", role=Role.OBSERVE)
    try:
        wall.join()
        wall.drive(0.3)
        wall.wait(lambda: any("needs a key made with --role operate" in w for w in wall.refusals))
        with pytest.raises(RuntimeError, match="NotAllowedError"):
            wall.request(ControlRequest(operator="wall"))
        _drive(alice, observer)
        wall.stop()
        assert _stands_soon(observer) < _STOPPED_S
    finally:
        wall.close()
    with pytest.raises(RuntimeError, match="--role supervise"):
        alice.request(ControlRequest(action=ControlAction.TAKE_OVER, operator="alice"))


def test_second_robot_of_a_name_stays_out_of_the_fleet_and_says_so(
    robots: Robots, caplog: pytest.LogCaptureFixture
) -> None:
    client = Client("second gateway", robots.hubs["pioneer"].endpoint)
    gateway = FleetGateway(client, "magellan", FleetTable(place=robots.router.place))
    try:
        until(
            lambda: "has the name magellan already" in caplog.text,
            20.0,
            meanwhile=lambda: client.listen(0.05),
        )
    finally:
        gateway.finish()
        client.close()


def test_last_value_and_definitions_come_end_to_end(alice: FleetOperator) -> None:
    answer, header = alice.ask(alice.key(KeyKind.LAST, message=CONTROL_STATE.name), b"", b"")
    assert unpack(header).name == CONTROL_STATE.name
    assert CONTROL_STATE.decode(answer).why
    listed, _ = alice.ask(alice.key(KeyKind.DEFINITIONS), b"", b"")
    assert b'"GCM_RobotState"' in listed
    with pytest.raises(RuntimeError, match="no module of magellan has defined X_Nothing"):
        alice.ask(alice.key(KeyKind.LAST, message="X_Nothing"), b"", b"")


def _rubbish(count: int) -> Iterator[tuple[str, bytes, bytes | None]]:
    """Keys, payloads and headers of a hostile program."""
    chance = random.Random(count)
    whos = ("operate:alice", "operate:mallory", "module:x", "observe:", "supervise:..", "x")
    names = (*(each.name for each in MESSAGES), "X_Nothing", "GCM-Stop")
    kinds = [kind.value for kind in KeyKind]
    numbers = [str(each) for each in (0, 1, 1000, 1001, 1 << 40)]
    for _ in range(count):
        parts = [chance.choice(kinds)]
        parts += chance.sample([chance.choice(whos), chance.choice(names), *numbers], 2)
        payload = chance.randbytes(chance.choice((0, 3, 40, 400)))
        header = chance.choice((None, chance.randbytes(7), chance.randbytes(32)))
        if chance.random() < 0.5:
            made = Attachment(
                publisher=int(chance.choice(numbers)) & 0xFFFF_FFFF,
                fingerprint=chance.choice(MESSAGES).fingerprint,
                sequence=chance.getrandbits(64),
                stamp_ns=chance.getrandbits(63) * chance.choice((1, -1)),
            )
            header = made.pack()
        robot = chance.choice(("magellan", "magellan", "nobody"))
        yield f"rune/v1/{robot}/{'/'.join(parts)}", payload, header


@pytest.mark.parametrize("count", [2000, *in_soak(100_000)])
def test_hostile_bytes_at_every_key_are_counted_and_change_nothing(
    robots: Robots, alice: FleetOperator, observer: Observer, count: int
) -> None:
    place, hub = robots.router.place, robots.hubs["magellan"]
    before = hub.log.stat().st_size
    mallory = open_fleet_session(place, client_settings(place))
    try:
        for number, (key, payload, header) in enumerate(_rubbish(count)):
            mallory.put(key, payload, header, FleetWay.BULK)
            if number % 20 == 0:
                mallory.query(
                    key,
                    payload,
                    header,
                    way=FleetWay.BULK,
                    timeout=0.2,
                    answered=lambda _: None,
                    failed=lambda *_: None,
                    ended=lambda: None,
                )
            if number % 200 == 0:
                mallory.declare_token(key)
    finally:
        mallory.close()
    _drive(alice, observer)
    alice.stop()
    assert _stands_soon(observer) < _STOPPED_S
    os.kill(hub.pids["fleet"], 0)  # it never ended: its number is that of the start
    assert hub.log.stat().st_size - before < 200_000, "each is said once a minute, not each time"
    assert "Traceback" not in hub.log.read_text()
