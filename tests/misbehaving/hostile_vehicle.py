"""The other end of a link to a vehicle, which sends what no vehicle should.

Between its attacks it says that it is an armed rover in its driving mode, how it lies, and it
answers echoes, so that the driver takes it for a vehicle that is there.
"""

from __future__ import annotations

import contextlib
import itertools
import random
import select
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from hub.robots.mavlink.wire.checksum import checksum
from hub.robots.mavlink.wire.definitions import BY_NAME, LONGEST_PAYLOAD
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame

_ROVER: Final = {"type": 10, "autopilot": 3, "base_mode": 129, "custom_mode": 15}
_AT_ONCE: Final = 1 << 16
_BURST: Final = 400
_EVERY_S: Final = 0.25
_WORDS: Final = (
    *(struct.pack("<f", each) for each in (float("nan"), float("inf"), 3e38, -3e38, 1e-45)),
    *(struct.pack("<I", each) for each in (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)),
    struct.pack("<f", float("-inf")),
)
"""Halves and quarters of them are strange too."""
_TEXTS: Final = (
    "\x1b]0;owned\x07\x1b[2J\x1b[31mArmed",
    "\r\nARMED\r\n" * 3,
    "\u202edesrever\u0301" * 3,
    "%s%n{0}" * 6,
    "",
)
Source = Callable[[random.Random], Iterator[bytes]]


def _frame(name: str, payload: bytes, system: int = 1) -> bytes:
    form = BY_NAME[name]
    head = struct.pack("<BBBBBB", len(payload), 0, 0, 0, system, 1)
    body = head + form.number.to_bytes(3, "little") + payload
    crc = checksum(body + bytes((form.crc_extra,)))
    return b"\xfd" + body + crc.to_bytes(2, "little")


def _packed(name: str, fields: Callable[[random.Random, int], dict[str, Any]]) -> Source:
    """Messages of one name, whose fields come from their number."""

    def made(chance: random.Random) -> Iterator[bytes]:
        packer = FramePacker(1, 1)
        return (packer.pack(name, **fields(chance, number)) for number in itertools.count())

    return made


def _numbers(chance: random.Random) -> Iterator[bytes]:
    """Every message that is read, with strange numbers in every field."""
    names = [each.name for each in BY_NAME.values() if each.fields and each.name != "HEARTBEAT"]
    while True:
        name = chance.choice(names)
        size = min(LONGEST_PAYLOAD, BY_NAME[name].wire.size)
        words = [chance.choice(_WORDS) for _ in range(size // 4 + 1)]
        yield _frame(name, b"".join(words)[:size])


def _mutated(chance: random.Random) -> Iterator[bytes]:
    """Frames with changed, lost and doubled bytes."""
    whole = _numbers(chance)
    while True:
        data = bytearray(next(whole) + next(whole))
        for _ in range(chance.randrange(1, 4)):
            place = chance.randrange(len(data))
            match chance.randrange(3):
                case 0:
                    data[place] ^= 1 << chance.randrange(8)
                case 1:
                    del data[place : place + chance.randrange(1, 12)]
                case _:
                    data[place:place] = data[place : place + chance.randrange(1, 12)]
            data = data or bytearray(b"\xfd")
        yield bytes(data)


def _others(chance: random.Random) -> Iterator[bytes]:
    """Heartbeats of all kinds, of this vehicle's number and of others."""
    while True:
        packer = FramePacker(chance.choice((1, 1, 2, 255, chance.randrange(256))), 1)
        kinds = {"type": chance.randrange(45), "autopilot": chance.randrange(22)}
        mode = {"base_mode": chance.choice((0, 129)), "custom_mode": chance.randrange(30)}
        yield packer.pack("HEARTBEAT", **kinds, **mode, system_status=chance.randrange(9))


def _bytes(data: Callable[[random.Random], bytes]) -> Source:
    def made(chance: random.Random) -> Iterator[bytes]:
        piece = data(chance)
        return itertools.repeat(piece)

    return made


ATTACKS: Final[Mapping[str, Source]] = {
    "noise": _bytes(lambda chance: chance.randbytes(_AT_ONCE)),
    "starts": _bytes(lambda _: b"\xfd" * _AT_ONCE),
    "long starts": _bytes(lambda _: b"\xfd\xff\x00\xfd\xff\x00\x00\x1e\x00\x00\xfd\xff\x00" * 5000),
    "numbers": _numbers,
    "mutated": _mutated,
    "others": _others,
    "texts": _packed(
        "STATUSTEXT",
        lambda chance, number: {
            "severity": chance.randrange(256),
            "text": f"{chance.choice(_TEXTS)}{number}",
            "id": chance.randrange(4),
            "chunk_seq": chance.randrange(256),
        },
    ),
    "parameters": _packed(
        "PARAM_VALUE",
        lambda chance, number: {
            "param_id": chance.choice((f"P{number}", "FS_TIMEOUT", "WP_SPEED", "\x1b[2J")),
            "param_value": chance.choice((float("nan"), float("inf"), -3e38, 0.0)),
            "param_type": chance.randrange(12),
            "param_count": 65535,
        },
    ),
    "answers": _packed(
        "COMMAND_ACK",
        lambda chance, _: {
            "command": chance.choice((176, 400, 511, 512, chance.randrange(65536))),
            "result": chance.randrange(256),
            "target_system": chance.choice((0, 255)),
            "target_component": chance.choice((0, 190)),
        },
    ),
    "boots": _packed("ATTITUDE", lambda chance, _: {"time_boot_ms": chance.randrange(2**32)}),
}


class HostileVehicle:
    """Takes one connection after the other, and attacks each.

    Attributes:
        port: Its TCP port on loopback.
        attack: The name of the attack; empty: none.
        reads: Whether it reads what comes.
        sent: Bytes that it sent.
        frames: What came: monotonic time [s] and frame.
    """

    def __init__(self, seed: int = 20) -> None:
        self.attack, self.reads, self.sent = "", True, 0
        self.frames: list[tuple[float, MavlinkFrame]] = []
        self._chance = random.Random(seed)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.05)
        self.port: int = self._listener.getsockname()[1]
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="hostile vehicle")
        self._thread.start()

    def close(self) -> None:
        self._ends = True
        self._thread.join()
        self._listener.close()

    def _run(self) -> None:
        while not self._ends:
            with contextlib.suppress(OSError), self._listener.accept()[0] as link:
                self._serve(link)

    def _serve(self, link: socket.socket) -> None:
        link.settimeout(0.05)
        packer, parser = FramePacker(1, 1), FrameParser()
        attack = ""
        source: Iterator[bytes] = iter(())
        rest, beat_at = b"", 0.0
        while not self._ends:
            if self.attack != attack:
                attack = self.attack
                source = ATTACKS[attack](self._chance) if attack else iter(())
            if not rest:
                if (now := time.monotonic()) >= beat_at:
                    beat_at = now + _EVERY_S
                    rest += packer.pack("HEARTBEAT", **_ROVER, system_status=4)
                    rest += packer.pack("ATTITUDE", time_boot_ms=int(now * 1e3) % 2**32)
                rest += self._answers(link, parser, packer)
                count = 1 if attack in ("noise", "starts", "long starts") else _BURST
                rest += b"".join(itertools.islice(source, count))
            if not rest or not select.select([], [link], [], 0.02)[1]:
                time.sleep(0.002)
                continue
            with contextlib.suppress(TimeoutError):
                left = link.send(rest)
                self.sent += left
                rest = rest[left:]

    def _answers(self, link: socket.socket, parser: FrameParser, packer: FramePacker) -> bytes:
        if not self.reads or not select.select([link], [], [], 0.0)[0]:
            return b""
        data = link.recv(_AT_ONCE)
        if not data:
            raise ConnectionResetError
        frames = parser.feed(data)
        now = time.monotonic()
        self.frames += [(now, frame) for frame in frames]
        return b"".join(
            packer.pack("TIMESYNC", tc1=1, ts1=frame["ts1"])
            for frame in frames
            if frame.name == "TIMESYNC"
        )
