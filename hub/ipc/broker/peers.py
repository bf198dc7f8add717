"""Who is connected to central, and what central has to tell them."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from hub.ipc.formats.codegen import Buffer
from hub.ipc.roles import Principal


@dataclass(frozen=True, slots=True, kw_only=True)
class Outgoing:
    """A control message to send.

    Attributes:
        identity: To which connection.
        message: The control message.
        attached: A message frame that goes with it.
    """

    identity: bytes
    message: Any
    attached: Buffer | None = None


class Caller(NamedTuple):
    """Where a control message came from.

    Attributes:
        identity: Of the connection.
        descriptor: File descriptor of the connection; -1 if unknown.
        principal: Whose key it was made with.
        ports: TCP ports of the planes for who came this way.
        paths: ipc:// paths of the same.
    """

    identity: bytes
    descriptor: int
    principal: Principal
    ports: tuple[int, ...]
    paths: tuple[str, ...]


@dataclass(slots=True, kw_only=True, eq=False)
class Peer:
    """A connected module or console.

    Attributes:
        identity: Of its control connection.
        descriptor: File descriptor of that connection; -1 if unknown.
        name: Its unique name.
        pid: Its process id.
        principal: Who it is by its key, and so what it may do.
        client: Its random number; 0 if it has none.
        publisher: Number of it in frame headers.
        heard: When it last said anything [s].
        handles: Names of the queries it answers.
        publishes: Names of the messages it publishes.
        subscribes: Names of the messages it subscribes to.
        watches: Whether it is told who comes and goes.
        follows: Names of the modules of whose connections it is told.
        near: Whether others of central's neighbourhood reach it directly.
        doors: Where it can be asked directly, by message name.
        routed: Whom central told of these doors, and for which message.
    """

    identity: bytes
    descriptor: int
    name: str
    pid: int
    principal: Principal
    client: int
    publisher: int
    heard: float
    handles: set[str] = field(default_factory=set)
    publishes: set[str] = field(default_factory=set)
    subscribes: set[str] = field(default_factory=set)
    watches: bool = False
    follows: set[str] = field(default_factory=set)
    near: bool = False
    doors: dict[str, str] = field(default_factory=dict)
    routed: set[tuple[Peer, str]] = field(default_factory=set)


class PeersByMessage:
    """Peers by what they do with a message, in the order in which they began."""

    def __init__(self) -> None:
        self._peers: dict[str, dict[Peer, None]] = {}

    def add(self, name: str, peer: Peer) -> bool:
        """`peer` does it with the message `name` too; whether that is new."""
        peers = self._peers.setdefault(name, {})
        if peer in peers:
            return False
        peers[peer] = None
        return True

    def discard(self, name: str, peer: Peer) -> bool:
        """`peer` does it no longer; whether it did."""
        peers = self._peers.get(name, {})
        if peer not in peers:
            return False
        del peers[peer]
        if not peers:
            del self._peers[name]
        return True

    def of(self, name: str) -> Iterator[Peer]:
        """Who does it with the message `name`."""
        return iter(self._peers.get(name, ()))

    def count(self, name: str) -> int:
        """How many do it with the message `name`."""
        return len(self._peers.get(name, ()))


class Numbers:
    """Peers by their numbers in frame headers; any thread may ask."""

    def __init__(self) -> None:
        self._peers: dict[int, Peer] = {}

    def new(self) -> int:
        """A number that nobody has and nobody can guess."""
        while (number := secrets.randbits(32)) == 0 or number in self._peers:
            pass
        return number

    def of(self, number: int) -> Peer | None:
        """Who has this number; None if nobody has."""
        return self._peers.get(number)

    def give(self, peer: Peer) -> None:
        """`peer` has its number from now on."""
        self._peers[peer.publisher] = peer

    def forget(self, peer: Peer) -> None:
        """`peer` is gone."""
        self._peers.pop(peer.publisher, None)
