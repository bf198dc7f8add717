"""A million wrong frames over right connections, to every socket of central and to a client."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import pytest
import zmq

from hub.ipc.wire import frames
from tests.misbehaving.bad_frames import good_frame
from tests.soak import vocabulary as v
from tests.soak.good_traffic import GROWTH_MB, GoodTraffic
from tests.soak.module_process import Row
from tests.soak.rig import PUBLISHER, SENT, SEQUENCE, Rig, Vitals
from tests.support.waiting import until

FRAMES = int(os.environ.get("RUNE_SOAK_FRAMES", "1000000"))
AT_MOST_S = float(os.environ.get("RUNE_SOAK_ATTACK_S", "180"))
RATE = 5600.0
"""Frames a second: what reaches a Python subscriber with a queue of 50 commands is less than that
queue takes, so that nothing good may be lost."""


def _attack_central(
    make_rig: Callable[..., Rig],
    tell: Callable[..., None],
    count: int,
    at_most_s: float,
    *,
    timed: bool,
) -> None:
    rig = make_rig(transport="ipc")
    traffic = GoodTraffic(rig, quiet_s=min(5.0, at_most_s / 5.0), timed=timed)
    paths = ",".join(rig.central.paths)
    rate = RATE if timed else RATE / 2
    numbers = (str(count), str(at_most_s), str(rate), "1")
    attacker = rig.other("tests.misbehaving.bad_frames", paths, "S_Event,S_Command", *numbers)
    until(lambda: attacker.process.poll() is not None, at_most_s + 60.0)
    sent = attacker.line()
    dropped = rig.dropped() if rig.central.process.poll() is None else {}
    bars = traffic.finish()
    bars["central counted what is malformed"] = dropped.get("malformed frame", 0) > 0
    tell(
        attack=sent,
        dropped=dropped,
        subscriber_dropped=rig.modules["subscriber"].summary["complaints"],
        **traffic.figures,
        bars=bars,
    )


def _attack_client(
    make_rig: Callable[..., Rig], tell: Callable[..., None], count: int, at_most_s: float
) -> None:
    rig = make_rig(transport="ipc")
    numbers = (str(count), str(at_most_s), str(RATE), "2")
    rogue = rig.other("tests.misbehaving.rogue_central", "S_Event,S_Command", *numbers)
    endpoint = rogue.line()["endpoint"]
    client = rig.module(
        "client", endpoint=endpoint, subscribe=["S_Event", "S_Command"], answer_s=0.0, ask_hz=20.0
    )
    until(lambda: len(client.rows(Row.CONNECTED)), 10.0)
    before = Vitals.of(client.pid)
    until(lambda: rogue.process.poll() is not None, at_most_s + 60.0)
    sent = rogue.line()
    alive = client.process.poll() is None
    after = Vitals.of(client.pid) if alive else before
    summary = client.finish() if alive else {"faults": "it died", "complaints": {}}
    tell(
        attack=sent,
        client_dropped=summary["complaints"],
        faults=summary["faults"],
        first_faults=summary.get("first faults"),
        client_mb=[before.memory_mb, after.memory_mb],
        descriptors=[before.descriptors, after.descriptors],
        log=client.log.read_text()[-300:],
        bars={
            "the client lives": alive,
            "it never raised anything": summary["faults"] == 0,
            "memory back": after.memory_mb - before.memory_mb <= GROWTH_MB,
            "descriptors back": after.descriptors <= before.descriptors + 2,
        },
    )


@pytest.mark.soak
@pytest.mark.timeout(400)
def test_million_bad_frames_to_central_and_through_it(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _attack_central(make_rig, tell, FRAMES, AT_MOST_S, timed=True)


@pytest.mark.soak
@pytest.mark.timeout(400)
def test_rogue_central_cannot_hurt_its_client(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _attack_client(make_rig, tell, FRAMES // 4, AT_MOST_S / 2)


@pytest.mark.soak
def test_five_thousand_bad_frames_to_a_client(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _attack_client(make_rig, tell, 5_000, 2.0)


@pytest.mark.soak
def test_ten_thousand_bad_frames_to_central(
    make_rig: Callable[..., Rig], tell: Callable[..., None]
) -> None:
    _attack_central(make_rig, tell, 10_000, 3.0, timed=False)


@pytest.mark.soak
@pytest.mark.parametrize("place", ["sequence", "stamp"])
def test_flipped_bit_in_a_header_does_not_silence_its_publisher(
    make_rig: Callable[..., Rig], tell: Callable[..., None], place: str
) -> None:
    """A copy of a good frame with one high bit flipped, once, under the publisher's own number."""
    rig = make_rig(transport="ipc")
    publisher = rig.module("publisher", publish=[("S_Command", 100.0, 20)])
    subscriber = rig.module("subscriber", subscribe=["S_Command"])
    rig.wait_flowing(subscriber, "S_Command")
    number = int(subscriber.received("S_Command")[-1, PUBLISHER])
    raw = bytearray(good_frame(v.COMMAND, int(subscriber.received("S_Command")[-1, SEQUENCE]) + 5))
    start = len(frames.prefix(v.COMMAND.name))
    raw[start + 4 : start + 8] = number.to_bytes(4, "little")
    # The sequence counts from 16 on, the stamp from 24 on; bit 46 is 20 hours of nanoseconds.
    raw[start + (16 if place == "sequence" else 24) + 5] ^= 0x40
    with zmq.Context() as context, context.socket(zmq.XPUB) as rogue:
        rogue.connect(f"ipc://{rig.central.paths[3]}")
        until(lambda: rogue.poll(0), 10.0)
        rogue.send(bytes(raw))
        sent_ns = time.monotonic_ns()
        enough = sent_ns + 2_000_000_000
        until(lambda: time.monotonic_ns() > enough, 10.0)
    rig.wait_drained(publisher, subscriber)
    complaints = subscriber.finish()["complaints"]
    rows = subscriber.received("S_Command")
    after = int((rows[:, SENT] > sent_ns + 100_000_000).sum())
    tell(
        commands_in_2_s=after,
        complaints=complaints,
        bars={"good commands go on": after > 150},
    )
