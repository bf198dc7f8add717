"""Options of sockets that a wrong value of has ended processes."""

from __future__ import annotations

import subprocess
import sys

import zmq

from hub.ipc import sockets

# Reads a little, pauses with a full queue for longer than any heartbeat timeout, and reads again.
SLOW_READER = """
import sys, time, zmq
from hub.ipc import sockets
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
        while reader.poll() is None:
            for _ in range(50):
                sender.send(bytes(20_000))
            sender.poll(20)
    assert reader.returncode == 0
