"""A node that other nodes of ROS 2 see over Zenoh: it publishes topics and takes velocities.

Zenoh calls back on its own threads. They note what nodes want under a lock, the newest only, so
that a flood fills no memory; one thread takes it.

Nodes of ROS 2 Humble have other keys than later ones. Once such a node is in the domain, topics
have both.
"""

from __future__ import annotations

import logging
import os
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import field, replace
from typing import Final

from hub.doors.panels.sentence_log import SentenceLog
from hub.doors.panels.wishes import (
    CMD_VEL,
    LARGEST_COMMAND,
    MOST_PANELS,
    Panel,
    PanelCommand,
    Wishes,
)
from hub.errors import RosMessageError
from hub.gcm.geometry import Twist, TwistStamped
from hub.ipc.transport.fault_counter import FaultCounter
from hub.recording.topics import RecordedTopic
from hub.ros.publisher_clocks import PublisherClocks
from hub.ros.rmw_zenoh import (
    GID_BYTES,
    HASH_OF_HUMBLE,
    Endpoint,
    Entity,
    EntityKind,
    MessageOrigin,
    QualityOfService,
    parse_token,
    tokens_of,
    type_in_key,
    unpack_origin,
)
from hub.ros.type_hashes import type_hash
from hub.values import dataclass
from hub.zenoh.session import ZenohDeclared, ZenohPublisher, ZenohSample, ZenohSession

_logger = logging.getLogger(__name__)

LATCHED: Final = frozenset({"/map", "/tf_static"})
"""Topics whose last message is kept for nodes that come later."""
MOST_TOKENS: Final = 10_000
"""Most subscribers and publishers of other nodes that are counted."""
FORGOTTEN_S: Final = 1.0
"""Silence of a publisher of velocities after which it is none [s]."""
_TWISTS: Final = (Twist.ros_type, TwistStamped.ros_type)


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeSettings:
    """Who the node is.

    Attributes:
        domain: Domain of ROS.
        namespace: Before the names of all topics: "/rover"; empty: none.
        drive: Whether other nodes may send velocities.
    """

    domain: int = 0
    namespace: str = ""
    drive: bool = False


class _Published:
    """A topic under the key of one hash of its type."""

    def __init__(self, token: ZenohDeclared, publisher: ZenohPublisher) -> None:
        self._token, self._publisher = token, publisher
        self._gid, self._sequence = os.urandom(GID_BYTES), 0

    def put(self, payload: bytes) -> None:
        self._sequence += 1
        origin = MessageOrigin(sequence=self._sequence, stamp_ns=time.time_ns(), gid=self._gid)
        self._publisher.put(payload, origin.pack())

    def undeclare(self) -> None:
        self._token.undeclare()
        self._publisher.undeclare()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Offered:
    """A topic that is published.

    Attributes:
        end: It, with the hash that ROS 2 has since Iron.
        keys: What publishes it: under that hash, and for nodes of Humble.
    """

    end: Endpoint
    keys: list[_Published] = field(default_factory=list)

    @property
    def kind(self) -> tuple[str, str]:
        """Its name and type."""
        return self.end.name, self.end.type


class RosNodeServer:
    """The node of a hub."""

    def __init__(
        self, session: ZenohSession, settings: NodeSettings, changed: Callable[[], None]
    ) -> None:
        """Announce it.

        Args:
            session: An open session for this alone.
            settings: Who it is.
            changed: Called by any thread when there are new wishes.
        """
        self._faults = FaultCounter(_logger, time.monotonic)
        self._sentences = SentenceLog(_logger, time.monotonic)
        self._session, self._settings, self._changed = session, settings, changed
        self._lock = threading.Lock()
        self._noted = False
        self._offered: dict[int, _Offered] = {}
        self._numbers = 0
        self._clocks = PublisherClocks()
        self._subscribers: dict[tuple[str, str], set[str]] = {}
        self._counted = 0
        self._fresh: set[tuple[str, str]] = set()
        self._sticks: dict[str, str] = {}
        self._commands: dict[Panel, PanelCommand] = {}
        self._panels: dict[Panel, float] = {}
        self._stick: tuple[Endpoint, ...] = ()
        self._stick_tokens: list[ZenohDeclared] = []
        self._humble = self._humble_came = False
        self._kept = [self._declare(EntityKind.NODE, None)]
        self._kept.append(session.watch_tokens(tokens_of(settings.domain), self._token_came))
        self._kept.append(session.watch_link(self._link_changed))
        if settings.drive:
            stick = f"{settings.namespace}{CMD_VEL}".strip("/")
            pattern = f"{settings.domain}/{stick}/*/*"
            self._kept.append(session.subscribe(pattern, self._stick_came))
            self._announce_stick()

    @property
    def refused(self) -> Counter[str]:
        """Number of commands and tokens that were not taken, by reason."""
        return self._faults.counts

    def take_wishes(self) -> Wishes:
        """What other nodes want now."""
        now = time.monotonic()
        self._meet_humble()
        if self._settings.drive:
            self._announce_stick()
        with self._lock:
            self._noted = False
            kinds = {number: it.kind for number, it in self._offered.items()}
            watched = {number for number, kind in kinds.items() if self._subscribers.get(kind)}
            fresh = {number for number in watched if kinds[number] in self._fresh}
            self._fresh.clear()
            self._forget_panels(now)
            wishes = Wishes(
                watched=frozenset(watched),
                fresh=frozenset(fresh),
                commands=tuple(self._commands.values()),
                panels=frozenset(self._panels),
            )
            self._commands.clear()
        return wishes

    def open(self, topic: RecordedTopic) -> int:
        """Offer a topic, where nodes of ROS 2 know its type; returns its number."""
        self._numbers += 1
        number, hashed = self._numbers, type_hash(topic.schema_name)
        if not hashed:
            return number
        latched = topic.name in LATCHED
        end = Endpoint(
            name=self._settings.namespace + topic.name,
            type=topic.schema_name,
            hash=hashed,
            quality=QualityOfService(latched=latched, depth=1 if latched else 10),
        )
        offered = _Offered(end=end)
        for each in self._with_humble(end):
            offered.keys.append(self._published(each))
        with self._lock:
            self._offered[number] = offered
        self._note()
        return number

    def close_topic(self, number: int) -> None:
        """Offer a topic no more."""
        with self._lock:
            found = self._offered.pop(number, None)
        for each in found.keys if found is not None else ():
            each.undeclare()

    def send(self, number: int, payload: bytes, stamp: int) -> None:
        """Publish a message of a topic; its own header has the time `stamp`, so it is not used."""
        del stamp
        found = self._offered.get(number)
        for each in found.keys if found is not None else ():
            each.put(payload)

    def set_parameters(self, values: dict[str, str | float | bool]) -> None:
        """Do nothing: nodes of ROS 2 ask for parameters by services, which this one has not."""

    def say(self, text: str) -> None:
        """Log a sentence for people."""
        self._sentences.note(text)

    def close(self) -> None:
        """Leave."""
        self._session.close()

    def _declare(self, kind: EntityKind, end: Endpoint | None) -> ZenohDeclared:
        self._numbers += kind is not EntityKind.NODE
        entity = Entity(
            session=self._session.zid,
            number=self._numbers,
            kind=kind,
            namespace=self._settings.namespace,
            node_name="rune",
            endpoint=end,
        )
        return self._session.declare_token(entity.token(self._settings.domain))

    def _published(self, end: Endpoint) -> _Published:
        latched = end.quality.latched
        return _Published(
            self._declare(EntityKind.PUBLISHER, end),
            self._session.publisher(end.key(self._settings.domain), latched=latched),
        )

    def _meet_humble(self) -> None:
        """Offer all topics to nodes of Humble too, once one is in the domain."""
        if self._humble or not self._humble_came:
            return
        self._humble = True
        _logger.info("a node of ROS 2 Humble is there: topics have its keys too")
        for each in self._offered.values():
            each.keys.append(self._published(_of_humble(each.end)))

    def _with_humble(self, end: Endpoint) -> tuple[Endpoint, ...]:
        return (end, _of_humble(end)) if self._humble else (end,)

    def _announce_stick(self) -> None:
        """Be a subscriber of velocities, with the type that other nodes publish."""
        with self._lock:
            published = sorted(set(self._sticks.values()))
        kind = published[0] if published else Twist.ros_type
        end = Endpoint(name=self._settings.namespace + CMD_VEL, type=kind, hash=type_hash(kind))
        wanted = self._with_humble(end)
        if wanted == self._stick:
            return
        for token in self._stick_tokens:
            token.undeclare()
        self._stick = wanted
        self._stick_tokens = [self._declare(EntityKind.SUBSCRIBER, each) for each in wanted]

    def _token_came(self, token: str, alive: bool) -> None:  # noqa: FBT001 - Zenoh calls it
        try:
            entity = parse_token(token)
        except RosMessageError as error:
            self._faults.count("no token", str(error))
            return
        if entity.session == self._session.zid or entity.endpoint is None:
            return
        end = entity.endpoint
        with self._lock:
            self._humble_came |= end.hash == HASH_OF_HUMBLE
            if entity.kind is EntityKind.SUBSCRIBER:
                self._note_subscriber((end.name, end.type), token, alive=alive)
            elif entity.kind is EntityKind.PUBLISHER:
                self._note_stick(end, token, alive=alive)
        self._note()

    def _note_subscriber(self, kind: tuple[str, str], token: str, *, alive: bool) -> None:
        known = self._subscribers.get(kind, set())
        if alive and token not in known:
            # The first subscriber of an own topic always counts: tokens that lie hide no node.
            own = any(it.kind == kind for it in self._offered.values())
            if self._counted >= MOST_TOKENS and (known or not own):
                self._faults.count("too many", f"at most {MOST_TOKENS} are counted")
                return
            self._counted += 1
            self._subscribers.setdefault(kind, known).add(token)
            self._fresh.add(kind)
        elif not alive and token in known:
            self._counted -= 1
            known.remove(token)
            if not known:
                del self._subscribers[kind]

    def _note_stick(self, end: Endpoint, token: str, *, alive: bool) -> None:
        if end.name != self._settings.namespace + CMD_VEL or end.type not in _TWISTS:
            return
        if not alive:
            self._sticks.pop(token, None)
        elif len(self._sticks) < MOST_TOKENS:
            self._sticks[token] = end.type

    def _stick_came(self, sample: ZenohSample) -> None:
        now = time.monotonic()
        try:
            origin, kind = unpack_origin(sample.attachment), type_in_key(sample.key)
        except RosMessageError as error:
            self._faults.count("no velocity", str(error))
            return
        if kind not in _TWISTS or len(sample.payload) > LARGEST_COMMAND:
            text = f"{len(sample.payload)} bytes of {kind[:80]} came to {CMD_VEL}"
            self._faults.count("no velocity", text)
            return
        panel = (
            int.from_bytes(origin.gid[:8], "little"),
            int.from_bytes(origin.gid[8:], "little"),
        )
        with self._lock:
            if panel not in self._panels and len(self._panels) >= MOST_PANELS:
                self._forget_panels(now)
            if panel not in self._panels and len(self._panels) >= MOST_PANELS:
                text = f"at most {MOST_PANELS} publish to {CMD_VEL} within {FORGOTTEN_S:g} s"
                self._faults.count("too many publishers", text)
                return
            age = self._clocks.age(origin, now)
            self._panels[panel] = now
            self._commands[panel] = PanelCommand(
                panel=panel, encoding="cdr", schema_name=kind, data=sample.payload, came=now - age
            )
        self._note()

    def _forget_panels(self, now: float) -> None:
        """Forget publishers that were silent, or all if no node announces one."""
        self._panels = {
            panel: came
            for panel, came in self._panels.items()
            if self._sticks and now - came < FORGOTTEN_S
        }

    def _link_changed(self, here: bool) -> None:  # noqa: FBT001 - Zenoh calls it
        _logger.log(
            logging.INFO if here else logging.WARNING,
            "the Zenoh router %s",
            "is there" if here else "has left; this door waits for it",
        )

    def _note(self) -> None:
        with self._lock:
            noted, self._noted = self._noted, True
        if not noted:
            self._changed()


def _of_humble(end: Endpoint) -> Endpoint:
    """A topic as nodes of ROS 2 Humble have it."""
    return replace(end, hash=HASH_OF_HUMBLE)
