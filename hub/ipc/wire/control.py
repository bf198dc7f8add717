"""What clients and central say to each other besides messages: administration, itself typed."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Annotated

from hub.ipc.formats.wire_types import Counted, Fixed, Uint32, Uint64


@dataclass(frozen=True, slots=True, kw_only=True)
class Hello:
    """Client: I want to connect under this name.

    Attributes:
        name: The name.
        pid: Process id.
        machine: Number of the machine, to tell whether central's clock is ours; 0: do not ask.
        sent: Time of sending on the client's clock [s].
        client: A random number of this client, which thereby takes the place of its own earlier
            connection; 0: none.
        neighbourhood: Number of all clients that can reach each other directly; 0: go through
            central.
    """

    name: str
    pid: int
    machine: Uint64 = 0
    sent: float = 0.0
    client: Uint64 = 0
    neighbourhood: Uint64 = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Welcome:
    """Central: you are connected.

    Attributes:
        publisher: Number of this connection, for frame headers.
        epoch: Tells one run of central from the next.
        machine: Number of central's machine.
        sent: From the HELLO.
        hub_time: Time of answering on the hub's clock [s].
        near: Whether the client is a neighbour of all others in central's neighbourhood.
        ports: TCP ports of each plane in turn, in and out; 0 where there is none.
        paths: ipc:// paths of the same; empty where there is none.
    """

    publisher: Uint32
    epoch: Uint64
    machine: Uint64
    sent: float
    hub_time: float
    near: bool
    ports: Annotated[tuple[int, ...], Fixed(6)]
    paths: Annotated[tuple[str, ...], Fixed(6)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Refused:
    """Central: no.

    Attributes:
        subject: Name of the module or message that was refused.
        error: Class of `hub.errors` it stands for.
        text: One sentence for people.
    """

    subject: str
    error: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Define:
    """Client: this is a message; also an entry of central's list, with what is known of it.

    Attributes:
        name: Message name.
        format: Format string.
        fields: Field names in the format's nesting.
        keep: "newest" or "all".
        plane: "state", "command" or "picture".
        rate_hz: Nominal rate [Hz].
        lifespan_s: Age beyond which a receiver drops it [s].
        definer: Who defined it; only in a listing, as all that follows.
        messages: Broadcasts of it, as its publishers count them.
        bytes: Bytes of their payloads.
        messages_per_s: Broadcasts of it lately [1/s].
        bytes_per_s: Bytes of their payloads lately [1/s].
        lost: Broadcasts that subscribers missed, by their sequence numbers.
        expired: Broadcasts that subscribers dropped because they were too old.
        oldest_s: Largest age at a subscriber in the last seconds [s].
        silent_s: Time since the last broadcast [s]; infinite if there was none.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Defined:
    """Central: the message is defined."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Advertise:
    """Client: I am going to publish this message."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Advertised:
    """Central: noted; whether anybody subscribes to it now whose subscription comes by ZeroMQ."""

    name: str
    subscribed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscribe:
    """Client: I have subscribed to this message; tell me when no publisher can miss me any more.

    Attributes:
        name: Message name.
        token: Tells this subscription from all others; empty: do not tell me.
        inbox: Where neighbours send it to; empty: nowhere.
        in_ring: Whether they send descriptors of shared memory where they can.
    """

    name: str
    token: str
    inbox: str = ""
    in_ring: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscriber:
    """Central: this neighbour subscribes to what you publish; send it there directly.

    Attributes:
        name: Message name; empty: all, if it does so no longer.
        subscriber: Number of its connection.
        inbox: Where; empty: it does so no longer.
        in_ring: Whether it wants descriptors of shared memory where there is some.
        token: Of its subscription, which READY confirms; empty: no need to.
    """

    name: str
    subscriber: Uint32
    inbox: str = ""
    in_ring: bool = False
    token: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unsubscribe:
    """Client: I do not want it any more."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Ready:
    """Client: the subscription of this token has reached me; what I publish goes there."""

    token: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscribed:
    """Central: the subscription of this token has reached everybody who publishes the message."""

    token: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Handle:
    """Client: I answer queries of this name, or no longer.

    Attributes:
        name: Message name.
        on: Whether.
        address: Where I can be asked directly by others on this machine; empty: nowhere.
    """

    name: str
    on: bool = True
    address: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """A query, numbered by the client on its way to central and by central from there."""

    number: Uint32
    name: str
    timeout_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Last:
    """A query for the last value that was published, numbered as queries are."""

    number: Uint32
    name: str
    timeout_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """The answer to the query of this number."""

    number: Uint32


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """The query of this number ends without an answer; `error` is a class of `hub.errors`."""

    number: Uint32
    error: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Ping:
    """Client: I live, and central was of this epoch when I last heard (0: never)."""

    epoch: Uint64
    sent: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Pong:
    """Central: so do I; `sent` is from the PING, `hub_time` mine at answering [s]."""

    epoch: Uint64
    sent: float
    hub_time: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownPeer:
    """Central: I do not know you; say hello."""


@dataclass(frozen=True, slots=True, kw_only=True)
class List:
    """Client: tell me all you know."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ListedPeer:
    """A connected module or console.

    Attributes:
        name: Its unique name.
        pid: Its process id.
        publisher: Number of it in frame headers.
        role: What it may do: observe, operate or module.
        silent_s: Time since it was heard [s].
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
    """How often central has dropped something, by reason."""

    reason: str
    count: Uint64


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Central: all I know."""

    uptime_s: float
    level: str
    definitions: Annotated[tuple[Define, ...], Counted("definition_count", "uint")]
    peers: Annotated[tuple[ListedPeer, ...], Counted("peer_count", "uint")]
    dropped: Annotated[tuple[Count, ...], Counted("dropped_count", "uint")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bye:
    """Client: I leave."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Client: tell me who comes and goes from now on.

    Attributes:
        module: Tell me only when a module of this name connects, or is connected already, and when
            its connection ends; empty: tell me all.
    """

    module: str = ""


class Change(enum.IntEnum):
    """What a PRESENCE tells."""

    CONNECTED = 0
    DISCONNECTED = 1
    DEFINED = 2
    PUBLISHERS = 3
    SUBSCRIBERS = 4
    HANDLERS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Presence:
    """Central: something changed.

    Attributes:
        change: What.
        module: Whose doing it was.
        pid: Its process id.
        message: The message it is about; empty for a connection.
        count: How many publishers, subscribers or handlers the message has now.
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
    """What a subscriber has had of one message since it last told.

    Attributes:
        name: Message name.
        received: Messages handed on.
        lost: Messages that did not come, by the sequence numbers.
        expired: Messages that came too old.
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
    """What a publisher has broadcast of one message since it last told.

    Attributes:
        name: Message name.
        messages: How many.
        bytes: Of their payloads.
        over_s: In what time [s].
        silent_s: Time since the last one [s].
    """

    name: str
    messages: Uint64
    bytes: Uint64
    over_s: float
    silent_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Client: this is what came to me, and what I have published."""

    received: Annotated[tuple[Received, ...], Counted("received_count", "uint")]
    published: Annotated[tuple[Published, ...], Counted("published_count", "uint")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Close:
    """Client: disconnect the module of this name; central, to both: it is, and by whom."""

    name: str
    by: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class LogLevel:
    """Client: log from this level on: debug, info, warning or error."""

    level: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DirectRoute:
    """Central: queries of this name may go to this address directly; empty: no longer."""

    name: str
    address: str
