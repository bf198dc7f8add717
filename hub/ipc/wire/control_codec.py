"""The wire of control messages.

A control message is one ZeroMQ frame: "RUNE", protocol version, kind, two zero bytes, and a CDR
payload in the kind's format. QUERY and RESPONSE are followed by a second frame with the message.
"""

from __future__ import annotations

import struct
from typing import Any, TypeVar

from hub.errors import FrameError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.codegen import Buffer
from hub.ipc.wire import control, frames

T = TypeVar("T")

_PREAMBLE = struct.Struct("<4sBBH")
_MAGIC = b"RUNE"

_DEFINE = (
    "{string,string,string,string,string,double,double,"
    "string,ulong,ulong,double,double,ulong,ulong,double,double,ulong}"
)
_PEER = "{string,int,uint,string,double,string,string,string}"
_CHANGE = "{enum " + ",".join(change.name for change in control.Change) + "}"


def _kind(name: str, format_text: str, kind: type[T]) -> MessageDefinition[T]:
    return MessageDefinition(name=name, format=format_text, type=kind)


KINDS: tuple[MessageDefinition[Any], ...] = (
    _kind("HELLO", "{string,int,ulong,double,ulong,ulong}", control.Hello),
    _kind(
        "WELCOME", "{uint,ulong,ulong,double,double,boolean,[int:6],[string:6]}", control.Welcome
    ),
    _kind("REFUSED", "{string,string,string}", control.Refused),
    _kind("DEFINE", _DEFINE, control.Define),
    _kind("DEFINED", "{string}", control.Defined),
    _kind("HANDLE", "{string,boolean,string}", control.Handle),
    _kind("QUERY", "{uint,string,double}", control.Query),
    _kind("RESPONSE", "{uint}", control.Response),
    _kind("FAILURE", "{uint,string,string}", control.Failure),
    _kind("PING", "{ulong,double}", control.Ping),
    _kind("PONG", "{ulong,double,double}", control.Pong),
    _kind("STRANGER", "{}", control.UnknownPeer),
    _kind("LIST", "{}", control.List),
    _kind(
        "LISTING",
        f"{{double,string,uint,<{_DEFINE}:3>,uint,<{_PEER}:5>,uint,<{{string,ulong}}:7>}}",
        control.Listing,
    ),
    _kind("BYE", "{}", control.Bye),
    _kind("ADVERTISE", "{string}", control.Advertise),
    _kind("ADVERTISED", "{string,boolean}", control.Advertised),
    _kind("SUBSCRIBE", "{string,string,string,boolean}", control.Subscribe),
    _kind("UNSUBSCRIBE", "{string}", control.Unsubscribe),
    _kind("READY", "{string}", control.Ready),
    _kind("SUBSCRIBED", "{string}", control.Subscribed),
    _kind("LAST", "{uint,string,double}", control.Last),
    _kind("WATCH", "{string}", control.Watch),
    _kind("PRESENCE", f"{{{_CHANGE},string,int,string,uint,uint}}", control.Presence),
    _kind(
        "REPORT",
        "{uint,<{string,ulong,ulong,ulong,double,ulong}:1>,"
        "uint,<{string,ulong,ulong,double,double}:3>}",
        control.Report,
    ),
    _kind("CLOSE", "{string,string}", control.Close),
    _kind("LOG_LEVEL", "{string}", control.LogLevel),
    _kind("ROUTE", "{string,string}", control.DirectRoute),
    _kind("SUBSCRIBER", "{string,uint,string,boolean,string}", control.Subscriber),
)
"""The kinds; a kind's number on the wire is its place here, counted from 1."""

_NUMBER = {definition.type: number for number, definition in enumerate(KINDS, 1)}


def pack(message: Any) -> bytes:
    """The frame of a control message."""
    number = _NUMBER[type(message)]
    preamble = _PREAMBLE.pack(_MAGIC, frames.VERSION, number, 0)
    return b"".join((preamble, *KINDS[number - 1].encode(message)))


def peek(raw: Buffer) -> type | None:
    """What kind of control message a frame says it is, by its preamble alone; None if none."""
    view = memoryview(raw)
    number = view[5] if len(view) >= _PREAMBLE.size else 0
    return KINDS[number - 1].type if 1 <= number <= len(KINDS) else None


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
