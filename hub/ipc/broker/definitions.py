"""The messages that are defined at central: DEFINE and REPORT."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import field, replace

from hub.errors import HubError
from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.broker.presence import PresenceReports
from hub.ipc.broker.quotas import quota_of
from hub.ipc.broker.traffic import Traffic
from hub.ipc.formats.codec import compiled
from hub.ipc.roles import Principal
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control
from hub.ipc.wire.control import Change
from hub.ipc.wire.definition_listing import from_listing
from hub.values import dataclass

MAX_DEFINITIONS = 4096
MAX_LISTED = 1 << 20
"""Most characters of all definitions together: their list fits into one frame."""


@dataclass(slots=True, kw_only=True)
class Definition:
    """A message as it was first defined.

    Attributes:
        entry: Its definition, and the name of the definer.
        fingerprint: Of its format.
        traffic: Its broadcasts.
    """

    entry: control.Define
    fingerprint: int
    traffic: Traffic = field(default_factory=Traffic)


class Definitions:
    """All messages that are defined; a definition lasts as long as central."""

    def __init__(self, presence: PresenceReports, faults: FaultCounter) -> None:
        """Start without any.

        Args:
            presence: Reports new messages.
            faults: Counts what is refused.
        """
        self._presence = presence
        self._faults = faults
        self._known: dict[str, Definition] = {}
        self._listed = 0
        self._defined_by: Counter[Principal] = Counter()

    def __contains__(self, name: str) -> bool:
        return name in self._known

    def __iter__(self) -> Iterator[Definition]:
        return iter(self._known.values())

    def get(self, name: str) -> Definition | None:
        """The message of this name, if it is defined."""
        return self._known.get(name)

    def plane_of(self, name: str) -> str | None:
        """The plane of the message of this name; None if it is not defined."""
        known = self._known.get(name)
        return known.entry.plane if known else None

    def define(self, peer: Peer, message: control.Define) -> list[Outgoing]:
        """Define a message, or refuse the definition."""
        new = message.name not in self._known
        refusal = self._define(peer, message)
        if refusal:
            self._faults.count("refused definition", refusal.text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        reports = self._presence.report(Change.DEFINED, peer, message.name) if new else []
        defined = control.Defined(name=message.name)
        return [Outgoing(identity=peer.identity, message=defined), *reports]

    def report(self, peer: Peer, message: control.Report, now: float) -> None:
        """Add the broadcasts and receptions that `peer` reports.

        Args:
            peer: The peer.
            message: Its report.
            now: The time [s].
        """
        for received in message.received:
            if received.name in self._known:
                self._known[received.name].traffic.received(received)
        for published in message.published:
            if published.name in peer.publishes:
                traffic = self._known[published.name].traffic
                traffic.published(peer.publisher, published, now)

    def _define(self, peer: Peer, message: control.Define) -> control.Refused | None:
        """Define a message; the refusal, if any."""
        known = self._known.get(message.name)
        if known is not None:
            text = _difference(peer, known, message)
            return _refused(message.name, text) if text else None
        error, text = "RedefinedMessageError", self._too_many(peer.principal)
        fingerprint = 0
        if not text:
            try:
                fingerprint = from_listing(message).fingerprint
            except HubError as problem:
                error, text = type(problem).__name__, str(problem)
        if text:
            return _refused(message.name, text, error)
        entry = replace(message, definer=peer.name)
        self._listed += len(message.format) + len(message.fields)
        self._defined_by[peer.principal] += 1
        self._known[message.name] = Definition(entry=entry, fingerprint=fingerprint)
        return None

    def _too_many(self, principal: Principal) -> str:
        """Why this key has no room for another definition; empty: it has."""
        if len(self._known) >= MAX_DEFINITIONS or self._listed > MAX_LISTED:
            return f"{len(self._known)} messages are defined, no more are taken"
        quota = quota_of(principal)
        if quota is not None and self._defined_by[principal] >= quota.definitions:
            return f"the key {principal.name!r} has defined {quota.definitions} messages, its limit"
        return ""


def _difference(peer: Peer, known: Definition, message: control.Define) -> str:
    """How a second definition differs from the first; empty: it does not."""
    entry = known.entry
    if message.format != entry.format:  # the same format may be spelt with other blanks
        try:
            same = compiled(message.format).fingerprint == known.fingerprint
        except HubError as problem:
            return str(problem)
        if not same:
            return (
                f"{message.name} is defined as {entry.format} by {entry.definer}; "
                f"{peer.name} wants {message.format}"
            )
    if message.plane != entry.plane:
        # Publisher and subscriber would never meet: each plane has sockets of its own.
        return (
            f"{message.name} travels on plane {entry.plane} as {entry.definer} defined it; "
            f"{peer.name} wants plane {message.plane}"
        )
    return ""


def _refused(name: str, text: str, error: str = "RedefinedMessageError") -> control.Refused:
    return control.Refused(subject=name, error=error, text=text)
