"""Options of sockets that a wrong value of has ended processes."""

from __future__ import annotations

import contextlib
import socket
import struct
import subprocess
import sys

import zmq

from hub.ipc.transport import sockets
from tests.misbehaving import bad_connections

# Reads a little, pauses with a full queue for longer than any heartbeat timeout, and reads again.
SLOW_READER = """
import sys, time, zmq
from hub.ipc.transport import sockets
with zmq.Context() as context:
    reader = sockets.make(context, zmq.SUB, 20)
    reader.subscribe(b"")
    reader.connect(sys.argv[1])
    for _ in range(5):
        reader.recv()
    time.sleep(4.0)
    for _ in range(100):
        reader.recv()
    reader.close(0)
"""


def test_a_reader_that_paused_with_a_full_queue_lives_on() -> None:
    with zmq.Context() as context, sockets.make(context, zmq.XPUB, 20) as sender:
        port = sender.bind_to_random_port("tcp://127.0.0.1")
        address = f"tcp://127.0.0.1:{port}"
        reader = subprocess.Popen([sys.executable, "-c", SLOW_READER, address])
        sender.recv()  # the subscription: what is left unread would end each poll at once
        while reader.poll() is None:
            for _ in range(20):
                sender.send(bytes(20_000))
            sender.poll(20)
    assert reader.returncode == 0


# Lets subscriptions pile up for a while, as a busy module does, and then takes them.
BUSY_PUBLISHER = """
import sys, time, zmq
from hub.ipc.transport import sockets
from hub.ipc.definition import Plane
with zmq.Context() as context:
    publisher = sockets.make_plane(context, zmq.XPUB, Plane.STATE)
    port = publisher.bind_to_random_port("tcp://127.0.0.1")
    print(port, flush=True)
    taken = 0
    for _ in range(8):
        time.sleep(0.25)
        for _ in range(100):
            if publisher.poll(0):
                publisher.recv()
                taken += 1
        publisher.send(b"x")
    print(taken, flush=True)
    publisher.close(0)
"""


def test_a_publisher_lives_on_when_flooding_subscribers_reset_their_connections() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", BUSY_PUBLISHER], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        port = child.stdout.readline().strip()
        reset = struct.pack("ii", 1, 0)
        flood = b"".join(b"\0\x08\1%07d" % number for number in range(100_000))
        for _ in range(20):
            # It may end, and with it the connection, at any time: also in the handshake.
            with contextlib.suppress(OSError, ValueError), bad_connections.subscriber(port) as raw:
                raw.settimeout(0.05)
                raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, reset)
                raw.sendall(flood)
        taken = child.stdout.read()
    assert child.returncode == 0
    assert int(taken) >= 16
