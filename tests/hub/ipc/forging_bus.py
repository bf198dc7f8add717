"""A hub, a receiver of commands, and a client that sends them under numbers of others."""

from __future__ import annotations

import time
from contextlib import ExitStack, closing
from pathlib import Path

import zmq

from hub.gcm.navigation import STOP, Stop
from hub.ipc.broker.central import Central
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.transport.clock_sync import this_neighbourhood
from hub.ipc.wire import control, frames
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.raw_client import RawClient
from tests.support.waiting import until

TAKEN, FORGED = 1, 2


class Bus:
    """A central, a receiver of commands, the owner of a number, and a client that forges."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.central = stack.enter_context(closing(Central([f"ipc://{folder}/central"])))
        self.receiver = self._peer("receiver", stack)
        self.received = self.receiver.collect(v.EVENT)
        self.commands = self.receiver.collect(v.COMMAND)
        self.states = self.receiver.collect(v.LOG)
        self.stops = self.receiver.collect(STOP)
        self.receiver.stands()
        self.owner = self._peer("owner", stack)
        self.owner.open(v.EVENT)
        until(lambda: self.received, 10.0)
        context = zmq.Context[zmq.Socket[bytes]]()
        stack.callback(context.term)
        endpoint, here = self.central.endpoints[0], this_neighbourhood()
        self.forger = RawClient(context, endpoint, "forger", neighbourhood=here)
        stack.callback(self.forger.close)
        self.forger.say(control.Advertise(name=v.EVENT.name))
        self.inbox: control.Subscriber = self.forger.heard(control.Subscriber)

    def _peer(self, name: str, stack: ExitStack) -> Peer:
        made = Peer(name, self.central.endpoints[0])
        stack.callback(made.close)
        return made.connect()

    def to_receiver(self, shown: str, plane: Plane = Plane.COMMAND) -> zmq.Socket[bytes]:
        """Straight to the inbox of the receiver."""
        inboxes = self.receiver.client.session.subscriptions.inboxes
        return self.forger.connect(zmq.PUSH, inboxes[plane].address, shown)

    def to_central(self, shown: str, kind: bytes = frames.FAR) -> zmq.Socket[bytes]:
        """To central, once the subscription of the receiver is there."""
        made = self.forger.connect(zmq.XPUB, self.forger.input_of(Plane.COMMAND), shown)
        wanted = {b"\1" + frames.topic(each.name, kind) for each in (v.EVENT, v.COMMAND, STOP)}
        until(
            lambda: not wanted,
            10.0,
            meanwhile=lambda: made.poll(50) and wanted.discard(made.recv()),
        )
        return made

    def refused(self) -> int:
        """By the receiver and by central."""
        faults = (self.receiver.client.faults, self.central.faults)
        return sum(each.counts["forged number"] for each in faults)

    def values(self) -> list[int]:
        both = (*self.received, *self.commands)
        return [value.value for value, _ in both if value.value >= 0]


def event(
    number: int,
    value: int,
    sequence: int = 1,
    kind: bytes = b"",
    definition: MessageDefinition[Number] = v.EVENT,
) -> bytes:
    return frames.pack(
        frames.prefix(definition.name, kind),
        publisher=number,
        fingerprint=definition.fingerprint,
        sequence=sequence,
        stamp_ns=time.monotonic_ns(),
        payload=definition.encode(Number(value=value)),
    )


def stop(number: int, kind: bytes = b"") -> bytes:
    return frames.pack(
        frames.prefix(STOP.name, kind),
        publisher=number,
        fingerprint=STOP.fingerprint,
        sequence=1,
        stamp_ns=0,
        payload=STOP.encode(Stop()),
    )
