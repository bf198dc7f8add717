"""Raw connections to every socket of a central that are wrong in every way there is.

python -m tests.misbehaving.bad_connections ADDRESSES COUNT SECONDS SEED: addresses are TCP ports
and socket paths, separated by commas. It writes how many of each kind it made as a JSON line.
"""

from __future__ import annotations

import collections
import contextlib
import json
import os
import random
import socket
import struct
import sys
import time
from collections.abc import Callable

_HELD = 200
_RST = struct.pack("ii", 1, 0)
_SUBSCRIPTIONS = 300


def greeting(*, version: bytes = b"\3\1", mechanism: bytes = b"NULL", server: int = 0) -> bytes:
    """The 64 bytes with which a ZMTP connection starts."""
    signature = b"\xff" + bytes(8) + b"\x7f"
    return signature + version + mechanism.ljust(20, b"\0") + bytes([server]) + bytes(31)


def ready(socket_type: bytes) -> bytes:
    """The command that ends the handshake of mechanism NULL."""
    body = b"\5READY" + b"\x0bSocket-Type" + struct.pack(">I", len(socket_type)) + socket_type
    return b"\4" + bytes([len(body)]) + body


def _random_bytes(chance: random.Random) -> bytes:
    return chance.randbytes(chance.randint(1, 400))


def _other_protocol(chance: random.Random) -> bytes:
    return chance.choice(
        [
            b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n",
            b"\x16\3\1\2\0\1\0\1\xfc\3\3" + chance.randbytes(64),
            b"SSH-2.0-OpenSSH_9.2\r\n",
            b"\x10\x10\0\4MQTT\4\2\0\x3c\0\4abcd",
            b"CONNECT {}\r\nPING\r\n",
        ]
    )


def _cut_greeting(chance: random.Random) -> bytes:
    return greeting()[: chance.randrange(1, 64)]


def _wrong_version(chance: random.Random) -> bytes:
    version = chance.choice([b"\0\0", b"\1\0", b"\2\0", b"\3\0", b"\3\2", b"\4\0", b"\xff\xff"])
    return greeting(version=version) + ready(b"SUB")


def _wrong_mechanism(chance: random.Random) -> bytes:
    mechanism = chance.choice([b"PLAIN", b"CURVE", b"GSSAPI", b"", b"null", chance.randbytes(20)])
    hello = chance.choice([b"\4\x0c\5HELLO\1a\1b", b"\4\xc8\5HELLO" + chance.randbytes(194), b""])
    return greeting(mechanism=mechanism, server=chance.randrange(256)) + hello


def _wrong_socket_type(chance: random.Random) -> bytes:
    kind = chance.choice([b"REQ", b"PULL", b"PAIR", b"ROUTER", b"STREAM", b"", b"X" * 200])
    return greeting() + ready(kind)


def _mutated_handshake(chance: random.Random) -> bytes:
    raw = bytearray(greeting() + ready(_socket_type(chance)) + b"\0\4abcd" * 3)
    for _ in range(chance.randint(1, 8)):
        place = chance.randrange(len(raw))
        if chance.random() < 0.6:
            raw[place] ^= 1 << chance.randrange(8)
        elif chance.random() < 0.5:
            raw[place:place] = chance.randbytes(chance.randint(1, 20))
        else:
            del raw[place : place + chance.randint(1, 6)]
    return bytes(raw)


def _socket_type(chance: random.Random) -> bytes:
    return chance.choice([b"SUB", b"PUB", b"DEALER", b"XSUB", b"XPUB"])


def _giant_frame(chance: random.Random) -> bytes:
    announced = b"\2" + struct.pack(">Q", 8 << 30) + bytes(chance.randint(0, 20_000))
    return greeting() + ready(_socket_type(chance)) + announced


def _unfinished_frame(chance: random.Random) -> bytes:
    announced = b"\2" + struct.pack(">Q", 1 << 20) + bytes(chance.randint(0, 20_000))
    return greeting() + ready(_socket_type(chance)) + announced


def _subscription_flood(chance: random.Random) -> bytes:
    frames = b"".join(b"\0\x0c\1" + chance.randbytes(11) for _ in range(_SUBSCRIPTIONS))
    return greeting() + ready(b"SUB") + frames


def _heartbeat_flood(chance: random.Random) -> bytes:
    pings = b"\4\x09\4PING\0\x01ab" * chance.randint(1, 300)
    return greeting() + ready(_socket_type(chance)) + pings


KINDS: dict[str, Callable[[random.Random], bytes]] = {
    "random bytes": _random_bytes,
    "another protocol": _other_protocol,
    "cut greeting": _cut_greeting,
    "wrong version": _wrong_version,
    "wrong mechanism": _wrong_mechanism,
    "wrong socket type": _wrong_socket_type,
    "mutated handshake": _mutated_handshake,
    "8 GiB announced": _giant_frame,
    "unfinished frame": _unfinished_frame,
    "subscription flood": _subscription_flood,
    "heartbeat flood": _heartbeat_flood,
}


def connect(address: str) -> socket.socket:
    """A raw connection to a TCP port of this machine or to a socket path."""
    if address.isdigit():
        return socket.create_connection(("127.0.0.1", int(address)), 2.0)
    made = socket.socket(socket.AF_UNIX)
    made.settimeout(2.0)
    try:
        made.connect(address)
    except OSError:
        made.close()
        raise
    return made


def subscriber(address: str) -> socket.socket:
    """A raw connection that has shaken hands as a subscriber; what it sends now is taken."""
    made = connect(address)
    made.settimeout(5.0)
    made.sendall(greeting() + ready(b"SUB"))
    # Not before the other side is ready as well: it would take messages for a bad handshake.
    made.recv(64, socket.MSG_WAITALL)
    _, length = made.recv(2, socket.MSG_WAITALL)
    made.recv(length, socket.MSG_WAITALL)
    return made


class Attack:
    """One attack; some connections are held half open, the oldest are let go."""

    def __init__(self, addresses: list[str], seed: int) -> None:
        self._addresses = addresses
        self._chance = random.Random(seed)
        self._held: collections.deque[socket.socket] = collections.deque()
        self.made: collections.Counter[str] = collections.Counter()

    def one(self) -> None:
        """Make one bad connection."""
        chance = self._chance
        kind = chance.choice(list(KINDS))
        raw = KINDS[kind](chance)
        try:
            made = connect(chance.choice(self._addresses))
        except OSError:
            self.made["refused"] += 1
            return
        self.made[kind] += 1
        # It may be cut off at any byte, which is what is wanted.
        with contextlib.suppress(OSError):
            if chance.random() < 0.1 and len(raw) < 500:
                for byte in range(0, len(raw), 5):
                    made.send(raw[byte : byte + 5])
            else:
                made.sendall(raw)
        self._leave(made)

    def _leave(self, made: socket.socket) -> None:
        how = self._chance.random()
        if how < 0.1:
            self._held.append(made)
            self.made["held open"] += 1
            if len(self._held) > _HELD:
                self._held.popleft().close()
            return
        if how < 0.6 and made.family != socket.AF_UNIX:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RST)
        made.close()

    def close(self) -> None:
        """Let all go."""
        while self._held:
            self._held.pop().close()


def main() -> None:
    os.nice(10)  # the attack is on central, not on the processor
    addresses, count, seconds, seed = sys.argv[1:5]
    attack = Attack(addresses.split(","), int(seed))
    started = time.monotonic()
    done = 0
    while done < int(count) and time.monotonic() - started < float(seconds):
        attack.one()
        done += 1
    attack.close()
    took = round(time.monotonic() - started, 1)
    sys.stdout.write(json.dumps({"done": done, "took_s": took, **attack.made}) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
