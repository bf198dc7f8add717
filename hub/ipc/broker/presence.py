"""PRESENCE: central's reports to peers about other peers.

A peer watches all changes, or follows the connections of some modules.
"""

from __future__ import annotations

from hub.ipc.broker.peers import Outgoing, Peer, Peers
from hub.ipc.wire import control
from hub.ipc.wire.control import Change

MAX_FOLLOWED = 16
"""Most modules that one peer follows."""
_CONNECTIONS = (Change.CONNECTED, Change.DISCONNECTED)
_LISTED = (*_CONNECTIONS, Change.DEFINED)


class PresenceReports:
    """The reports of one central.

    Attributes:
        listed_changes: Number of reported changes that a listing shows at once.
    """

    def __init__(self, peers: Peers) -> None:
        """Report to these peers."""
        self._peers = peers
        self.listed_changes = 0

    def report(
        self, change: Change, peer: Peer, message: str = "", count: int = 0
    ) -> list[Outgoing]:
        """Report a change to the peers that watch or follow.

        Args:
            change: Its kind.
            peer: The peer that changed.
            message: Name of the message.
            count: Number of peers with the same use of that message now.
        """
        self.listed_changes += change in _LISTED
        presence = _presence(change, peer, message, count)
        of_connection = change in _CONNECTIONS
        return [
            Outgoing(identity=other.identity, message=presence)
            for other in self._peers
            if other.watches or (of_connection and peer.name in other.follows)
        ]

    def watch(self, peer: Peer, message: control.Watch) -> list[Outgoing]:
        """Report every change to `peer`, or the connections of one module."""
        if not message.module:
            peer.watches = True
        elif len(peer.follows) < MAX_FOLLOWED:
            peer.follows.add(message.module)
            known = self._peers.named(message.module)
            if known is not None:
                presence = _presence(Change.CONNECTED, known)
                return [Outgoing(identity=peer.identity, message=presence)]
        return []


def _presence(change: Change, peer: Peer, message: str = "", count: int = 0) -> control.Presence:
    return control.Presence(
        change=change,
        module=peer.name,
        pid=peer.pid,
        message=message,
        count=count,
        publisher=peer.publisher,
    )
