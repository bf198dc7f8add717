"""What clients and central say to each other besides messages: administration, itself typed.

A control message is one ZeroMQ frame: "RUNE", protocol version, kind, two zero bytes, and a CDR
payload in the kind's format. QUERY and RESPONSE are followed by a second frame with the message.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, TypeVar

from hub.errors import FrameError
from hub.ipc import frames
from hub.ipc.codegen import Buffer
from hub.ipc.definition import MessageDefinition

T = TypeVar("T")

_PREAMBLE = struct.Struct("<4sBBH")
_MAGIC = b"RUNE"


@dataclass(frozen=True, slots=True, kw_only=True)
class Hello:
    """Client: I want to connect under this name."""

    name: str
    pid: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Welcome:
    """Central: you are connected.

    Attributes:
        publisher: Number of this connection, for frame headers.
        epoch: Tells one run of central from the next.
        ports: TCP ports of state in, state out, command in, command out; 0 where there is none.
        paths: ipc:// paths of the same; empty where there is none.
    """

    publisher: int
    epoch: int
    ports: tuple[int, ...]
    paths: tuple[str, ...]


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
    """Client: this is a message; also an entry of central's list, with what it has counted."""

    name: str
    format: str
    fields: str
    keep: str
    plane: str
    rate_hz: float
    lifespan_s: float
    definer: str = ""
    messages: int = 0
    bytes: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Defined:
    """Central: the message is defined."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Handle:
    """Client: I answer queries of this name."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    """A query, numbered by the client on its way to central and by central from there."""

    number: int
    name: str
    timeout_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """The answer to the query of this number."""

    number: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Failure:
    """The query of this number ends without an answer; `error` is a class of `hub.errors`."""

    number: int
    error: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Ping:
    """Client: I live, and central was of this epoch when I last heard (0: never)."""

    epoch: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Pong:
    """Central: so do I."""

    epoch: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Stranger:
    """Central: I do not know you; say hello."""


@dataclass(frozen=True, slots=True, kw_only=True)
class List:
    """Client: tell me all you know."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Peer:
    """A connected module or console.

    Attributes:
        name: Its unique name.
        pid: Its process id.
        silent_s: Time since it was heard [s].
        handles: Names of the queries it answers, separated by spaces.
    """

    name: str
    pid: int
    silent_s: float
    handles: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Count:
    """How often central has dropped something, by reason."""

    reason: str
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Listing:
    """Central: all I know."""

    definition_count: int
    definitions: tuple[Define, ...]
    peer_count: int
    peers: tuple[Peer, ...]
    dropped_count: int
    dropped: tuple[Count, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bye:
    """Client: I leave."""


_DEFINE = "{string,string,string,string,string,double,double,string,ulong,ulong}"
_PEER = "{string,int,double,string}"


def _kind(name: str, format_text: str, kind: type[T]) -> MessageDefinition[T]:
    return MessageDefinition(name=name, format=format_text, type=kind)


KINDS: tuple[MessageDefinition[Any], ...] = (
    _kind("HELLO", "{string,int}", Hello),
    _kind("WELCOME", "{uint,ulong,[int:4],[string:4]}", Welcome),
    _kind("REFUSED", "{string,string,string}", Refused),
    _kind("DEFINE", _DEFINE, Define),
    _kind("DEFINED", "{string}", Defined),
    _kind("HANDLE", "{string}", Handle),
    _kind("QUERY", "{uint,string,double}", Query),
    _kind("RESPONSE", "{uint}", Response),
    _kind("FAILURE", "{uint,string,string}", Failure),
    _kind("PING", "{ulong}", Ping),
    _kind("PONG", "{ulong}", Pong),
    _kind("STRANGER", "{}", Stranger),
    _kind("LIST", "{}", List),
    _kind("LISTING", f"{{uint,<{_DEFINE}:1>,uint,<{_PEER}:3>,uint,<{{string,ulong}}:5>}}", Listing),
    _kind("BYE", "{}", Bye),
)
"""The kinds; a kind's number on the wire is its place here, counted from 1."""

_NUMBER = {definition.type: number for number, definition in enumerate(KINDS, 1)}


def pack(message: Any) -> bytes:
    """The frame of a control message."""
    number = _NUMBER[type(message)]
    preamble = _PREAMBLE.pack(_MAGIC, frames.VERSION, number, 0)
    return b"".join((preamble, *KINDS[number - 1].encode(message)))


def unpack(raw: Buffer) -> Any:
    """The control message in a frame.

    Raises:
        FrameError: The bytes are no control message of this protocol version.
        CodecError: The payload does not fit its kind.
    """
    view = memoryview(raw)
    if len(view) < _PREAMBLE.size:
        text = f"a control frame of {len(view)} bytes has no whole preamble"
        raise FrameError(text)
    magic, version, number, _ = _PREAMBLE.unpack_from(view)
    if magic != _MAGIC:
        text = "a control frame does not start with RUNE"
        raise FrameError(text)
    if version != frames.VERSION:
        text = f"a control frame has protocol version {version}, this is {frames.VERSION}"
        raise FrameError(text)
    if not 1 <= number <= len(KINDS):
        text = f"a control frame has the unknown kind {number}"
        raise FrameError(text)
    return KINDS[number - 1].decode(view[_PREAMBLE.size :])
