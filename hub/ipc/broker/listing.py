"""What central tells of each message and each peer when somebody asks for the list."""

from __future__ import annotations

from dataclasses import replace

from hub.ipc.broker.peers import Peer
from hub.ipc.broker.traffic import Traffic
from hub.ipc.wire import control

MAX_NAMES = 1000
"""What a listing says of one peer's publications and so on [characters]."""


def definition(entry: control.Define, traffic: Traffic, now: float) -> control.Define:
    """A message as it was defined, with what is known of its broadcasts."""
    messages_per_s, bytes_per_s = traffic.rate(now)
    return replace(
        entry,
        messages=traffic.messages,
        bytes=traffic.bytes,
        messages_per_s=messages_per_s,
        bytes_per_s=bytes_per_s,
        lost=traffic.lost,
        expired=traffic.expired,
        refused=traffic.refused,
        oldest_s=traffic.oldest,
        silent_s=traffic.silent(now),
    )


def peer(known: Peer, now: float) -> control.ListedPeer:
    """A connected module or console."""
    return control.ListedPeer(
        name=known.name,
        pid=known.pid,
        publisher=known.publisher,
        role=known.principal.role.value,
        silent_s=now - known.heard,
        handles=_listed(known.handles),
        publishes=_listed(known.publishes),
        subscribes=_listed(known.subscribes),
    )


def presence(
    change: control.Change, known: Peer, message: str = "", count: int = 0
) -> control.Presence:
    """What a peer has done, for those who watch."""
    return control.Presence(
        change=change,
        module=known.name,
        pid=known.pid,
        message=message,
        count=count,
        publisher=known.publisher,
    )


def _listed(names: set[str]) -> str:
    """Names for a listing, which has to fit into a frame."""
    text = " ".join(sorted(names))
    return text if len(text) <= MAX_NAMES else text[:MAX_NAMES].rpartition(" ")[0]
