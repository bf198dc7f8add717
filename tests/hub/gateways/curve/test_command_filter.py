"""Which commands from other machines come in: every frame is judged by the key it came with."""

from __future__ import annotations

import logging
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import FrameError
from hub.gateways.accounts import STOPS_AT_ONCE, STOPS_PER_S, Accounts
from hub.gateways.curve.command_filter import CommandFilter
from hub.gcm import common, control, navigation
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import Stop
from hub.ipc.broker.peers import Peer
from hub.ipc.broker.quotas import QUOTAS
from hub.ipc.node.subscription import ReceivedFrame, Subscription
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames
from tests.support.cases import for_each

ALICE, BOB, EYE, FAR, DRIVES = 11, 12, 13, 14, 15
LOCAL_NUMBER = 20
BEARERS = {
    "alice": Principal.of("alice", Role.OPERATE, "its key"),
    "bob": Principal.of("bob", Role.SUPERVISE, "its key"),
    "eye": Principal.of("eye", Role.OBSERVE, "its key"),
    "far": Principal.of("far", Role.MODULE, "its key"),
    "alice anew": Principal.of("alice", Role.OPERATE, "another key"),
}


def peer(number: int, name: str, principal: Principal) -> Peer:
    return Peer(
        identity=b"%d" % number,
        descriptor=-1,
        name=name,
        pid=1,
        principal=principal,
        client=number,
        publisher=number,
        sends_under=number,
        last_message=0.0,
    )


PEERS = {
    ALICE: peer(ALICE, "console a", BEARERS["alice"]),
    BOB: peer(BOB, "console b", BEARERS["bob"]),
    EYE: peer(EYE, "wall", BEARERS["eye"]),
    FAR: peer(FAR, "pilot", BEARERS["far"]),
    DRIVES: peer(DRIVES, "navigation", BEARERS["far"]),
    LOCAL_NUMBER: peer(LOCAL_NUMBER, "navigation", LOCAL),
}


class Door:
    """The door of a central with these peers, and what it dropped."""

    def __init__(self) -> None:
        self.now = 0.0
        self.faults = FaultCounter(logging.getLogger(__name__), lambda: 0.0)
        known = set(BEARERS.values())
        self._door = CommandFilter(
            PEERS.get,
            known.__contains__,
            self.faults,
            lambda: self.now,
            accounts=Accounts(),
        )

    def admit(self, raw: bytes, who: str) -> bytes | None:
        return self._door.admit(raw, BEARERS[who].user_id if who in BEARERS else who)


def frame(definition: object, value: object, number: int, sequence: int = 1) -> bytes:
    return frames.pack(
        frames.prefix(definition.name, frames.FAR),  # type: ignore[attr-defined]
        publisher=number,
        fingerprint=definition.fingerprint,  # type: ignore[attr-defined]
        sequence=sequence,
        stamp_ns=5,
        payload=definition.encode(value),  # type: ignore[attr-defined]
    )


VELOCITY = navigation.VELOCITY_COMMAND, TwistStamped.planar(0.5, 0.0)
DRIVE = navigation.DRIVE_COMMAND, TwistStamped.planar(0.5, 0.0)
STOP_ALL = common.COMMON_COMMAND, common.CommonCommand(command=common.CommonCommandKind.STOP)
ALIVE = control.CONSOLE_HEARTBEAT, control.ConsoleHeartbeat(holds=1)
STOP = navigation.STOP, Stop(reason="help")


@for_each(
    ("what", "number", "who", "dropped"),
    [
        (VELOCITY, ALICE, "alice", ""),
        (VELOCITY, BOB, "bob", ""),
        (VELOCITY, FAR, "far", ""),
        (VELOCITY, EYE, "eye", "command not allowed"),
        (VELOCITY, BOB, "alice", "command not allowed"),
        (VELOCITY, LOCAL_NUMBER, "alice", "command not allowed"),
        (VELOCITY, 99, "alice", "command not allowed"),
        (VELOCITY, ALICE, "alice anew", "command not allowed"),
        (VELOCITY, LOCAL_NUMBER, "far", "command not allowed"),
        (ALIVE, BOB, "alice", "command not allowed"),
        (DRIVE, ALICE, "alice", "command not allowed"),
        (DRIVE, BOB, "bob", "command not allowed"),
        (DRIVE, FAR, "far", "command not allowed"),
        (DRIVE, DRIVES, "far", ""),
        (DRIVE, LOCAL_NUMBER, "far", "command not allowed"),
        (STOP_ALL, ALICE, "alice", "command not allowed"),
        (STOP_ALL, BOB, "bob", ""),
        (STOP, EYE, "eye", ""),
        (VELOCITY, ALICE, "operate", "command not allowed"),
        (VELOCITY, ALICE, "", "command not allowed"),
        (VELOCITY, ALICE, "operate:somebody else", "command not allowed"),
        (VELOCITY, ALICE, "module:alice", "command not allowed"),
        (VELOCITY, LOCAL_NUMBER, "module:nobody", "command not allowed"),
    ],
)
def test_a_command_comes_in_by_role_and_under_its_senders_number(
    what: tuple[object, object], number: int, who: str, dropped: str
) -> None:
    door, raw = Door(), frame(*what, number)
    assert door.admit(raw, who) == (None if dropped else raw)
    assert dict(door.faults.counts) == ({dropped: 1} if dropped else {})


@for_each("number", [ALICE, BOB, LOCAL_NUMBER, 99])
@for_each("who", BEARERS)
def test_a_stop_comes_in_from_everybody_under_nobody_elses_number(who: str, number: int) -> None:
    raw = frame(*STOP, number, sequence=1 << 40)
    admitted = Door().admit(raw, who)
    assert admitted is not None
    read = frames.unpack(admitted)
    own = number in PEERS and PEERS[number].principal is BEARERS[who]
    assert read.publisher == (number if own else 0)
    assert navigation.STOP.decode(read.payload) == Stop(reason="help")


@given(st.binary(max_size=80))
def test_a_stop_comes_in_whatever_stands_behind_its_name(rest: bytes) -> None:
    assert Door().admit(b"!GCM_Stop\0" + rest, "eye") is not None
    assert Door().admit(b"GCM_Stop\0" + rest, "alice") is not None


@for_each("topic", [frames.FAR, b""])
@for_each("kind", [*range(6), 7, 1000])
@for_each("filling", [0, 1])
def test_every_stop_that_comes_in_counts_and_none_under_a_forged_number(
    topic: bytes, kind: int, filling: int
) -> None:
    raw = bytearray(frame(*STOP, BOB))
    name = len(b"!GCM_Stop")
    start = len(frames.prefix("GCM_Stop", frames.FAR))
    struct.pack_into("<H", raw, start + 2, kind)
    raw[name + 1 : start] = bytes([filling]) * (start - name - 1)
    if not topic:
        raw[: name + 1] = b"GCM_Stop\0\0"
    admitted = Door().admit(bytes(raw), "eye")
    assert admitted is not None
    assert admitted.startswith(b"!GCM_Stop\0")  # a neighbour listens to no other topic at central
    subscription = Subscription(navigation.STOP)
    try:
        arrival: ReceivedFrame | None = subscription.read(admitted)
    except FrameError:
        arrival = subscription.unreadable()
    assert arrival is not None
    assert (arrival.publisher, arrival.kind) == (0, frames.INLINE)
    assert len(arrival.messages) == 1


def test_fault_of_ours_does_not_close_the_door() -> None:
    faults = FaultCounter(logging.getLogger(__name__), lambda: 0.0)

    def peer_of(number: int) -> Peer:
        raise RuntimeError(number)

    door = CommandFilter(peer_of, lambda _: True, faults, lambda: 0.0, accounts=Accounts())
    assert door.admit(frame(*VELOCITY, BOB), BEARERS["bob"].user_id) is None
    assert faults.counts == {"internal fault": 1}


@pytest.mark.parametrize("kind", [5, 7, 65535])
def test_frame_of_an_unknown_kind_is_no_place_in_a_ring(kind: int) -> None:
    raw = bytearray(frame(*VELOCITY, BOB))
    struct.pack_into("<H", raw, len(frames.prefix("GCM_Velocity_Command", frames.FAR)) + 2, kind)
    with pytest.raises(FrameError):
        Subscription(navigation.VELOCITY_COMMAND).read(bytes(raw))


@given(st.binary(max_size=200), st.sampled_from([*BEARERS, "", "x", "operate:"]))
def test_nonsense_is_dropped_and_counted(raw: bytes, who: str) -> None:
    door = Door()
    assert door.admit(raw, who) is None
    assert door.faults.counts.total() == 1


@given(st.data())
def test_a_damaged_header_lets_no_command_in_that_is_not_the_senders(data: st.DataObject) -> None:
    raw = bytearray(frame(*DRIVE, ALICE))
    start = len(frames.prefix("GCM_Drive_Command", frames.FAR))
    at = data.draw(st.integers(start, len(raw) - 1))
    raw[at] = data.draw(st.integers(0, 255))
    for who in ("alice", "bob", "eye"):
        assert Door().admit(bytes(raw), who) is None


@for_each("kind", [frames.BATCH, frames.IN_RING, frames.NO_RING, 9])
def test_no_command_is_a_batch_or_lies_in_a_ring(kind: int) -> None:
    raw = bytearray(frame(*VELOCITY, ALICE))
    struct.pack_into("<H", raw, len(frames.prefix("GCM_Velocity_Command", frames.FAR)) + 2, kind)
    door = Door()
    assert door.admit(bytes(raw), "alice") is None
    assert door.faults.counts["malformed command"] == 1


def test_flood_of_commands_is_cut_to_the_rate_of_its_key_and_stops_pass_beside_it() -> None:
    door = Door()
    velocity = frame(navigation.VELOCITY_COMMAND, TwistStamped.planar(0.1, 0.0), ALICE)
    most = QUOTAS[Role.OPERATE].commands_per_s
    assert sum(door.admit(velocity, "alice") is not None for _ in range(2000)) == most
    stop = frame(navigation.STOP, Stop(reason="now"), ALICE)
    assert door.admit(stop, "alice") == stop
    other = frame(navigation.VELOCITY_COMMAND, TwistStamped.planar(0.1, 0.0), BOB)
    assert door.admit(other, "bob") == other
    door.now += 0.1
    assert sum(door.admit(velocity, "alice") is not None for _ in range(2000)) == most * 0.1


def test_flood_of_stops_reaches_the_robot_as_often_as_it_matters() -> None:
    door = Door()
    stop = frame(navigation.STOP, Stop(reason="now"), EYE)
    assert sum(door.admit(stop, "eye") is not None for _ in range(2000)) == STOPS_AT_ONCE
    door.now += 1.0
    assert sum(door.admit(stop, "eye") is not None for _ in range(2000)) == STOPS_PER_S
    assert door.faults.counts["too many commands"] > 0
