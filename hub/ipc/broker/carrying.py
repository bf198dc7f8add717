"""Carries commands between two sockets, and checks each one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import zmq

from hub.ipc.transport.sockets import Socket

_BATCH = 32
_PAUSE_MS = 2
"""Rest after a full batch [ms]: it bounds the processor time of a flood."""
_SUBSCRIPTIONS = 256

Judge = Callable[[bytes, zmq.Frame], bytes | None]
"""(frame, the same as ZeroMQ received it) -> the frame to forward; None to drop it."""


def carry(
    outer: Mapping[Socket, Judge], inner: Socket, steered: Socket, copies: Socket | None = None
) -> None:
    """Carry commands in and subscriptions out until `steered` receives.

    ZeroMQ takes one frame of each connection in turn, so a flood on one does not block the
    others. After a batch the carrier rests, so a flood leaves processor time.

    Args:
        outer: Sockets (XSUB) where commands come in, and what decides about each frame there.
        inner: XPUB, where they go on.
        steered: Receives a message as the order to end.
        copies: Gets each forwarded frame too.
    """
    poller = zmq.Poller()
    for socket in (*outer, inner, steered):
        poller.register(socket, zmq.POLLIN)
    while True:
        ready = dict(poller.poll())
        if steered in ready:
            steered.recv(zmq.NOBLOCK)
            return
        if inner in ready:
            _pass_subscriptions(inner, outer)
        # A list: each has its turn.
        full = [_take(each, inner, outer[each], copies) for each in outer if each in ready]
        if any(full) and steered.poll(_PAUSE_MS):
            steered.recv(zmq.NOBLOCK)
            return


def _pass_subscriptions(inner: Socket, outer: Iterable[Socket]) -> None:
    for _ in range(_SUBSCRIPTIONS):
        try:
            subscription = inner.recv(zmq.NOBLOCK)
        except zmq.Again:
            return
        for each in outer:
            each.send(subscription, zmq.NOBLOCK)


def _take(outer: Socket, inner: Socket, judge: Judge, copies: Socket | None) -> bool:
    """Read a batch of frames; whether there may be more."""
    for _ in range(_BATCH):
        try:
            frame: Any = outer.recv(zmq.NOBLOCK, copy=False)
        except zmq.Again:
            return False
        parts = 1
        while outer.getsockopt(zmq.RCVMORE):
            outer.recv(zmq.NOBLOCK, copy=False)
            parts += 1
        admitted = judge(frame.bytes if parts == 1 else b"", frame)
        if admitted is not None:
            inner.send(admitted, zmq.NOBLOCK)
            if copies is not None:
                copies.send(admitted, zmq.NOBLOCK)
    return True
