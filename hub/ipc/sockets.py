"""Where every socket of the bus is made: options before bind or connect, in one place."""

from __future__ import annotations

import zmq

from hub.ipc.definition import Plane
from hub.ipc.frames import MAX_FRAME

PLANES = tuple(Plane)
QUEUE = {Plane.STATE: 500, Plane.COMMAND: 50}
"""Messages a plane keeps for one slow peer; beyond it the newest are dropped and seen as gaps."""


def make(context: zmq.Context[zmq.Socket[bytes]], kind: int, queue: int) -> zmq.Socket[bytes]:
    """A socket with the bus's options.

    Heartbeats find a dead peer in 1.5 s; queues are bounded; closing never waits.
    """
    made = context.socket(kind)
    made.linger = 0
    made.sndhwm = made.rcvhwm = queue
    made.maxmsgsize = MAX_FRAME
    if kind not in (zmq.SUB, zmq.DEALER):
        # libzmq 4.3.5 aborts the process when a socket with heartbeats is read again after its
        # queue was full for longer than the timeout. So only sockets that are always read, or only
        # written to, have them; a client sees by its own pings that central has gone.
        made.heartbeat_ivl = 500
        made.heartbeat_timeout = 1500
        made.heartbeat_ttl = 2000
    made.reconnect_ivl = 50
    made.reconnect_ivl_max = 250
    made.connect_timeout = 1000
    made.handshake_ivl = 3000
    made.tcp_keepalive = 1
    if kind in (zmq.PUB, zmq.DEALER):
        # Nothing may be kept for a central that is not there: it would be old when it comes.
        made.immediate = True
    return made


def bind(socket: zmq.Socket[bytes], address: str) -> None:
    """Bind; IPv6 is switched on for the addresses that need it."""
    socket.ipv6 = "[" in address
    socket.bind(address)


def connect(socket: zmq.Socket[bytes], address: str) -> None:
    """Connect; IPv6 is switched on for the addresses that need it."""
    socket.ipv6 = "[" in address
    socket.connect(address)
