"""A mirror of a fleet's robots: what local clients see and send, over a line in this process."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import logging
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hub.doors.mirror import documents
from hub.doors.mirror.mirror import MOST_ROBOTS, Mirror
from hub.doors.mirror.robot_line import RobotLine
from hub.errors import NoHandlerError
from hub.gcm.catalog import MESSAGES
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.gcm.pad import PAD_CONSOLE, PAD_STATE, PadConsole, PadState
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, ImageRequest
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.roles import Principal, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.ipc.wire import frames
from hub.ipc.wire.control import Define
from hub.ipc.wire.definition_listing import to_listing
from hub.plain_text import plain
from hub.zenoh.attachment import CLOCK, Attachment, unpack
from tests.support.memory_fleet import MemoryFleet
from tests.support.waiting import until

AHEAD_S = 5000.0
"""The robot's clock is so far ahead of this machine's [s]."""


class FakeRobot:
    """A robot's gateway, as its keys show it."""

    def __init__(self, fleet: MemoryFleet) -> None:
        self.fleet, self.count = fleet, 0
        start = "rune/v1/rover/"
        fleet.answers |= {
            start + "clock": lambda *_: (CLOCK.pack(self.now_ns()), None) if self.awake else None,
            start + "definitions": lambda *_: (definitions(), None),
            start + "operators": lambda *_: (json.dumps(self.numbers).encode(), None),
        }
        self.awake = True
        self.numbers: dict[str, int] = {}

    def now_ns(self) -> int:
        return time.monotonic_ns() + round(AHEAD_S * 1e9)

    def says(
        self, definition: MessageDefinition, value: object, age_s: float = 0.0, room: str = ""
    ) -> None:
        self.count += 1
        header = Attachment(
            publisher=77,
            fingerprint=definition.fingerprint,
            sequence=self.count,
            stamp_ns=self.now_ns() - round(age_s * 1e9),
        )
        payload = b"".join(map(bytes, definition.encode(value)))
        key = f"rune/v1/rover/{room or definition.plane.value}/{definition.name}"
        self.fleet.give(key, payload, header.pack())


def definitions() -> bytes:
    keys = ("name", "format", "fields", "keep", "plane")
    said = [{key: getattr(to_listing(each), key) for key in keys} for each in MESSAGES]
    return json.dumps(said).encode()


class Bench:
    def __init__(self, folder: Path) -> None:
        self.loop = Loop()
        self.fleet = MemoryFleet(self.loop)
        self.robot = FakeRobot(self.fleet)
        self.events: list[dict[str, object]] = []
        self.mirror = Mirror(
            self.fleet,
            "rune",
            Principal(name="ann", role=Role.OPERATE),
            robots=(),
            folder=folder,
            loop=self.loop,
            faults=FaultCounter(logging.getLogger(), time.monotonic),
            report=self.events.append,
        )
        self.clients: list[Client] = []

    def until(self, condition, why: str = "") -> None:
        until(condition, 10.0, why or "it did not happen", meanwhile=lambda: self.loop.listen(0.0))

    def open(self) -> str:
        self.fleet.come("rune/v1/rover/alive")
        self.until(lambda: self.events)
        assert self.events[0]["event"] == "robot"
        return str(self.events[0]["endpoint"])

    def client(self, endpoint: str, name: str = "console") -> Client:
        made = Client(name, endpoint, loop=self.loop, near=False)
        self.clients.append(made)
        self.until(lambda: made.connected)
        return made

    def close(self) -> None:
        for client in self.clients:
            client.close()
        self.mirror.close()
        self.loop.close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.close()


def test_what_local_clients_subscribe_to_is_subscribed_at_the_robot_meanwhile(
    bench: Bench,
) -> None:
    client = bench.client(bench.open())
    key = f"rune/v1/rover/state/{CONTROL_STATE.name}"
    assert key not in bench.fleet.patterns
    heard = []
    client.subscribe(CONTROL_STATE, lambda value, info: heard.append((value, info)))
    bench.until(lambda: key in bench.fleet.patterns)
    bench.robot.says(CONTROL_STATE, ControlState(operator="bob", owner=9), age_s=0.25)
    bench.until(lambda: heard)
    value, info = heard[0]
    assert (value.operator, value.owner) == ("bob", 9)
    assert (info.publisher, info.sequence) == (77, 1)
    assert 0.24 < info.age < 0.75
    client.unsubscribe(CONTROL_STATE)
    bench.until(lambda: key not in bench.fleet.patterns)


def test_commands_of_each_client_go_out_in_its_session_on_the_robots_clock(bench: Bench) -> None:
    endpoint = bench.open()
    one, other = bench.client(endpoint, "one"), bench.client(endpoint, "other")
    bench.until(lambda: len(bench.fleet.tokens) == 2)
    sessions = {int(token.rpartition("/")[2]) for token in bench.fleet.tokens}
    assert all(t.startswith("rune/v1/rover/operator/operate:ann/") for t in bench.fleet.tokens)
    for client in (one, other):
        client.publish(VELOCITY_COMMAND, TwistStamped())
    bench.until(lambda: len(bench.fleet.puts) == 2)
    headers = [unpack(attachment) for _, _, attachment in bench.fleet.puts]
    assert {header.publisher for header in headers} == sessions
    for key, _, _ in bench.fleet.puts:
        assert key == f"rune/v1/rover/command/operate:ann/{VELOCITY_COMMAND.name}"
    assert all(0 <= header.age(bench.robot.now_ns()) < 1.0 for header in headers)
    one.close()
    bench.clients.remove(one)
    bench.until(lambda: len(bench.fleet.tokens) == 1, "the session of a client ends with it")


def test_a_client_reads_its_own_number_as_the_owner(bench: Bench) -> None:
    client = bench.client(bench.open())
    bench.until(lambda: bench.fleet.tokens)
    session = bench.fleet.tokens[0].split("/", 4)[4]
    bench.robot.numbers = {session: 4242}
    owners = []
    client.subscribe(CONTROL_STATE, lambda value, _: owners.append(value.owner))
    key = f"rune/v1/rover/state/{CONTROL_STATE.name}"
    bench.until(lambda: key in bench.fleet.patterns)
    bench.until(lambda: "rune/v1/rover/operators" in bench.fleet.patterns)
    bench.fleet.give("rune/v1/rover/operators", json.dumps({session: 4242}).encode())
    bench.robot.says(CONTROL_STATE, ControlState(owner=4242))
    bench.until(lambda: owners)
    bench.robot.says(CONTROL_STATE, ControlState(owner=5))
    bench.until(lambda: 5 in owners)
    assert owners == [client.number, 5]


def test_queries_and_last_values_go_to_the_robot(bench: Bench) -> None:
    asked = []

    def answer(key: str, payload: bytes, attachment: bytes) -> tuple[bytes, bytes]:
        asked.append((key.rpartition("/")[2], payload, attachment))
        header = Attachment(
            publisher=78,
            fingerprint=CONTROL_STATE.fingerprint,
            sequence=9,
            stamp_ns=bench.robot.now_ns() - 10**8,
            name=CONTROL_STATE.name,
        )
        return b"".join(map(bytes, CONTROL_STATE.encode(ControlState(operator="x")))), header.pack()

    bench.fleet.answers |= {"rune/v1/rover/ask/operate:ann/": answer, "rune/v1/rover/last/": answer}
    client = bench.client(bench.open())
    ends: list[object] = []
    taken = lambda value, info: ends.append((value.operator, info.publisher, info.age))  # noqa: E731
    client.query_notify(
        IMAGE_REQUEST,
        ImageRequest(width_px=2),
        CONTROL_STATE,
        timeout=5.0,
        answered=taken,
        failed=ends.append,
    )
    client.last_notify(CONTROL_STATE, timeout=5.0, answered=taken, failed=ends.append)
    bench.until(lambda: len(ends) == 2)
    (name, payload, attachment), (last, *_) = sorted(asked, key=lambda each: -len(each[1]))
    assert (name, last) == (IMAGE_REQUEST.name, CONTROL_STATE.name)
    assert IMAGE_REQUEST.decode(payload).width_px == 2
    assert unpack(attachment).publisher == int(bench.fleet.tokens[0].rpartition("/")[2])
    for operator, publisher, age in ends:
        assert (operator, publisher) == ("x", 78)
        assert 0.09 < age < 1.0
    del bench.fleet.answers["rune/v1/rover/ask/operate:ann/"]
    client.query_notify(
        IMAGE_REQUEST, ImageRequest(), IMAGE, timeout=5.0, answered=taken, failed=ends.append
    )
    bench.until(lambda: len(ends) == 3)
    assert isinstance(ends[2], NoHandlerError)


def test_a_robot_that_does_not_answer_is_lost_and_comes_back_at_its_place(bench: Bench) -> None:
    endpoint = bench.open()
    client = bench.client(endpoint)
    bench.robot.awake = False
    bench.until(lambda: not client.connected)
    assert bench.events[-1] == {"event": "gone", "robot": "rover", "why": "it does not answer"}
    assert not bench.fleet.tokens
    bench.robot.awake = True
    bench.until(lambda: client.connected)
    assert bench.events[-1] == {"event": "robot", "robot": "rover", "endpoint": endpoint}


def test_late_states_come_at_the_low_rate_without_lost_numbers(bench: Bench) -> None:
    client = bench.client(bench.open())
    heard: list[str] = []
    client.subscribe(CONTROL_STATE, lambda value, _: heard.append(value.operator))
    full, thin = (f"rune/v1/rover/{each}/{CONTROL_STATE.name}" for each in ("state", "thin"))
    bench.until(lambda: full in bench.fleet.patterns)

    def late() -> bool:
        bench.robot.says(CONTROL_STATE, ControlState(operator="late"), age_s=3.0)
        return thin in bench.fleet.patterns

    bench.until(late, "the low rate is not chosen")
    assert full not in bench.fleet.patterns
    assert {"event": "rate", "robot": "rover", "thin": True} in bench.events
    bench.until(lambda: "late" in heard)
    for number in range(3):
        bench.robot.count += 10
        bench.robot.says(CONTROL_STATE, ControlState(operator=f"thin {number}"), room="thin")
    bench.until(lambda: "thin 2" in heard)
    assert client.lost == 0
    client.unsubscribe(CONTROL_STATE)
    bench.until(lambda: thin not in bench.fleet.patterns)


def test_gamepads_at_the_robots_hub_come_to_consoles_and_never_go_back(bench: Bench) -> None:
    client = bench.client(bench.open())
    pads: list[tuple[int, int]] = []
    client.subscribe(PAD_STATE, lambda state, info: pads.append((info.publisher, state.session)))
    bench.until(lambda: f"rune/v1/rover/state/{PAD_STATE.name}" in bench.fleet.patterns)
    bench.robot.says(PAD_STATE, PadState(session=5), age_s=2.0, room="state")  # too old
    bench.robot.says(PAD_STATE, PadState(session=6), room="state")
    bench.until(lambda: pads)
    assert pads == [(77, 6)], "under the number that it has at the robot's hub"
    # What a console says of the pads that it uses goes to the robot's hub, and names that number.
    taken = PadConsole(operator="ann", taken=np.array([77], np.uint32))
    client.define(PAD_CONSOLE)
    bench.until(lambda: client.publish(PAD_CONSOLE, taken) or bench.fleet.puts)
    assert {key.rpartition("/")[2] for key, *_ in bench.fleet.puts} == {PAD_CONSOLE.name}
    assert [*PAD_CONSOLE.decode(bench.fleet.puts[0][1]).taken] == [77]


def test_refusals_of_the_robot_are_events_in_words_a_few_at_once(bench: Bench) -> None:
    bench.open()
    key = "rune/v1/rover/refusal/operate:ann"
    bench.fleet.give(key, b"too old \x1b[2J\xff")
    assert bench.events[1:] == [
        {"event": "refused", "robot": "rover", "why": plain("too old \x1b[2J\ufffd")}
    ]
    for _ in range(1000):
        bench.fleet.give(key, b"a" * 100_000)
    assert len(bench.events) < 20
    assert max(len(str(event.get("why", ""))) for event in bench.events) == 500


def test_hostile_bytes_harm_nobody(bench: Bench) -> None:
    client = bench.client(bench.open())
    heard: list[str] = []
    client.subscribe(CONTROL_STATE, lambda value, _: heard.append(value.operator))
    key = f"rune/v1/rover/state/{CONTROL_STATE.name}"
    bench.until(lambda: key in bench.fleet.patterns)
    good = Attachment(publisher=1, fingerprint=CONTROL_STATE.fingerprint, sequence=1, stamp_ns=0)
    far = dataclasses.replace(good, stamp_ns=-(1 << 63))
    for attachment in (None, b"", b"\xff" * 500, good.pack()[:-1], far.pack()):
        bench.fleet.give(key, b"\xff" * 40, attachment)
    bench.fleet.give(key, bytes(5 << 20), good.pack())
    for name in ("definitions", "operators"):
        for payload in (b"", b"{", b"[" * 100_000, b'[{"name": 3}]', b'{"a": [], "-1": 2}', b"7"):
            bench.fleet.give(f"rune/v1/rover/{name}", payload)
    for bad in ("rune/v1//alive", "rune/v1/a b/alive", "x", "rune/v1/../alive"):
        bench.fleet.come(bad)
    bench.robot.says(CONTROL_STATE, ControlState(operator="last"))
    bench.until(lambda: heard)
    assert heard == ["last"]


def test_a_flood_of_wrong_documents_fills_no_log(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.open()
    for number in range(1000):
        for name in ("definitions", "operators"):
            bench.fleet.give(f"rune/v1/rover/{name}", b"[%d" % number)
    bench.until(lambda: caplog.records)
    assert len(caplog.records) == 1


def test_of_many_documents_the_newest_is_read(bench: Bench) -> None:
    client = bench.client(bench.open())
    bench.until(lambda: "rune/v1/rover/operators" in bench.fleet.patterns)
    session = bench.fleet.tokens[0].split("/", 4)[4]
    bench.robot.numbers = {session: 1000}
    for number in range(1, 1001):
        bench.fleet.give("rune/v1/rover/operators", json.dumps({session: number}).encode())
    owners: list[int] = []
    client.subscribe(CONTROL_STATE, lambda value, _: owners.append(value.owner))

    def own() -> bool:
        bench.robot.says(CONTROL_STATE, ControlState(owner=1000))
        return client.number in owners

    bench.until(own)


def test_messages_that_are_not_of_gcm_are_defined_one_by_one_and_are_limited(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hub.doors.mirror.mirrored_robot.MOST_OTHERS", 3)
    made: list[str] = []

    def definition_of(listing: Define) -> MessageDefinition | None:
        made.append(listing.name)
        return documents.definition_of(listing)

    monkeypatch.setattr("hub.doors.mirror.mirrored_robot.definition_of", definition_of)
    client = bench.client(bench.open())
    known = json.loads(definitions())
    state = next(each for each in known if each["name"] == CONTROL_STATE.name)
    others = [{**state, "name": f"T_Other{number}"} for number in range(9)]
    bench.fleet.give("rune/v1/rover/definitions", json.dumps(others + known).encode())
    assert not made
    last = dataclasses.replace(CONTROL_STATE, name="T_Other2")
    client.subscribe(last, lambda *_: None)
    bench.until(lambda: any(key.endswith("/T_Other2") for key in bench.fleet.patterns))
    bench.fleet.give("rune/v1/rover/definitions", json.dumps(others).encode())
    bench.fleet.come("rune/v1/rover/alive", there=False)
    assert made == ["T_Other0", "T_Other1", "T_Other2"]


def test_robots_that_went_leave_room_for_others(bench: Bench) -> None:
    for number in range(2 * MOST_ROBOTS):
        for there in (True, False):
            bench.fleet.come(f"rune/v1/ghost{number}/alive", there=there)
    bench.open()


def test_commands_under_the_number_of_nobody_go_nowhere(bench: Bench) -> None:
    client = bench.client(bench.open())
    client.define(VELOCITY_COMMAND)
    bench.until(lambda: client.publish(VELOCITY_COMMAND, TwistStamped()) or bench.fleet.puts)
    before = list(bench.fleet.tokens)
    bench.fleet.puts.clear()
    payload = memoryview(b"".join(map(bytes, VELOCITY_COMMAND.encode(TwistStamped()))))
    frame = frames.Frame(
        name=VELOCITY_COMMAND.name, kind=frames.INLINE, publisher=4242, sequence=1,
        fingerprint=VELOCITY_COMMAND.fingerprint, stamp_ns=time.monotonic_ns(), payload=payload,
    )  # fmt: skip
    client.forward(VELOCITY_COMMAND, frame)
    client.publish(VELOCITY_COMMAND, TwistStamped.planar(0.1, 0.0))
    moved = b"".join(map(bytes, VELOCITY_COMMAND.encode(TwistStamped.planar(0.1, 0.0))))
    bench.until(lambda: moved in [each for _, each, _ in bench.fleet.puts])
    assert bench.fleet.tokens == before
    sessions = {str(unpack(header).publisher) for _, _, header in bench.fleet.puts}
    assert sessions == {before[0].rpartition("/")[2]}


@pytest.mark.parametrize("stamp_ns", [(1 << 63) - 1, -(1 << 63)])
def test_what_was_measured_in_another_age_is_refused_here(stamp_ns: int) -> None:
    with contextlib.closing(Loop()) as loop:
        fleet = MemoryFleet(loop)
        faults = FaultCounter(logging.getLogger(), time.monotonic)
        who = Principal(name="ann", role=Role.OPERATE)
        line = RobotLine(fleet, "rune", "rover", who, time.monotonic, faults)
        frame = frames.Frame(
            name=IMAGE_REQUEST.name, kind=frames.INLINE, publisher=1, sequence=1,
            fingerprint=IMAGE_REQUEST.fingerprint, stamp_ns=stamp_ns, payload=memoryview(b""),
        )  # fmt: skip
        failures: list[tuple[str, str]] = []
        line.query(
            IMAGE_REQUEST, frame, 7, timeout=1.0,
            answered=lambda _: None, failed=lambda *failure: failures.append(failure),
        )  # fmt: skip
        assert failures
        assert "no time" in failures[0][1]
        line.command(VELOCITY_COMMAND, 7, b"", stamp_ns * 1e-9)
        assert not fleet.puts
