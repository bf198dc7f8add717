"""A central that welcomes a client and then sends it rubbish.

python -m tests.misbehaving.rogue_central NAMES COUNT SECONDS RATE SEED: names of messages that the
client subscribes. It writes its endpoint as a JSON line, and what it sent as another.
"""

from __future__ import annotations

import collections
import json
import os
import random
import sys
import time

import zmq

from hub.errors import HubError
from hub.ipc.wire import control
from hub.ipc.wire.control_codec import pack, unpack
from tests.misbehaving.bad_frames import control_frames, good_frame, spoil
from tests.soak import vocabulary as v

_BURST_S = 0.005


class RogueCentral:
    """Its sockets, and the client that it has."""

    def __init__(self, names: list[str], seed: int) -> None:
        self._chance = random.Random(seed)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._router = self._context.socket(zmq.ROUTER)
        self._port = self._router.bind_to_random_port("tcp://127.0.0.1")
        kinds = (zmq.SUB, zmq.PUB) * 3
        self._others = [self._context.socket(kind) for kind in kinds]
        self._ports = tuple(other.bind_to_random_port("tcp://127.0.0.1") for other in self._others)
        self._definitions = [v.BROADCASTS[name] for name in names]
        self._client = b""
        self._said = [*control_frames(), pack(self._welcome()), _listing()]
        self.sent: collections.Counter[str] = collections.Counter()

    @property
    def endpoint(self) -> str:
        return f"tcp://127.0.0.1:{self._port}"

    def hear(self) -> bool:
        """Answer hellos and pings as a good central does; whether it has a client."""
        while self._router.poll(0):
            identity, *body = self._router.recv_multipart()
            try:
                message = unpack(body[0])
            except HubError:
                continue
            if isinstance(message, control.Hello):
                self._client = identity
                self._router.send_multipart([identity, pack(self._welcome())])
            elif isinstance(message, control.Ping):
                self._router.send_multipart(
                    [
                        identity,
                        pack(control.Pong(epoch=5, sent=message.sent, hub_time=0.0)),
                    ]
                )
        return bool(self._client)

    def one(self, number: int) -> None:
        """Send one bad frame."""
        chance = self._chance
        if number % 2:
            definition = chance.choice(self._definitions)
            keep = len(definition.name) + 2
            raw = spoil(good_frame(definition, number), chance, keep=keep)
            place = ("state", "command", "picture").index(definition.plane.value)
            self._others[2 * place + 1].send(raw)
            self.sent[definition.plane.value] += 1
            return
        raw = spoil(chance.choice(self._said), chance, keep=chance.choice([0, 8, 8]))
        parts = [raw] if chance.random() < 0.8 else [raw, chance.randbytes(chance.randint(0, 99))]
        self._router.send_multipart([self._client, *parts])
        self.sent["control"] += 1

    def close(self) -> None:
        """Leave."""
        self._context.destroy(linger=500)

    def _welcome(self) -> control.Welcome:
        return control.Welcome(
            publisher=3,
            epoch=5,
            machine=0,
            sent=0.0,
            hub_time=0.0,
            near=True,
            ports=self._ports,
            paths=("",) * 6,
        )


def _listing() -> bytes:
    return pack(
        control.Listing(
            uptime_s=1.0,
            level="info",
            definitions=(),
            peers=(),
            dropped=(),
        )
    )


def _say(figures: object) -> None:
    sys.stdout.write(json.dumps(figures) + "\n")
    sys.stdout.flush()


def main() -> None:
    os.nice(10)
    names, count, seconds, rate, seed = sys.argv[1:6]
    central = RogueCentral(names.split(","), int(seed))
    _say({"endpoint": central.endpoint})
    while not central.hear():
        time.sleep(_BURST_S)
    started = time.monotonic()
    done = 0
    while done < int(count) and time.monotonic() - started < float(seconds):
        due = min(int(count), int((time.monotonic() - started) * float(rate)))
        while done < due:
            central.one(done)
            done += 1
        central.hear()
        time.sleep(_BURST_S)
    central.close()
    _say({"done": done, "took_s": round(time.monotonic() - started, 1), **central.sent})


if __name__ == "__main__":
    main()
