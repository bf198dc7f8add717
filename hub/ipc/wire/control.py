"""The control messages between clients and central, each with its number and name on the wire."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from typing import Annotated, NamedTuple, TypeVar

from hub.ipc.formats.wire_types import Counted, Fixed, Uint32, Uint64
from hub.values import dataclass


class Kind(NamedTuple):
    """A kind of control message: its name, and the dataclass of its content."""

    name: str
    message: type


KINDS: dict[int, Kind] = {}
"""By their numbers on the wire: 1, 2 and so on."""

_Message = TypeVar("_Message")


def _kind(number: int, name: str) -> Callable[[type[_Message]], type[_Message]]:
    """Give a dataclass its number and its name on the wire."""

    def register(message: type[_Message]) -> type[_Message]:
        KINDS[number] = Kind(name, message)
        return message

    return register


@_kind(1, "HELLO")
@dataclass(frozen=True, slots=True, kw_only=True)
class Hello:
    """Client to central: connect under this name.

    Attributes:
        name: The name.
        pid: Process id.
        machine: Number of the machine, to detect a shared clock; 0: unknown.
        sent: Time of sending on the client's clock [s].
        client: A random number of this client: it replaces an earlier connection with the same
            number; 0: none.
        neighbourhood: Number of all clients that reach each other directly; 0: only through
            central.
    """

    name: str
    pid: int
    machine: Uint64 = 0
    sent: float = 0.0
    client: Uint64 = 0
    neighbourhood: Uint64 = 0


@_kind(2, "WELCOME")
@dataclass(frozen=True, slots=True, kw_only=True)
class Welcome:
    """Central: the client is connected.

    Attributes:
        publisher: Number of this connection, for frame headers.
        epoch: Number of this run of central.
        machine: Number of central's machine.
        sent: From the HELLO.
        hub_time: Time of the answer on the hub's clock [s].
        near: Whether the client is a neighbour of all others in central's neighbourhood.
        ports: TCP ports of each plane in turn, in and out; 0: none.
        paths: ipc:// paths of the same; empty: none.
        ticket: What the client shows where it sends commands to central.
    """

    publisher: Uint32
    epoch: Uint64
    machine: Uint64
    sent: float
    hub_time: float
    near: bool
    ports: Annotated[tuple[int, ...], Fixed(6)]
    paths: Annotated[tuple[str, ...], Fixed(6)]
    ticket: str = ""


@_kind(3, "REFUSED")
@dataclass(frozen=True, slots=True, kw_only=True)
class Refused:
    """Central: a refusal.

    Attributes:
        subject: Name of the refused module or message.
        error: Its class in `hub.errors`.
        text: One sentence for people.
    """

    subject: str
    error: str
    text: str


@_kind(4, "DEFINE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Define:
    """Client: define a message; also an entry of a listing, with its traffic.

    Attributes:
        name: Message name.
        format: Format string.
        fields: Field names in the format's nesting.
        keep: "newest" or "all".
        plane: "state", "command" or "picture".
        rate_hz: Nominal rate [Hz].
        lifespan_s: Age beyond which a receiver drops it [s].
        definer: Name of its definer; only in a listing, like all attributes below.
        messages: Broadcasts of it, by its publishers' count.
        bytes: Bytes of their payloads.
        messages_per_s: Recent broadcasts of it [1/s].
        bytes_per_s: Bytes of their payloads [1/s].
        lost: Broadcasts that subscribers missed, by their sequence numbers.
        expired: Broadcasts that subscribers dropped because they were too old.
        oldest_s: Largest age at a subscriber in the last seconds [s].
        silent_s: Time since the last broadcast [s]; infinite: there was none.
        refused: Broadcasts that subscribers refused because a value was out of its range.
    """

    name: str
    format: str
    fields: str
    keep: str
    plane: str
    rate_hz: float
    lifespan_s: float
    definer: str = ""
    messages: Uint64 = 0
    bytes: Uint64 = 0
    messages_per_s: float = 0.0
    bytes_per_s: float = 0.0
    lost: Uint64 = 0
    expired: Uint64 = 0
    oldest_s: float = 0.0
    silent_s: float = math.inf
    refused: Uint64 = 0


@_kind(5, "DEFINED")
@dataclass(frozen=True, slots=True, kw_only=True)
class Defined:
    """Central: the message is defined."""

    name: str


@_kind(16, "ADVERTISE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Advertise:
    """Client: it will publish this message."""

    name: str


@_kind(17, "ADVERTISED")
@dataclass(frozen=True, slots=True, kw_only=True)
class Advertised:
    """Central: answer to ADVERTISE; whether a subscription by ZeroMQ is on its way."""

    name: str
    subscribed: bool


@_kind(18, "SUBSCRIBE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Subscribe:
    """Client: it has subscribed to this message; central answers with SUBSCRIBED.

    Attributes:
        name: Message name.
        token: Identity of this subscription; empty: no answer.
        inbox: Address for messages of neighbours; empty: none.
        in_ring: Whether they send descriptors of shared memory where they can.
        key: For the tickets of those that send there.
    """

    name: str
    token: str
    inbox: str = ""
    in_ring: bool = False
    key: str = ""


@_kind(29, "SUBSCRIBER")
@dataclass(frozen=True, slots=True, kw_only=True)
class Subscriber:
    """Central: a neighbour subscribes to a message of this client, which sends it directly.

    Attributes:
        name: Message name; empty: the end of all its subscriptions.
        subscriber: Number of its connection.
        inbox: Its address; empty: the end of the subscription.
        in_ring: Whether it wants descriptors of shared memory.
        token: Of its subscription, which READY confirms; empty: none.
        ticket: What the client shows when it connects to the inbox.
    """

    name: str
    subscriber: Uint32
    inbox: str = ""
    in_ring: bool = False
    token: str = ""
    ticket: str = ""


@_kind(19, "UNSUBSCRIBE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Unsubscribe:
    """Client: the end of a subscription."""

    name: str


@_kind(20, "READY")
@dataclass(frozen=True, slots=True, kw_only=True)
class Ready:
    """Client: the subscription of this token has arrived; later messages go there."""

    token: str


@_kind(21, "SUBSCRIBED")
@dataclass(frozen=True, slots=True, kw_only=True)
class Subscribed:
    """Central: the subscription of this token has reached all publishers of the message."""

    token: str


@_kind(6, "HANDLE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Handle:
    """Client: it answers queries of this name, or stops.

    Attributes:
        name: Message name.
        on: Whether it answers.
        address: Its address for direct queries on this machine; empty: none.
        key: For the tickets of those that ask there.
    """

    name: str
    on: bool = True
    address: str = ""
    key: str = ""


@_kind(7, "QUERY")
@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """A query, numbered by the client on its way to central and by central from there."""

    number: Uint32
    name: str
    timeout_s: float


@_kind(22, "LAST")
@dataclass(frozen=True, slots=True, kw_only=True)
class Last:
    """A query for the last published value, numbered as queries are."""

    number: Uint32
    name: str
    timeout_s: float


@_kind(8, "RESPONSE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """The answer to the query of this number."""

    number: Uint32


@_kind(9, "FAILURE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """The query of this number ends without an answer; `error` is a class of `hub.errors`."""

    number: Uint32
    error: str
    text: str


@_kind(10, "PING")
@dataclass(frozen=True, slots=True, kw_only=True)
class Ping:
    """Client: a heartbeat, with the last known epoch of central (0: none)."""

    epoch: Uint64
    sent: float = 0.0


@_kind(11, "PONG")
@dataclass(frozen=True, slots=True, kw_only=True)
class Pong:
    """Central: answer to PING; `sent` is from the PING, `hub_time` its time of answering [s]."""

    epoch: Uint64
    sent: float
    hub_time: float


@_kind(12, "STRANGER")
@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownPeer:
    """Central: the client is unknown and has to send HELLO."""


@_kind(13, "LIST")
@dataclass(frozen=True, slots=True, kw_only=True)
class List:
    """Client: ask for a LISTING."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedPeer:
    """A connected module or console.

    Attributes:
        name: Its unique name.
        pid: Its process id.
        publisher: Number of it in frame headers.
        role: What it may do: observe, operate or module.
        silent_s: Time since its last control message [s].
        handles: Names of the queries it answers, separated by spaces.
        publishes: Names of the messages it publishes.
        subscribes: Names of the messages it subscribes to.
    """

    name: str
    pid: int
    publisher: Uint32
    role: str
    silent_s: float
    handles: str
    publishes: str
    subscribes: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """Number of dropped messages, by reason."""

    reason: str
    count: Uint64


@_kind(14, "LISTING")
@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Central: its messages, peers and faults."""

    uptime_s: float
    level: str
    definitions: Annotated[tuple[Define, ...], Counted("definition_count", "uint")]
    peers: Annotated[tuple[ListedPeer, ...], Counted("peer_count", "uint")]
    dropped: Annotated[tuple[Count, ...], Counted("dropped_count", "uint")]


@_kind(15, "BYE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Bye:
    """Client: it disconnects."""


@_kind(23, "WATCH")
@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Client: ask for PRESENCE from now on.

    Attributes:
        module: Only the connections of a module of this name, the present one too; empty: all
        changes.
    """

    module: str = ""


class Change(enum.IntEnum):
    """Kind of a PRESENCE."""

    CONNECTED = 0
    DISCONNECTED = 1
    DEFINED = 2
    PUBLISHERS = 3
    SUBSCRIBERS = 4
    HANDLERS = 5


@_kind(24, "PRESENCE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Presence:
    """Central: a change.

    Attributes:
        change: Its kind.
        module: The module that changed.
        pid: Its process id.
        message: The message it is about; empty for a connection.
        count: Number of publishers, subscribers or handlers of the message now.
        publisher: Number of the module in frame headers.
    """

    change: Change
    module: str
    pid: int
    message: str = ""
    count: Uint32 = 0
    publisher: Uint32 = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """The receptions of one message since the subscriber's last report.

    Attributes:
        name: Message name.
        received: Messages handed on.
        lost: Messages that did not arrive, by the sequence numbers.
        expired: Messages that were too old.
        oldest_s: Largest age [s].
        refused: Messages with a value out of its range.
    """

    name: str
    received: Uint64
    lost: Uint64
    expired: Uint64
    oldest_s: float
    refused: Uint64 = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """The broadcasts of one message since the publisher's last report.

    Attributes:
        name: Message name.
        messages: Number of them.
        bytes: Of their payloads.
        over_s: Time since the last report [s].
        silent_s: Time since the last one [s].
    """

    name: str
    messages: Uint64
    bytes: Uint64
    over_s: float
    silent_s: float


@_kind(25, "REPORT")
@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Client: its receptions and broadcasts."""

    received: Annotated[tuple[Received, ...], Counted("received_count", "uint")]
    published: Annotated[tuple[Published, ...], Counted("published_count", "uint")]


@_kind(26, "CLOSE")
@dataclass(frozen=True, slots=True, kw_only=True)
class Close:
    """Client: disconnect the module of this name; central, to both: done, by `by`."""

    name: str
    by: str = ""


@_kind(27, "LOG_LEVEL")
@dataclass(frozen=True, slots=True, kw_only=True)
class LogLevel:
    """Client: set central's log level: debug, info, warning or error."""

    level: str


@_kind(28, "ROUTE")
@dataclass(frozen=True, slots=True, kw_only=True)
class DirectRoute:
    """Central: queries of this name may go to this address, with this ticket; empty: no longer."""

    name: str
    address: str
    ticket: str = ""
