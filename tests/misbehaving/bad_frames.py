"""Wrong frames over right connections to every socket of a central.

python -m tests.misbehaving.bad_frames PATHS TOPICS COUNT SECONDS RATE SEED: the five sockets of
central (control, state in, state out, command in, command out), names of messages that somebody
subscribes, how many frames in all, and how many a second. It writes what it sent as a JSON line.
"""

from __future__ import annotations

import collections
import json
import os
import random
import sys
import time
from collections.abc import Callable

import zmq

from hub.ipc.definition import MessageDefinition
from hub.ipc.wire import control, frames
from hub.ipc.wire.control_codec import pack
from hub.ipc.wire.definition_listing import to_listing
from tests.soak import vocabulary as v

_BURST_S = 0.005
_DEALERS = 4
_OWN = MessageDefinition(name="S_Rogue", format=v.ASK.format, type=v.Sample)
"""What the attacker answers. Whoever says that it answers the good queries is asked some of them,
as central trusts the machine's own programs; wrong frames are meant to be wrong, not a lie."""


def good_frame(definition: MessageDefinition[v.Sample], number: int) -> bytes:
    """A whole frame of a publisher that central never had, as one that is nobody's neighbour."""
    return frames.pack(
        frames.prefix(definition.name, frames.FAR),
        publisher=7,
        fingerprint=definition.fingerprint,
        sequence=number + 1,
        stamp_ns=time.monotonic_ns(),
        payload=definition.encode(v.sample(number, time.monotonic_ns(), number % 300)),
    )


def control_frames() -> list[bytes]:
    """One of each kind that a client may say, and some that it may not."""
    said = [
        control.Hello(name="rubbish", pid=1),
        to_listing(v.EVENT),
        to_listing(_OWN),
        control.Handle(name=_OWN.name),
        control.Advertise(name=_OWN.name),
        control.Subscribe(name=v.EVENT.name, token="", inbox="ipc://@rune-rubbish"),
        control.Subscriber(name="", subscriber=1),
        control.Subscriber(
            name=v.EVENT.name, subscriber=1, inbox="ipc://@rune-rubbish", token="1.1"
        ),
        control.Report(
            received=(control.Received(name="x", received=1, lost=1, expired=1, oldest_s=1.0),),
            published=(control.Published(name="x", messages=1, bytes=1, over_s=1.0, silent_s=0.0),),
        ),
        control.Query(number=1, name=_OWN.name, timeout_s=1.0),
        control.Response(number=1),
        control.Failure(number=1, error="QueryError", text="no"),
        control.Ping(epoch=1),
        control.Pong(epoch=1, sent=0.0, hub_time=0.0),
        control.Defined(name=v.EVENT.name),
        control.Refused(subject="x", error="NameTakenError", text="no"),
    ]
    return [pack(message) for message in said]


def spoil(raw: bytes, chance: random.Random, *, keep: int = 0) -> bytes:
    """Cut, flip bits, insert, delete or replace; the first `keep` bytes stay."""
    how = chance.randrange(5)
    if how == 0:
        return raw[: chance.randint(keep, len(raw))]
    if how == 1:
        return raw[:keep] + chance.randbytes(chance.randint(0, 300))
    spoilt = bytearray(raw)
    for _ in range(chance.randint(1, 6)):
        place = chance.randint(keep, len(spoilt) - 1) if len(spoilt) > keep else keep
        if how == 2 and place < len(spoilt):
            spoilt[place] ^= 1 << chance.randrange(8)
        elif how == 3:
            spoilt[place:place] = chance.randbytes(chance.randint(1, 9))
        else:
            del spoilt[place : place + chance.randint(1, 9)]
    return bytes(spoilt)


class Attack:
    """Sockets to central's five, and what goes into each."""

    def __init__(self, paths: list[str], topics: list[str], seed: int) -> None:
        self._chance = random.Random(seed)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._controls = control_frames()
        self._definitions = [v.BROADCASTS[name] for name in topics]
        self.sent: collections.Counter[str] = collections.Counter()
        self._dealers = [self._socket(zmq.DEALER, paths[0]) for _ in range(_DEALERS)]
        self._publishers = {
            "state": self._socket(zmq.PUB, paths[1]),
            "command": self._socket(zmq.PUB, paths[3]),
        }
        self._subscribers = [self._socket(zmq.XSUB, path) for path in (paths[2], paths[4])]
        self._ways: list[Callable[[int], None]] = [
            self._to_control,
            self._to_publish,
            self._to_publish,
            self._to_subscribe,
        ]

    def one(self, number: int) -> None:
        """Send one bad frame."""
        self._ways[number % len(self._ways)](number)

    def close(self) -> None:
        """Leave."""
        self._context.destroy(linger=500)

    def _socket(self, kind: int, path: str) -> zmq.Socket[bytes]:
        made = self._context.socket(kind)
        made.rcvhwm = 10
        made.connect(f"ipc://{path}")
        return made

    def _to_control(self, number: int) -> None:
        chance = self._chance
        raw = spoil(chance.choice(self._controls), chance, keep=chance.choice([0, 0, 8]))
        parts = [raw] if chance.random() < 0.8 else [raw, chance.randbytes(chance.randint(0, 99))]
        dealer = self._dealers[number // 4 % _DEALERS]
        try:
            dealer.send_multipart(parts, zmq.NOBLOCK)
            self.sent["control"] += 1
        except zmq.Again:
            self.sent["control refused"] += 1
        while dealer.poll(0):
            dealer.recv_multipart()

    def _to_publish(self, number: int) -> None:
        chance = self._chance
        definition = chance.choice(self._definitions)
        # With the name whole most of the time, as without a subscriber it would not be sent.
        keep = len(definition.name) + 2 if chance.random() < 0.9 else 0
        raw = spoil(good_frame(definition, number), chance, keep=keep)
        plane = definition.plane.value
        self._publishers[plane].send(raw)
        self.sent[f"{plane} in"] += 1

    def _to_subscribe(self, number: int) -> None:
        chance = self._chance
        subscriber = self._subscribers[number // 4 % 2]
        kind = chance.choice([b"\0", b"\0", b"\1", b"", b"\2", b"\xff"])
        # Few enough subscriptions that this is no flood of them.
        subscriber.send(kind + chance.randbytes(chance.randint(0, 1 if kind == b"\1" else 40)))
        self.sent["state and command out"] += 1


def main() -> None:
    os.nice(10)  # the attack is on central, not on the processor
    paths, topics, count, seconds, rate, seed = sys.argv[1:7]
    attack = Attack(paths.split(","), topics.split(","), int(seed))
    started = time.monotonic()
    done = 0
    while done < int(count) and time.monotonic() - started < float(seconds):
        due = min(int(count), int((time.monotonic() - started) * float(rate)))
        while done < due:
            attack.one(done)
            done += 1
        time.sleep(_BURST_S)
    attack.close()
    took = round(time.monotonic() - started, 1)
    sys.stdout.write(json.dumps({"done": done, "took_s": took, **attack.sent}) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
