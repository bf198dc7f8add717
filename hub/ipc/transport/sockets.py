"""Makes every socket of the bus, with its options before bind or connect."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.ipc.definition import Plane
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.token import RunPassword, Token
from hub.ipc.wire.frames import MAX_FRAME

_EVENT = struct.Struct("=hi")
"""A monitor's event in ZeroMQ's layout: its kind, and a descriptor or an error number."""
Socket = zmq.Socket[bytes]
Context = zmq.Context[Socket]

Keys = ClientKeys | Token | RunPassword
"""What a client shows where it connects."""
PLANES = tuple(Plane)
QUEUE = {Plane.STATE: 1000, Plane.COMMAND: 500, Plane.PICTURE: 2}
"""Most messages that wait for one slow peer, by plane; newer ones are dropped and show as gaps."""
GATHER_QUEUE = 8000
"""The same for a receiver that looks now and then: more than an expected 4,000 messages a second in
the 1.7 s after which central forgets a silent receiver."""

# Plain numbers: combining members of an enum takes microseconds.
NOBLOCK = int(zmq.NOBLOCK)
MORE = int(zmq.NOBLOCK) | int(zmq.SNDMORE)
_POLLIN = int(zmq.POLLIN)

_CONTROL_QUEUE, _CONTROL_BACKLOG = 1000, 20_000
"""Most control messages that wait from one peer, and for one: a new peer gets many at once."""
_PICTURE_BUFFER = 64 << 10
"""Kernel buffers of the picture plane [bytes]: pictures in them grow old."""
_SUBSCRIPTIONS = 1 << 16
"""Most subscriptions under way at once; they are messages that must not be dropped."""
_TAKEN_AT_ONCE = 16
_LONGEST_SUBSCRIPTION = 320
"""Longest subscription at the output of a plane, its only input [B]. The longest frame of a
handshake has about 300 bytes. A byte of a topic takes 0.3 kB of central's memory."""
CONNECTING = 1024
"""Most publishers that wait for a connection to an inbox: more than central has clients."""
_DIRECT_THREAD = 0b10
"""A client's second I/O thread, for direct messages: a flood at central does not delay them."""


def make(context: Context, kind: int, queue: int, keys: Keys | None = None) -> Socket:
    """A socket with the bus's options, and a client's keys if it has some.

    Queues are bounded; closing never waits. The system's keep-alive frees the connections of a dead
    peer; its missing PINGs show earlier that it is dead. ZeroMQ's heartbeats would free them too.
    But libzmq 4.3.5 aborts the process when a heartbeat is due on a connection that ends, or whose
    queue has been full for a while.
    """
    made = context.socket(kind)
    made.linger = 0
    made.sndhwm = made.rcvhwm = queue
    made.maxmsgsize = MAX_FRAME
    made.reconnect_ivl = 50
    made.reconnect_ivl_max = 250
    made.connect_timeout = 3000
    made.handshake_ivl = 3000
    made.tcp_keepalive = 1
    made.tcp_keepalive_idle, made.tcp_keepalive_intvl, made.tcp_keepalive_cnt = 4, 2, 2
    made.tcp_maxrt = 8000  # the same, while data is under way
    if kind in (zmq.XPUB, zmq.DEALER):
        # Keep nothing for an absent central: it would be old at its arrival.
        made.immediate = True
    if keys is not None:
        keys.apply(made)
        # Only clients have keys. A proof takes four round trips, also on a line of 0.9 s.
        made.handshake_ivl = 8000
    return made


def make_plane(context: Context, kind: int, plane: Plane, keys: Keys | None = None) -> Socket:
    """A socket of one plane: at central XSUB and XPUB, at a client XPUB to send, SUB to receive."""
    made = make(context, kind, QUEUE[plane], keys)
    # Subscriptions run against the messages, so the other queue of each socket holds only them.
    # ZeroMQ reads all waiting subscriptions before the next message, so their queue is short.
    # The rest waits at the sender and is not lost.
    if kind in (zmq.SUB, zmq.XSUB):
        made.sndhwm = _SUBSCRIPTIONS
    else:
        made.rcvhwm = _TAKEN_AT_ONCE
        made.maxmsgsize = _LONGEST_SUBSCRIPTION
    if plane is Plane.PICTURE:
        made.sndbuf = made.rcvbuf = _PICTURE_BUFFER
    return made


def make_router(context: Context) -> Socket:
    """Central's socket for control messages (ROUTER)."""
    made = make(context, zmq.ROUTER, _CONTROL_QUEUE)
    made.sndhwm = _CONTROL_BACKLOG
    made.router_mandatory = True
    return made


def pair(context: Context, address: str) -> tuple[Socket, Socket]:
    """Two connected sockets of one process, to receive and to send (PAIR)."""
    receiving, sending = context.socket(zmq.PAIR), context.socket(zmq.PAIR)
    receiving.bind(address)
    sending.connect(address)
    return receiving, sending


def make_inbox(context: Context, kind: int, plane: Plane, queue: int = 0) -> Socket:
    """A socket for direct messages of one plane: PULL to receive, PUSH to send."""
    made = make(context, kind, queue or QUEUE[plane])
    if kind == zmq.PULL:
        allow_own_user_only(made)
        # A busy subscriber accepts the connections of all its publishers later.
        made.backlog = CONNECTING
    made.affinity = _DIRECT_THREAD
    if plane is Plane.PICTURE:
        made.sndbuf = made.rcvbuf = _PICTURE_BUFFER
    return made


def allow_own_user_only(socket: Socket, *, root: bool = False) -> None:
    """Admit only this user, and root if wanted: abstract sockets have no permissions."""
    for user in {os.getuid(), 0 if root else os.getuid()}:
        socket.setsockopt(zmq.IPC_FILTER_UID, user)


def sender(socket: Socket) -> Callable[[bytes, int], Any]:
    """The socket's `send` for plain bytes, without pyzmq's Python code for other types."""
    send: Callable[[bytes, int], Any] = zmq.backend.Socket.send.__get__(socket)
    return send


def send_parts(send: Callable[[bytes, int], Any], parts: Sequence[bytes]) -> None:
    """Send the parts of one message.

    Raises:
        zmq.Again: There is no room, or no receiver.
    """
    for part in parts[:-1]:
        send(part, MORE)
    send(parts[-1], NOBLOCK)


def readable(socket: Socket) -> bool:
    """Whether there is input; costs half of a failing attempt."""
    return bool(int(socket.getsockopt(zmq.EVENTS)) & _POLLIN)


def bind(socket: Socket, address: str) -> None:
    """Bind; IPv6 is on for the addresses that need it."""
    socket.ipv6 = "[" in address
    socket.bind(address)


def connect(socket: Socket, address: str) -> None:
    """Connect; IPv6 is on for the addresses that need it."""
    socket.ipv6 = "[" in address
    socket.connect(address)


def parse_event(parts: Sequence[bytes]) -> tuple[int, int]:
    """The event in a message from a monitor, and its value.

    pyzmq's own function is in a file that imports asyncio, which takes as long as NumPy.
    """
    event, value = _EVENT.unpack(parts[0])
    return event, value


def descriptor_of(frame: zmq.Frame) -> int:
    """The descriptor of a frame's connection; -1: unknown."""
    try:
        return int(frame.get("__fd"))
    except (zmq.ZMQError, ValueError, TypeError):
        return -1
