"""The peers that publish, subscribe to or answer each message."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from hub.ipc.broker.definitions import Definitions
from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.quotas import quota_of
from hub.ipc.definition import MAX_NAME_LENGTH
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire.control import Change

MAX_NAMES = 4096
"""Messages one peer may publish, subscribe to or answer."""


class MessageUsers:
    """The users of messages in one sense, such as publishers, in the order of their start."""

    def __init__(
        self,
        change: Change,
        names_of: Callable[[Peer], set[str]],
        definitions: Definitions,
        presence: PresenceReports,
        faults: FaultCounter,
    ) -> None:
        """Start with no users.

        Args:
            change: The report at the start and end of a use.
            names_of: The messages that a peer uses so.
            definitions: The messages that are defined.
            presence: Makes the reports.
            faults: Counts what is refused.
        """
        self._change = change
        self._names_of = names_of
        self._definitions = definitions
        self._presence = presence
        self._faults = faults
        self._peers: dict[str, dict[Peer, None]] = {}

    def of(self, name: str) -> Iterator[Peer]:
        """The users of the message `name`."""
        return iter(self._peers.get(name, ()))

    def count(self, name: str) -> int:
        """The number of users of the message `name`."""
        return len(self._peers.get(name, ()))

    def refusal(self, peer: Peer, name: str, *, undefined: bool = False) -> str:
        """Why `peer` may not use one more message, counted as a fault; empty: it may.

        Args:
            peer: The peer.
            name: Of the message.
            undefined: Whether the message need not be defined yet.
        """
        known = name in self._definitions or (undefined and len(name) <= MAX_NAME_LENGTH)
        quota = quota_of(peer.principal)
        limit = MAX_NAMES if quota is None else quota.names
        names = self._names_of(peer)
        if known and (len(names) < limit or name in names):
            return ""
        reason = f"it has {limit} already, its limit" if known else "it is not defined"
        text = f"{peer.name} wants {name[:80]!r}: {reason}"
        self._faults.count("refused name", text)
        return text

    def join(self, peer: Peer, name: str) -> list[Outgoing]:
        """Add a user; the reports, if it is new."""
        self._names_of(peer).add(name)
        peers = self._peers.setdefault(name, {})
        if peer in peers:
            return []
        peers[peer] = None
        return self._presence.report(self._change, peer, name, len(peers))

    def leave(self, peer: Peer, name: str) -> list[Outgoing]:
        """Remove a user; the reports, if it was one."""
        self._names_of(peer).discard(name)
        peers = self._peers.get(name, {})
        if peer not in peers:
            return []
        del peers[peer]
        if not peers:
            del self._peers[name]
        return self._presence.report(self._change, peer, name, len(peers))

    def leave_all(self, peer: Peer) -> list[Outgoing]:
        """Remove `peer` from all messages."""
        return [each for name in sorted(self._names_of(peer)) for each in self.leave(peer, name)]
