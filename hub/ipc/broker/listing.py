"""LIST and LISTING: the messages and peers of central; and its log level."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace

from hub.ipc.broker.definitions import Definitions
from hub.ipc.broker.peers import Outgoing, Peer, Peers
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.traffic import Traffic
from hub.ipc.roles import LOCAL
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control
from hub.nonblocking_logging import LEVELS

_logger = logging.getLogger(__name__)

LISTING_S = 0.25
"""Clients with keys get the same LISTING for this long, unless it has changed [s]."""
MAX_NAMES = 1000
"""Most characters for the names of one peer's publications, and so on."""


class Listings:
    """Makes the LISTING that peers ask for."""

    def __init__(
        self,
        peers: Peers,
        definitions: Definitions,
        presence: PresenceReports,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
    ) -> None:
        """Keep no listing yet.

        Args:
            peers: The peers to list.
            definitions: The messages to list.
            presence: Counts the changes that a listing shows at once.
            clock: Monotonic time [s].
            faults: The counts to list.
        """
        self._peers = peers
        self._definitions = definitions
        self._presence = presence
        self._clock = clock
        self._faults = faults
        self._began = clock()
        self._last: control.Listing | None = None
        self._last_made = -math.inf
        self._last_changes = 0

    def answer(self, peer: Peer, _: control.List) -> list[Outgoing]:
        """Answer `peer` with a new listing, or with the last one."""
        now, changes = self._clock(), self._presence.listed_changes
        old = now - self._last_made >= LISTING_S or changes != self._last_changes
        if self._last is None or old or peer.principal is LOCAL:
            self._last = self._make(now)
            self._last_made, self._last_changes = now, changes
        return [Outgoing(identity=peer.identity, message=self._last)]

    def _make(self, now: float) -> control.Listing:
        definitions = tuple(
            _definition(known.entry, known.traffic, now) for known in self._definitions
        )
        peers = tuple(_peer(known, now) for known in self._peers)
        dropped = tuple(
            control.Count(reason=reason, count=count)
            for reason, count in tuple(self._faults.counts.items())
        )
        return control.Listing(
            uptime_s=now - self._began,
            level=logging.getLevelName(_logger.getEffectiveLevel()).lower(),
            definitions=definitions,
            peers=peers,
            dropped=dropped,
        )


def set_log_level(peer: Peer, message: control.LogLevel) -> list[Outgoing]:
    """Set the log level of the hub; an unknown level changes nothing."""
    if message.level in LEVELS:
        logging.getLogger("hub").setLevel(message.level.upper())
        _logger.info("%s set the log level to %s", peer.name, message.level)
    return []


def _definition(entry: control.Define, traffic: Traffic, now: float) -> control.Define:
    """A definition with its traffic."""
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


def _peer(known: Peer, now: float) -> control.ListedPeer:
    """A connected module or console."""
    return control.ListedPeer(
        name=known.name,
        pid=known.pid,
        publisher=known.publisher,
        role=known.principal.role.value,
        silent_s=now - known.last_message,
        handles=_listed(known.handles),
        publishes=_listed(known.publishes),
        subscribes=_listed(known.subscribes),
    )


def _listed(names: set[str]) -> str:
    """Names for a listing, cut to `MAX_NAMES`."""
    text = " ".join(sorted(names))
    return text if len(text) <= MAX_NAMES else text[:MAX_NAMES].rpartition(" ")[0]
