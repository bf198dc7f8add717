"""What central knows and decides: peers, definitions, who does what with them. No sockets.

Each call says what happened and returns the control messages to send.
"""

from __future__ import annotations

import itertools
import logging
import math
import secrets
from collections.abc import Callable, Iterable
from typing import Any

from hub.errors import FrameError, NotAllowedError
from hub.ipc.broker import listing
from hub.ipc.broker.definitions import Definitions
from hub.ipc.broker.direct_routes import DirectRoutes
from hub.ipc.broker.direct_subscribers import DirectSubscribers
from hub.ipc.broker.peers import Caller, Numbers, Outgoing, Peer, PeersByMessage
from hub.ipc.broker.query_routing import QueryRouting
from hub.ipc.broker.quotas import counts_with, quota_of
from hub.ipc.broker.subscription_acks import SubscriptionAcks
from hub.ipc.definition import MAX_NAME_LENGTH
from hub.ipc.formats.codegen import Buffer
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.security import permissions
from hub.ipc.security.publish_rights import ROBOT_NAMES, reserved_text
from hub.ipc.transport.clock_sync import this_machine, this_neighbourhood
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control, frames
from hub.ipc.wire.control import Change

_logger = logging.getLogger(__name__)

MAX_PEERS = 512
MAX_NAMES = 4096
"""Messages one peer may publish, subscribe to or answer."""
MAX_TOKEN = 160
MAX_FOLLOWED = 16
"""Modules of whose connections one peer is told."""
LISTING_S = 0.25
"""A LISTING goes to all who have keys for so long before it is made anew [s]."""
SILENCE_S = 1.7
"""A peer that has not been heard for this long is gone [s]."""
LEVELS = {name: getattr(logging, name.upper()) for name in ("debug", "info", "warning", "error")}
"""Log levels by their names on the wire."""

_Action = Callable[[Peer, Any, Buffer | None], list[Outgoing]]


class Registry:
    """The state of one central."""

    def __init__(
        self,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
        reserved: frozenset[str] = frozenset(),
    ) -> None:
        """Start with nobody.

        Args:
            clock: Monotonic time [s].
            faults: Counts what is refused.
            reserved: Names of this robot's modules, beside those that every robot may have.
        """
        self._reserved = ROBOT_NAMES | reserved
        self.epoch = secrets.randbits(63) | 1
        self._clock = clock
        self._begun = clock()
        self._faults = faults
        self._peers: dict[bytes, Peer] = {}
        self._names: dict[str, Peer] = {}
        self._numbers = Numbers()
        self._definitions = Definitions()
        self._listing: control.Listing | None = None
        self._listing_made = -math.inf
        self._publishing, self._subscribing = PeersByMessage(), PeersByMessage()
        self._handling = PeersByMessage()
        self._confirmations = SubscriptionAcks()
        self._routes = QueryRouting(self._candidates, faults)
        self._shortcuts = DirectRoutes()
        self._neighbours = DirectSubscribers()
        self._actions: dict[type, _Action] = {
            control.Define: self._define,
            control.Advertise: self._advertise,
            control.Subscribe: self._subscribe,
            control.Unsubscribe: self._unsubscribe,
            control.Ready: self._ready,
            control.Handle: self._handle,
            control.Query: self._query,
            control.Last: self._query,
            control.Response: self._answer,
            control.Failure: self._answer,
            control.List: self._list,
            control.Watch: self._watch,
            control.Report: self._report,
            control.Close: self._close,
            control.LogLevel: self._log_level,
            control.Ping: self._ping,
            control.Bye: self._bye,
        }

    def connected(self) -> tuple[str, ...]:
        """Names of the peers; any thread may ask."""
        return tuple(self._names)

    def peer_of(self, publisher: int) -> Peer | None:
        """The peer of this number in frame headers, None if there is none; any thread may ask."""
        return self._numbers.of(publisher)

    def handle(self, caller: Caller, message: Any, attached: Buffer | None) -> list[Outgoing]:
        """A control message came."""
        if isinstance(message, control.Hello):
            return self._hello(caller, message)
        peer = self._peers.get(caller.identity)
        if peer is None:
            return [Outgoing(identity=caller.identity, message=control.UnknownPeer())]
        peer.heard = self._clock()
        action = self._actions.get(type(message))
        if action is None:
            name = type(message).__name__
            self._faults.count("unexpected control message", f"{name} from {peer.name}")
            return []
        try:
            permissions.check(peer.principal, peer.name, message, self._plane)
        except NotAllowedError as error:
            return self._not_allowed(peer, message, str(error))
        return action(peer, message, attached)

    def _plane(self, name: str) -> str | None:
        known = self._definitions.get(name)
        return known.entry.plane if known else None

    def _not_allowed(self, peer: Peer, message: Any, text: str) -> list[Outgoing]:
        self._faults.count("not allowed", f"{peer.name}: {text}")
        answer = permissions.refusal(message, text)
        return [Outgoing(identity=peer.identity, message=answer)] if answer else []

    def broadcast(self, frame: frames.Frame) -> bool:
        """A broadcast passed; whether nothing was wrong with it."""
        definition = self._definitions.get(frame.name)
        if definition is None:
            self._faults.count("undefined message", f"{frame.name} is not defined")
        elif definition.fingerprint != frame.fingerprint:
            self._faults.count("wrong format", f"{frame.name} came in another format")
        else:
            return True
        return False

    def descriptors_of(self, principal: Principal) -> list[int]:
        """The control connections of who has this key."""
        return [peer.descriptor for peer in self._peers.values() if peer.principal == principal]

    def disconnected(self, descriptor: int) -> list[Outgoing]:
        """A control connection ended."""
        gone = [peer for peer in self._peers.values() if peer.descriptor == descriptor >= 0]
        return [message for peer in gone for message in self._drop(peer, "its connection ended")]

    def has_connection(self, descriptor: int) -> bool:
        """Whether a control connection is that of a peer."""
        return any(peer.descriptor == descriptor for peer in self._peers.values())

    def unreachable(self, identity: bytes) -> list[Outgoing]:
        """A message could not be delivered."""
        peer = self._peers.get(identity)
        return self._drop(peer, "it cannot be reached") if peer else []

    def expire(self) -> list[Outgoing]:
        """Time has passed."""
        now = self._clock()
        silent = [peer for peer in self._peers.values() if now - peer.heard > SILENCE_S]
        outgoing = [message for peer in silent for message in self._drop(peer, "it is silent")]
        self._routes.expire(now)
        return outgoing

    def _hello(self, caller: Caller, message: control.Hello) -> list[Outgoing]:
        identity = caller.identity
        known = self._peers.get(identity)
        outgoing = []
        if known is None:
            earlier = self._names.get(message.name)
            if earlier is not None and earlier.client == message.client != 0:
                outgoing = self._drop(earlier, "it connects anew")
            refusal = self._refusal(message.name, caller.principal)
            if refusal:
                self._faults.count("refused connection", refusal.text)
                return [*outgoing, Outgoing(identity=identity, message=refusal)]
            known = Peer(
                identity=identity,
                descriptor=caller.descriptor,
                name=message.name,
                pid=message.pid,
                principal=caller.principal,
                client=message.client,
                near=caller.principal is LOCAL
                and message.neighbourhood == this_neighbourhood() != 0,
                publisher=self._numbers.new(),
                heard=self._clock(),
            )
            self._peers[identity] = self._names[message.name] = known
            self._numbers.give(known)
            _logger.info("%s connected (pid %d)", message.name, message.pid)
            outgoing += self._tell(Change.CONNECTED, known)
        welcome = control.Welcome(
            publisher=known.publisher,
            epoch=self.epoch,
            machine=this_machine(),
            sent=message.sent,
            hub_time=self._clock(),
            near=known.near,
            ports=caller.ports,
            paths=caller.paths,
        )
        return [Outgoing(identity=identity, message=welcome), *outgoing]

    def _refusal(self, name: str, principal: Principal) -> control.Refused | None:
        error = "CentralUnreachableError"
        if not 0 < len(name) <= 64 or not name.isprintable():
            text = "a module's name is 1 to 64 printable characters"
        elif name in self._reserved and principal.role is not Role.MODULE:
            error, text = NotAllowedError.__name__, reserved_text(name, principal)
        elif len(self._peers) >= MAX_PEERS:
            text = f"{MAX_PEERS} modules are connected, no more are taken"
        elif name in self._names:
            error = "NameTakenError"
            pid = self._names[name].pid
            text = f"a module named {name!r} is connected already (pid {pid}); end it first"
        else:
            text = self._too_many(principal)
        return control.Refused(subject=name, error=error, text=text) if text else None

    def _too_many(self, principal: Principal) -> str:
        """Why nobody else connects with this key now; empty if there is a place."""
        quota = quota_of(principal)
        if quota is None:
            return ""
        known = [peer.principal for peer in self._peers.values()]
        if known.count(principal) >= quota.connections:
            return (
                f"{quota.connections} clients are connected with the key {principal.name!r}, its "
                "limit; end one of them"
            )
        if sum(counts_with(each, principal.role) for each in known) >= quota.connections_together:
            return (
                f"{quota.connections_together} clients are connected with keys that may do no "
                f"more than {principal.role.value}, their limit; end one of them"
            )
        return ""

    def _define(
        self, peer: Peer, message: control.Define, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        new = message.name not in self._definitions
        refusal = self._definitions.define(peer, message)
        if refusal:
            self._faults.count("refused definition", refusal.text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        told = self._tell(Change.DEFINED, peer, message.name) if new else []
        defined = control.Defined(name=message.name)
        return [Outgoing(identity=peer.identity, message=defined), *told]

    def _advertise(
        self, peer: Peer, message: control.Advertise, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        if self._obstacle(peer, message.name, peer.publishes):
            return []
        name = message.name
        told = self._join(self._publishing, Change.PUBLISHERS, peer, name)
        direct = self._neighbours.advertise(peer, name)
        others = self._subscribing.count(name) - len(direct)
        answer = control.Advertised(name=name, subscribed=others > 0)
        return [*direct, Outgoing(identity=peer.identity, message=answer), *told]

    def _subscribe(
        self, peer: Peer, message: control.Subscribe, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        # Who may not define subscribes to what a module will define.
        text = self._obstacle(peer, message.name, peer.subscribes, undefined=True)
        if text:
            answer = permissions.refusal(message, text)
            return [Outgoing(identity=peer.identity, message=answer)]
        told = self._join(self._subscribing, Change.SUBSCRIBERS, peer, message.name)
        publishers = list(self._publishing.of(message.name))
        told += self._neighbours.subscribe(peer, message, publishers)
        if 0 < len(message.token) <= MAX_TOKEN:
            told += self._confirmations.begin(peer, message.token, publishers)
        return told

    def _unsubscribe(
        self, peer: Peer, message: control.Unsubscribe, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        name = message.name
        told = self._neighbours.unsubscribe(peer, name, self._publishing.of(name))
        return told + self._leave(self._subscribing, Change.SUBSCRIBERS, peer, name)

    def _ready(self, peer: Peer, message: control.Ready, attached: Buffer | None) -> list[Outgoing]:
        del attached
        return (
            self._confirmations.seen(peer, message.token) if len(message.token) <= MAX_TOKEN else []
        )

    def _handle(
        self, peer: Peer, message: control.Handle, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        if not message.on:
            closed = self._shortcuts.close(peer, message.name)
            return closed + self._leave(self._handling, Change.HANDLERS, peer, message.name)
        if self._obstacle(peer, message.name, peer.handles):
            return []
        told = self._shortcuts.close_all(self._handling.of(message.name), message.name)
        told += self._join(self._handling, Change.HANDLERS, peer, message.name)
        self._shortcuts.open(peer, message)
        return told

    def _obstacle(self, peer: Peer, name: str, names: set[str], *, undefined: bool = False) -> str:
        """Why `peer` may not do something with one more message; empty if it may."""
        known = name in self._definitions or (undefined and len(name) <= MAX_NAME_LENGTH)
        quota = quota_of(peer.principal)
        most = MAX_NAMES if quota is None else quota.names
        if known and (len(names) < most or name in names):
            return ""
        reason = f"it has {most} already, its limit" if known else "it is not defined"
        text = f"{peer.name} wants {name[:80]!r}: {reason}"
        self._faults.count("refused name", text)
        return text

    def _join(self, crowd: PeersByMessage, change: Change, peer: Peer, name: str) -> list[Outgoing]:
        self._own(crowd, peer).add(name)
        return self._tell(change, peer, name, crowd.count(name)) if crowd.add(name, peer) else []

    def _leave(
        self, crowd: PeersByMessage, change: Change, peer: Peer, name: str
    ) -> list[Outgoing]:
        self._own(crowd, peer).discard(name)
        return (
            self._tell(change, peer, name, crowd.count(name)) if crowd.discard(name, peer) else []
        )

    def _own(self, crowd: PeersByMessage, peer: Peer) -> set[str]:
        """The names that `peer` itself keeps of what it does."""
        if crowd is self._publishing:
            return peer.publishes
        return peer.subscribes if crowd is self._subscribing else peer.handles

    def _tell(self, change: Change, peer: Peer, name: str = "", count: int = 0) -> list[Outgoing]:
        """What those who watch are told."""
        message = listing.presence(change, peer, name, count)
        comes_or_goes = change in (Change.CONNECTED, Change.DISCONNECTED)
        if comes_or_goes or change is Change.DEFINED:
            self._listing = None  # the next listing shows this change
        return [
            Outgoing(identity=other.identity, message=message)
            for other in self._peers.values()
            if other.watches or (comes_or_goes and peer.name in other.follows)
        ]

    def _candidates(self, query: control.Query | control.Last) -> Iterable[Peer]:
        crowd = self._handling if isinstance(query, control.Query) else self._publishing
        return crowd.of(query.name)

    def _query(
        self, peer: Peer, message: control.Query | control.Last, attached: Buffer | None
    ) -> list[Outgoing]:
        if attached is None and isinstance(message, control.Query):
            text = f"the query of {message.name[:80]} came without its message"
            failure = control.Failure(number=message.number, error="NoHandlerError", text=text)
            return [Outgoing(identity=peer.identity, message=failure)]
        if attached is not None and self._is_forged(peer, attached):
            return self._not_allowed(peer, message, f"{peer.name} asks under a number not its own")
        asked = self._routes.ask(peer, message, attached, self._clock())
        handlers = list(self._handling.of(message.name))
        if isinstance(message, control.Query) and len(handlers) == 1:
            asked += self._shortcuts.offer(peer, handlers[0], message.name)
        return asked

    def _is_forged(self, peer: Peer, attached: Buffer) -> bool:
        """Whether a message has another number in its header than its sender has."""
        try:
            return frames.unpack(attached).publisher != peer.publisher
        except FrameError:
            return False  # whoever is asked says so

    def _answer(
        self, peer: Peer, message: control.Response | control.Failure, attached: Buffer | None
    ) -> list[Outgoing]:
        return self._routes.answer(peer, message, attached)

    def _watch(self, peer: Peer, message: control.Watch, attached: Buffer | None) -> list[Outgoing]:
        del attached
        if not message.module:
            peer.watches = True
        elif len(peer.follows) < MAX_FOLLOWED:
            peer.follows.add(message.module)
            known = self._names.get(message.module)
            if known is not None:
                told = listing.presence(Change.CONNECTED, known)
                return [Outgoing(identity=peer.identity, message=told)]
        return []

    def _report(
        self, peer: Peer, message: control.Report, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        for had in message.received:
            if had.name in self._definitions:
                self._definitions[had.name].traffic.received(had)
        for sent in message.published:
            if sent.name in peer.publishes:
                traffic = self._definitions[sent.name].traffic
                traffic.published(peer.publisher, sent, self._clock())
        return []

    def _close(self, peer: Peer, message: control.Close, attached: Buffer | None) -> list[Outgoing]:
        del attached
        other = self._names.get(message.name)
        if other is None:
            text = f"no module named {message.name[:80]!r} is connected"
            refusal = control.Refused(subject=message.name, error="UnknownModuleError", text=text)
            return [Outgoing(identity=peer.identity, message=refusal)]
        told = control.Close(name=other.name, by=peer.name)
        gone = [Outgoing(identity=each.identity, message=told) for each in {other: 0, peer: 0}]
        return [*gone, *self._drop(other, f"{peer.name} closed it")]

    def _log_level(
        self, peer: Peer, message: control.LogLevel, attached: Buffer | None
    ) -> list[Outgoing]:
        del attached
        if message.level in LEVELS:
            logging.getLogger("hub").setLevel(LEVELS[message.level])
            _logger.info("%s set the log level to %s", peer.name, message.level)
        return []

    def _list(self, peer: Peer, message: control.List, attached: Buffer | None) -> list[Outgoing]:
        del message, attached
        now = self._clock()
        old = peer.principal is LOCAL or now - self._listing_made >= LISTING_S
        if old or self._listing is None:
            self._listing, self._listing_made = self._listed_at(now), now
        return [Outgoing(identity=peer.identity, message=self._listing)]

    def _listed_at(self, now: float) -> control.Listing:
        definitions = tuple(
            listing.definition(known.entry, known.traffic, now) for known in self._definitions
        )
        peers = tuple(listing.peer(other, now) for other in self._peers.values())
        dropped = tuple(
            control.Count(reason=reason, count=count)
            for reason, count in tuple(self._faults.counts.items())
        )
        return control.Listing(
            uptime_s=now - self._begun,
            level=logging.getLevelName(_logger.getEffectiveLevel()).lower(),
            definition_count=len(definitions),
            definitions=definitions,
            peer_count=len(peers),
            peers=peers,
            dropped_count=len(dropped),
            dropped=dropped,
        )

    def _ping(self, peer: Peer, message: control.Ping, attached: Buffer | None) -> list[Outgoing]:
        del attached
        pong = control.Pong(epoch=self.epoch, sent=message.sent, hub_time=self._clock())
        return [Outgoing(identity=peer.identity, message=pong)]

    def _bye(self, peer: Peer, message: control.Bye, attached: Buffer | None) -> list[Outgoing]:
        del message, attached
        return self._drop(peer, "it said goodbye")

    def _drop(self, peer: Peer, why: str) -> list[Outgoing]:
        """Forget a peer; who waits for it is told at once."""
        _logger.info("%s is gone: %s", peer.name, why)
        self._peers.pop(peer.identity, None)
        self._numbers.forget(peer)
        if self._names.get(peer.name) is peer:
            del self._names[peer.name]
        outgoing = self._shortcuts.drop(peer, self._peers.values())
        wanted = (self._publishing.of(name) for name in peer.subscribes)
        outgoing += self._neighbours.drop(peer, itertools.chain.from_iterable(wanted))
        for crowd, change in (
            (self._publishing, Change.PUBLISHERS),
            (self._subscribing, Change.SUBSCRIBERS),
            (self._handling, Change.HANDLERS),
        ):
            for name in sorted(self._own(crowd, peer)):
                outgoing += self._leave(crowd, change, peer, name)
        outgoing += self._confirmations.drop(peer)
        outgoing += self._routes.drop(peer, self._clock())
        return outgoing + self._tell(Change.DISCONNECTED, peer)
