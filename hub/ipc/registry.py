"""What central knows and decides: peers, definitions, handlers, queries under way. No sockets.

Each call says what happened and returns the control messages to send.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from hub.errors import HubError
from hub.ipc import control, frames
from hub.ipc.codec import compiled
from hub.ipc.codegen import Buffer
from hub.ipc.complaints import Complaints
from hub.ipc.description import from_listing

_logger = logging.getLogger(__name__)

MAX_PEERS = 512
MAX_DEFINITIONS = 4096
MAX_QUERIES = 4096
MAX_HANDLED = 64
MAX_LISTED = 1 << 20
"""All definitions' texts together [characters]; the list of them must fit into one frame."""
MAX_QUERY_S = 60.0
SILENCE_S = 2.0
"""A peer that has not been heard for this long is gone [s]."""


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


@dataclass(slots=True, kw_only=True)
class _Peer:
    identity: bytes
    descriptor: int
    name: str
    pid: int
    publisher: int
    heard: float
    handles: set[str] = field(default_factory=set)


@dataclass(slots=True, kw_only=True)
class _Definition:
    entry: control.Define
    fingerprint: int
    messages: int = 0
    bytes: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pending:
    asker: bytes
    number: int
    handler: bytes
    name: str
    deadline: float


class Registry:
    """The state of one central."""

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        complaints: Complaints,
        ports: Sequence[int],
        paths: Sequence[str],
    ) -> None:
        self.epoch = secrets.randbits(63) | 1
        self._clock = clock
        self._complaints = complaints
        self._ports = tuple(ports)
        self._paths = tuple(paths)
        self._peers: dict[bytes, _Peer] = {}
        self._names: dict[str, bytes] = {}
        self._definitions: dict[str, _Definition] = {}
        self._pending: dict[int, _Pending] = {}
        # Not from 1: a module that does not know yet that central was started again still sends
        # under its old number, which must not be another's new one.
        self._publishers = secrets.randbits(31)
        self._queries = 0
        self._actions: dict[type, Callable[[_Peer, Any, Buffer | None], list[Outgoing]]] = {
            control.Define: self._define,
            control.Handle: self._handle,
            control.Query: self._query,
            control.Response: self._respond,
            control.Failure: self._respond,
            control.List: self._list,
            control.Ping: self._ping,
            control.Bye: self._bye,
        }

    def connected(self) -> tuple[str, ...]:
        """Names of the peers; any thread may ask."""
        return tuple(self._names)

    def handle(
        self, identity: bytes, descriptor: int, message: Any, attached: Buffer | None
    ) -> list[Outgoing]:
        """A control message came."""
        if isinstance(message, control.Hello):
            return self._hello(identity, descriptor, message)
        peer = self._peers.get(identity)
        if peer is None:
            return [Outgoing(identity=identity, message=control.Stranger())]
        peer.heard = self._clock()
        action = self._actions.get(type(message))
        if action is None:
            name = type(message).__name__
            self._complaints.count("unexpected control message", f"{name} from {peer.name}")
            return []
        return action(peer, message, attached)

    def broadcast(self, frame: frames.Frame, size: int) -> None:
        """A broadcast of `size` bytes passed."""
        definition = self._definitions.get(frame.name)
        if definition is None:
            self._complaints.count("undefined message", f"{frame.name} is not defined")
        elif definition.fingerprint != frame.fingerprint:
            self._complaints.count("wrong format", f"{frame.name} came in another format")
        else:
            definition.messages += 1
            definition.bytes += size

    def disconnected(self, descriptor: int) -> list[Outgoing]:
        """A control connection ended."""
        gone = [peer for peer in self._peers.values() if peer.descriptor == descriptor >= 0]
        return [message for peer in gone for message in self._drop(peer, "its connection ended")]

    def unreachable(self, identity: bytes) -> list[Outgoing]:
        """A message could not be delivered."""
        peer = self._peers.get(identity)
        return self._drop(peer, "it cannot be reached") if peer else []

    def expire(self) -> list[Outgoing]:
        """Time has passed."""
        now = self._clock()
        silent = [peer for peer in self._peers.values() if now - peer.heard > SILENCE_S]
        outgoing = [message for peer in silent for message in self._drop(peer, "it is silent")]
        for number in [n for n, pending in self._pending.items() if pending.deadline < now]:
            del self._pending[number]  # the asker keeps its own time
        return outgoing

    def _hello(self, identity: bytes, descriptor: int, message: control.Hello) -> list[Outgoing]:
        known = self._peers.get(identity)
        if known is None:
            refusal = self._refusal(message.name)
            if refusal:
                self._complaints.count("refused connection", refusal.text)
                return [Outgoing(identity=identity, message=refusal)]
            self._publishers = self._publishers % 0xFFFF_FFFF + 1
            known = _Peer(
                identity=identity,
                descriptor=descriptor,
                name=message.name,
                pid=message.pid,
                publisher=self._publishers,
                heard=self._clock(),
            )
            self._peers[identity] = known
            self._names[message.name] = identity
            _logger.info("%s connected (pid %d)", message.name, message.pid)
        welcome = control.Welcome(
            publisher=known.publisher, epoch=self.epoch, ports=self._ports, paths=self._paths
        )
        return [Outgoing(identity=identity, message=welcome)]

    def _refusal(self, name: str) -> control.Refused | None:
        error = "CentralUnreachableError"
        if not 0 < len(name) <= 64 or not name.isprintable():
            text = "a module's name is 1 to 64 printable characters"
        elif len(self._peers) >= MAX_PEERS:
            text = f"{MAX_PEERS} modules are connected, no more are taken"
        elif name in self._names:
            pid = self._peers[self._names[name]].pid
            error = "NameTakenError"
            text = f"a module named {name!r} is connected already (pid {pid}); end it first"
        else:
            return None
        return control.Refused(subject=name, error=error, text=text)

    def _define(
        self, peer: _Peer, message: control.Define, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        refusal = self._definition_refusal(peer, message)
        if refusal:
            self._complaints.count("refused definition", refusal.text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        return [Outgoing(identity=peer.identity, message=control.Defined(name=message.name))]

    def _definition_refusal(self, peer: _Peer, message: control.Define) -> control.Refused | None:
        known = self._definitions.get(message.name)
        if known is not None:
            return self._redefinition_refusal(peer, known, message)
        error, text = "RedefinedMessageError", ""
        listed = sum(len(d.entry.format) + len(d.entry.fields) for d in self._definitions.values())
        if len(self._definitions) >= MAX_DEFINITIONS or listed > MAX_LISTED:
            text = f"{len(self._definitions)} messages are defined, no more are taken"
        else:
            try:
                fingerprint = from_listing(message).fingerprint
            except HubError as problem:
                error, text = type(problem).__name__, str(problem)
        if text:
            return control.Refused(subject=message.name, error=error, text=text)
        entry = replace(message, definer=peer.name, messages=0, bytes=0)
        self._definitions[message.name] = _Definition(entry=entry, fingerprint=fingerprint)
        return None

    def _redefinition_refusal(
        self, peer: _Peer, known: _Definition, message: control.Define
    ) -> control.Refused | None:
        """Why a message that is defined cannot be defined like this; None if it is the same."""
        entry = known.entry
        text = ""
        if message.format != entry.format:  # the same format may be spelt with other blanks
            try:
                same = compiled(message.format).fingerprint == known.fingerprint
            except HubError as problem:
                text = str(problem)
            else:
                if not same:
                    text = (
                        f"{message.name} is defined as {entry.format} by {entry.definer}; "
                        f"{peer.name} wants {message.format}"
                    )
        if not text and message.plane != entry.plane:
            # They would never meet: each plane has sockets of its own.
            text = (
                f"{message.name} travels on plane {entry.plane} as {entry.definer} defined it; "
                f"{peer.name} wants plane {message.plane}"
            )
        if not text:
            return None
        return control.Refused(subject=message.name, error="RedefinedMessageError", text=text)

    def _handle(
        self, peer: _Peer, message: control.Handle, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        if message.name in self._definitions and len(peer.handles) < MAX_HANDLED:
            peer.handles.add(message.name)
        else:
            reason = "it is not defined" if len(peer.handles) < MAX_HANDLED else "one too many"
            detail = f"{peer.name} wants to answer {message.name[:80]!r}: {reason}"
            self._complaints.count("refused handler", detail)
        return []

    def _query(
        self, peer: _Peer, message: control.Query, attached: Buffer | None
    ) -> list[Outgoing]:
        handler = next((p for p in self._peers.values() if message.name in p.handles), None)
        if attached is None or handler is None or len(self._pending) >= MAX_QUERIES:
            text = f"no connected module answers queries of {message.name[:80]}"
            if handler is not None:
                text = f"the query of {message.name[:80]} was malformed or one too many"
            return [self._failure(peer.identity, message.number, "NoHandlerError", text)]
        self._queries = self._queries % 0xFFFF_FFFF + 1
        wait = message.timeout_s if 0.0 < message.timeout_s < MAX_QUERY_S else MAX_QUERY_S
        self._pending[self._queries] = _Pending(
            asker=peer.identity,
            number=message.number,
            handler=handler.identity,
            name=message.name,
            deadline=self._clock() + wait,
        )
        forwarded = replace(message, number=self._queries)
        return [Outgoing(identity=handler.identity, message=forwarded, attached=attached)]

    def _respond(
        self,
        peer: _Peer,
        message: control.Response | control.Failure,
        attached: Buffer | None,
    ) -> list[Outgoing]:
        pending = self._pending.get(message.number)
        if pending is None or pending.handler != peer.identity:
            self._complaints.count("late answer", f"from {peer.name}, nobody waits for it")
            return []
        del self._pending[message.number]
        answer = replace(message, number=pending.number)
        return [Outgoing(identity=pending.asker, message=answer, attached=attached)]

    def _list(self, peer: _Peer, message: control.List, attached: Buffer | None) -> list[Outgoing]:
        del message, attached
        now = self._clock()
        definitions = tuple(
            replace(known.entry, messages=known.messages, bytes=known.bytes)
            for known in self._definitions.values()
        )
        peers = tuple(
            control.Peer(
                name=other.name,
                pid=other.pid,
                silent_s=now - other.heard,
                handles=" ".join(sorted(other.handles)),
            )
            for other in self._peers.values()
        )
        dropped = tuple(
            control.Count(reason=reason, count=count)
            for reason, count in self._complaints.counts.items()
        )
        listing = control.Listing(
            definition_count=len(definitions),
            definitions=definitions,
            peer_count=len(peers),
            peers=peers,
            dropped_count=len(dropped),
            dropped=dropped,
        )
        return [Outgoing(identity=peer.identity, message=listing)]

    def _ping(self, peer: _Peer, message: control.Ping, attached: Buffer | None) -> list[Outgoing]:
        del message, attached
        return [Outgoing(identity=peer.identity, message=control.Pong(epoch=self.epoch))]

    def _bye(self, peer: _Peer, message: control.Bye, attached: Buffer | None) -> list[Outgoing]:
        del message, attached
        return self._drop(peer, "it said goodbye")

    def _drop(self, peer: _Peer, why: str) -> list[Outgoing]:
        """Forget a peer; who waits for its answers is told at once."""
        _logger.info("%s is gone: %s", peer.name, why)
        self._peers.pop(peer.identity, None)
        if self._names.get(peer.name) == peer.identity:
            del self._names[peer.name]
        outgoing = []
        for number, pending in list(self._pending.items()):
            if pending.handler == peer.identity:
                text = f"{peer.name} went away before it answered {pending.name}"
                failure = self._failure(pending.asker, pending.number, "HandlerDiedError", text)
                outgoing.append(failure)
                del self._pending[number]
            elif pending.asker == peer.identity:
                del self._pending[number]
        return outgoing

    def _failure(self, identity: bytes, number: int, error: str, text: str) -> Outgoing:
        failure = control.Failure(number=number, error=error, text=text)
        return Outgoing(identity=identity, message=failure)
