"""Rubbish on every port of a running hub, while a person drives: nothing dies, nothing stops."""

from __future__ import annotations

import contextlib
import json
import random
import socket
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import psutil
import zmq

from hub.gcm.navigation import GROUND_TRUTH, GroundTruth
from hub.ipc.wire import frames
from tests.support.command_line import rune_hub
from tests.system.harness import ConsoleProcess, HubProcess, Observer, family

HUGE_FRAME = (
    # A ZMTP 3.0 greeting with the NULL mechanism, then a frame that announces 8 GiB.
    b"\xff\0\0\0\0\0\0\0\x01\x7f\x03\x00NULL"
    + bytes(16)
    + bytes(32)
    + b"\x02"
    + (8 << 30).to_bytes(8, "big")
    + bytes(1000)
)


def _frame(truth: GroundTruth) -> bytes:
    """A frame that is right in everything."""
    return frames.pack(
        frames.prefix(GROUND_TRUTH.name),
        publisher=1,
        fingerprint=GROUND_TRUTH.fingerprint,
        sequence=1,
        stamp_ns=0,
        payload=GROUND_TRUTH.encode(truth),
    )


def _ports(hub: HubProcess) -> list[int]:
    process = psutil.Process(hub.process.pid)
    return sorted({c.laddr.port for c in process.net_connections() if c.status == "LISTEN"})


def _raw(port: int, data: bytes) -> None:
    # It may be refused in the middle, as it should be.
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 2.0) as peer:
        peer.sendall(data)


def _through_zeromq(address: str, rubbish: list[list[bytes]]) -> None:
    with zmq.Context() as context:
        for kind in (zmq.DEALER, zmq.PUB, zmq.PUSH):
            with context.socket(kind) as peer:
                peer.linger = 100
                peer.connect(address)
                peer.poll(50, zmq.POLLOUT)
                for parts in rubbish:
                    try:
                        peer.send_multipart(parts, zmq.NOBLOCK)
                    except zmq.Again:
                        break


def test_rubbish_on_every_port_changes_nothing(
    tmp_path: Path, start_console: Callable[..., ConsoleProcess], stack: ExitStack
) -> None:
    hub = stack.enter_context(closing(HubProcess(tmp_path, options=("--listen", "0"))))
    console = start_console(hub.endpoint)
    console.wait_for_picture()
    observer = stack.enter_context(closing(Observer(hub.endpoint)))
    chance = random.Random(1)
    good = _frame(observer.truth)
    rubbish = [[good[: chance.randrange(len(good))]] for _ in range(30)]
    rubbish += [[chance.randbytes(chance.randrange(1, 300))] for _ in range(30)]
    rubbish += [[b"SIM_Unheard\0\0\0\0\0" + good[16:]], [b"RUNE\1\5\0\0" + bytes(9)], [b"RUNE"] * 9]
    ports = _ports(hub)
    assert len(ports) == 7
    processes = {each.pid for each in family(hub.process.pid)}
    for port in ports:
        for data in (b"GET / HTTP/1.1\r\n\r\n", chance.randbytes(500), HUGE_FRAME, b"\xff", b""):
            _raw(port, data)
        _through_zeromq(f"tcp://127.0.0.1:{port}", rubbish)
        console.hold_until("w", lambda: observer.truth.linear > 0.2)
    for address in (hub.endpoint, *(f"{hub.endpoint}.{number}" for number in range(1, 7))):
        _through_zeromq(address, rubbish)
        console.hold_until("w", lambda: observer.truth.linear > 0.2)
    assert {each.pid for each in family(hub.process.pid)} == processes
    listing = rune_hub("list", "--json", "--hub", hub.endpoint)
    dropped = {entry["reason"]: entry["count"] for entry in json.loads(listing.stdout)["dropped"]}
    assert dropped["bad handshake on control"] >= 5  # at TCP no frame is read without the token
    assert dropped["malformed control frame"] >= 10
    log = hub.log.read_text()
    for reason in dropped:
        assert log.count(f" hub WARNING {reason} (") <= 1
    assert "Traceback" not in log
