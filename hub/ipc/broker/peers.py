"""The peers that are connected to central, and the messages that central has for them."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from dataclasses import field
from typing import Any, NamedTuple

from hub.ipc.formats.codegen import Buffer
from hub.ipc.roles import Principal
from hub.ipc.wire.control import Handle
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Outgoing:
    """A control message to send.

    Attributes:
        identity: Of the connection.
        message: The control message.
        attached: The message frame behind it.
    """

    identity: bytes
    message: Any
    attached: Buffer | None = None


class Caller(NamedTuple):
    """The connection that a control message came on.

    Attributes:
        identity: Of the connection.
        descriptor: File descriptor of the connection; -1 if unknown.
        principal: Holder of the connection's key.
        ports: TCP ports of the planes, at its entrance.
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
        principal: Holder of its key; this decides its rights.
        client: Its random number; 0: none.
        publisher: Its number in frame headers.
        sends_under: The number in its tickets; `sender_tickets.ANY` if it forwards messages.
        last_message: Time of its last control message [s].
        handles: Names of the queries it answers.
        publishes: Names of the messages it publishes.
        subscribes: Names of the messages it subscribes to.
        watches: Whether it gets PRESENCE for every change.
        follows: Names of the modules for whose connections it gets PRESENCE.
        near: Whether other peers of central's machine and user reach it directly.
        direct_handlers: Its addresses and keys for direct queries, by message name.
        direct_askers: The peers that have such an address, with the message.
    """

    identity: bytes
    descriptor: int
    name: str
    pid: int
    principal: Principal
    client: int
    publisher: int
    sends_under: int
    last_message: float
    handles: set[str] = field(default_factory=set)
    publishes: set[str] = field(default_factory=set)
    subscribes: set[str] = field(default_factory=set)
    watches: bool = False
    follows: set[str] = field(default_factory=set)
    near: bool = False
    direct_handlers: dict[str, Handle] = field(default_factory=dict)
    direct_askers: set[tuple[Peer, str]] = field(default_factory=set)


class Peers:
    """All connected peers. Any thread may call `names`, `numbers` and `numbered`."""

    def __init__(self) -> None:
        self._by_identity: dict[bytes, Peer] = {}
        self._by_name: dict[str, Peer] = {}
        self._by_number: dict[int, Peer] = {}

    def __iter__(self) -> Iterator[Peer]:
        return iter(self._by_identity.values())

    def __len__(self) -> int:
        return len(self._by_identity)

    def of(self, identity: bytes) -> Peer | None:
        """The peer of a control connection; None if there is none."""
        return self._by_identity.get(identity)

    def named(self, name: str) -> Peer | None:
        """The peer of this name; None if there is none."""
        return self._by_name.get(name)

    def numbered(self, number: int) -> Peer | None:
        """The peer of this number in frame headers; None if there is none."""
        return self._by_number.get(number)

    def names(self) -> tuple[str, ...]:
        """The names of all peers."""
        return tuple(self._by_name)

    def numbers(self) -> tuple[int, ...]:
        """The numbers of all peers."""
        return tuple(self._by_number)

    def new_number(self) -> int:
        """A random number that no peer has."""
        while (number := secrets.randbits(32)) == 0 or number in self._by_number:
            pass
        return number

    def add(self, peer: Peer) -> None:
        """Add a connected peer."""
        self._by_identity[peer.identity] = self._by_name[peer.name] = peer
        self._by_number[peer.publisher] = peer

    def remove(self, peer: Peer) -> None:
        """Remove a peer."""
        self._by_identity.pop(peer.identity, None)
        self._by_number.pop(peer.publisher, None)
        if self._by_name.get(peer.name) is peer:
            del self._by_name[peer.name]
