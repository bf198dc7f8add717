"""The connections of peers: HELLO and its refusal, signs of life, and the end of each.

| what happens | what central does |
| --- | --- |
| HELLO of a new peer | it gets a number and WELCOME, or REFUSED |
| HELLO of a peer that is connected | it gets the same WELCOME again |
| HELLO under a name, from the client that has the name | the earlier connection is dropped first |
| the connection ends, BYE, CLOSE, a full queue, `SILENCE_S` without a message | it is dropped |
"""

from __future__ import annotations

import logging
import os
import secrets
from collections.abc import Callable

from hub.errors import NotAllowedError
from hub.ipc.broker.peers import Caller, Outgoing, Peer, Peers
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.quotas import counts_with, quota_of
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security.publish_rights import ROBOT_NAMES, reserved_text
from hub.ipc.transport import sender_tickets
from hub.ipc.transport.clock_sync import this_machine, this_neighbourhood
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import is_from_this_process, relayed
from hub.ipc.wire import control
from hub.ipc.wire.control import Change

_logger = logging.getLogger(__name__)

MAX_PEERS = 512
SILENCE_S = 1.7
"""A peer without a control message for this long is dropped [s]."""


class Connections:
    """Decides which peers are connected.

    Attributes:
        epoch: A number of this run of central.
    """

    def __init__(
        self,
        peers: Peers,
        presence: PresenceReports,
        forget: Callable[[Peer], list[Outgoing]],
        *,
        reserved: frozenset[str],
        key: str,
        forwarder: str,
        clock: Callable[[], float],
        faults: FaultCounter,
    ) -> None:
        """Start with no connections.

        Args:
            peers: Where peers are added and removed.
            presence: Reports which peers connect and which are gone.
            forget: Ends all that a removed peer did.
            reserved: Names that only the robot's own modules may have.
            key: Of the tickets that clients show to central.
            forwarder: The client of this process that forwards messages under the numbers of
                others; empty: none does.
            clock: Monotonic time [s].
            faults: Counts what is refused.
        """
        self.epoch = secrets.randbits(63) | 1
        self._peers = peers
        self._presence = presence
        self._forget = forget
        self._reserved = ROBOT_NAMES | reserved
        self._key = key
        self._forwarder = forwarder
        self._clock = clock
        self._faults = faults

    def hello(self, caller: Caller, message: control.Hello) -> list[Outgoing]:
        """Connect a peer, or refuse it."""
        identity, outgoing = caller.identity, []
        peer = self._peers.of(identity)
        if peer is None:
            earlier = self._peers.named(message.name)
            if earlier is not None and earlier.client == message.client != 0:
                outgoing = self.drop(earlier, "it connects anew")
            refusal = self._refusal(message.name, caller.principal)
            if refusal:
                self._faults.count("refused connection", refusal.text)
                return [*outgoing, Outgoing(identity=identity, message=refusal)]
            peer = self._new_peer(caller, message)
            self._peers.add(peer)
            _logger.info("%s connected (pid %d)", peer.name, peer.pid)
            outgoing += self._presence.report(Change.CONNECTED, peer)
        welcome = control.Welcome(
            publisher=peer.publisher,
            epoch=self.epoch,
            machine=this_machine(),
            sent=message.sent,
            hub_time=self._clock(),
            near=peer.near,
            ports=caller.ports,
            paths=caller.paths,
            ticket=sender_tickets.ticket(self._key, peer.sends_under),
        )
        return [Outgoing(identity=identity, message=welcome), *outgoing]

    def ping(self, peer: Peer, message: control.Ping) -> list[Outgoing]:
        """Answer with the hub's time."""
        pong = control.Pong(epoch=self.epoch, sent=message.sent, hub_time=self._clock())
        return [Outgoing(identity=peer.identity, message=pong)]

    def bye(self, peer: Peer, _: control.Bye) -> list[Outgoing]:
        """Drop a peer that closes its connection."""
        return self.drop(peer, "it said goodbye")

    def close(self, peer: Peer, message: control.Close) -> list[Outgoing]:
        """Close the connection of a module, by order of `peer`."""
        other = self._peers.named(message.name)
        if other is None:
            text = f"no module named {message.name[:80]!r} is connected"
            refusal = control.Refused(subject=message.name, error="UnknownModuleError", text=text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        closed = control.Close(name=other.name, by=peer.name)
        both = dict.fromkeys((other.identity, peer.identity))
        outgoing = [Outgoing(identity=identity, message=closed) for identity in both]
        return outgoing + self.drop(other, f"{peer.name} closed it")

    def disconnected(self, descriptor: int) -> list[Outgoing]:
        """Drop the peer whose control connection ended."""
        gone = [peer for peer in self._peers if peer.descriptor == descriptor >= 0]
        return [message for peer in gone for message in self.drop(peer, "its connection ended")]

    def unreachable(self, identity: bytes) -> list[Outgoing]:
        """Drop a peer that a message could not reach."""
        peer = self._peers.of(identity)
        return self.drop(peer, "it cannot be reached") if peer else []

    def expire(self) -> list[Outgoing]:
        """Drop silent peers."""
        now = self._clock()
        silent = [peer for peer in self._peers if now - peer.last_message > SILENCE_S]
        return [message for peer in silent for message in self.drop(peer, "it is silent")]

    def drop(self, peer: Peer, why: str) -> list[Outgoing]:
        """Forget a peer; queries that wait for it end at once."""
        _logger.info("%s is gone: %s", peer.name, why)
        self._peers.remove(peer)
        return self._forget(peer) + self._presence.report(Change.DISCONNECTED, peer)

    def _new_peer(self, caller: Caller, message: control.Hello) -> Peer:
        local = caller.principal is LOCAL and not relayed(caller.descriptor)
        number = self._peers.new_number()
        forwards = (
            local
            and message.name == self._forwarder
            and message.pid == os.getpid()
            and is_from_this_process(caller.descriptor)
        )
        return Peer(
            identity=caller.identity,
            descriptor=caller.descriptor,
            name=message.name,
            pid=message.pid,
            principal=caller.principal,
            client=message.client,
            near=local and message.neighbourhood == this_neighbourhood() != 0,
            publisher=number,
            sends_under=sender_tickets.ANY if forwards else number,
            last_message=self._clock(),
        )

    def _refusal(self, name: str, principal: Principal) -> control.Refused | None:
        error = "CentralUnreachableError"
        holder = self._peers.named(name)
        if not 0 < len(name) <= 64 or not name.isprintable():
            text = "a module's name is 1 to 64 printable characters"
        elif name in self._reserved and principal.role is not Role.MODULE:
            error, text = NotAllowedError.__name__, reserved_text(name, principal)
        elif len(self._peers) >= MAX_PEERS:
            text = f"{MAX_PEERS} modules are connected, no more are taken"
        elif holder is not None:
            error = "NameTakenError"
            text = f"a module named {name!r} is connected already (pid {holder.pid}); end it first"
        else:
            text = self._over_quota(principal)
        return control.Refused(subject=name, error=error, text=text) if text else None

    def _over_quota(self, principal: Principal) -> str:
        """Why this key has no room for another client; empty: it has."""
        quota = quota_of(principal)
        if quota is None:
            return ""
        connected = [peer.principal for peer in self._peers]
        if connected.count(principal) >= quota.connections:
            return (
                f"{quota.connections} clients are connected with the key {principal.name!r}, its "
                "limit; end one of them"
            )
        together = sum(counts_with(each, principal.role) for each in connected)
        if together >= quota.connections_together:
            return (
                f"{quota.connections_together} clients are connected with keys that may do no "
                f"more than {principal.role.value}, their limit; end one of them"
            )
        return ""
