"""The messages between the door and programs with panels; pure.

Texts are JSON objects with a name, `op`; binary messages are little-endian. They are those of the
protocol of Foxglove, whose other end is in `hub/robots/ros/foxglove/wire.py`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from typing import Any, Final, TypeGuard

from hub.recording.topics import RecordedTopic
from hub.ros.plain_json import json_values
from hub.values import dataclass

SUBPROTOCOLS: Final = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""What the door takes, the preferred first; the frames of both are alike."""
ENCODINGS: Final = ("json", "cdr")
"""How panels may write commands; Foxglove takes the first, and knows no ROS types for the other."""

Facts = Mapping[str, str | float | bool]

_DATA: Final = struct.Struct("<BIQ")
_OWN_DATA: Final = struct.Struct("<BI")
_DATA_OP: Final = 1
_WARNING: Final = 1
_STATUS: Final = "rune"
_MOST_NUMBER: Final = 1 << 32


@dataclass(frozen=True, slots=True, kw_only=True)
class PanelChannel:
    """A channel on which a program sends.

    Attributes:
        number: Its number, by the program.
        topic: Its topic.
        encoding: Of its messages.
        schema_name: Their type.
    """

    number: int
    topic: str
    encoding: str
    schema_name: str


def server_info(name: str, session: str, *, drive: bool) -> str:
    """What the door says first."""
    capabilities = ["parameters", "parametersSubscribe", *["clientPublish"] * drive]
    encodings = list(ENCODINGS) if drive else []
    return _text(
        "serverInfo", name=name, capabilities=capabilities, supportedEncodings=encodings,
        metadata={}, sessionId=session,
    )  # fmt: skip


def channels(topics: Mapping[int, RecordedTopic]) -> str:
    """Topics that are offered from now on, by number."""
    offered = [
        {
            "id": number,
            "topic": topic.name,
            "encoding": topic.encoding,
            "schemaName": topic.schema_name,
            "schema": topic.schema.decode("utf-8", "replace"),
            "schemaEncoding": topic.schema_encoding,
        }
        for number, topic in topics.items()
    ]
    return _text("advertise", channels=offered)


def gone_channel(number: int) -> str:
    """A topic is offered no more."""
    return _text("unadvertise", channelIds=[number])


def data(subscription: int, stamp: int, payload: bytes) -> bytes:
    """A message, measured at `stamp` [ns since the epoch]."""
    return _DATA.pack(_DATA_OP, subscription, stamp) + payload


def status(text: str) -> str:
    """A sentence in place of the one before; empty: take it away."""
    if not text:
        return _text("removeStatus", statusIds=[_STATUS])
    return _text("status", level=_WARNING, message=text, id=_STATUS)


def parameters(facts: Facts, question: object = None) -> str:
    """Facts as parameters, perhaps as the answer to a question."""
    values = [
        {"name": name, "value": value, **({"type": "float64"} if type(value) is float else {})}
        for name, value in facts.items()
    ]
    answers = {"id": question} if isinstance(question, str) else {}
    return _text("parameterValues", parameters=values, **answers)


def read_text(text: bytes) -> dict[str, Any]:
    """The values of a text of a program, by name.

    Raises:
        RosMessageError: It is no JSON, or too long.
    """
    return json_values(text)


def read_data(frame: bytes) -> tuple[int, bytes] | None:
    """Number of the channel and payload of a binary message; None: it is of another kind."""
    if len(frame) < _OWN_DATA.size or frame[0] != _DATA_OP:
        return None
    return _OWN_DATA.unpack_from(frame)[1], frame[_OWN_DATA.size :]


def subscriptions(values: Mapping[str, Any]) -> Iterable[tuple[int, int]]:
    """Each subscription and its channel, by their numbers."""
    for each in _objects(values, "subscriptions"):
        own, channel = each.get("id"), each.get("channelId")
        if _is_number(own) and _is_number(channel):
            yield own, channel


def numbers(values: Mapping[str, Any], key: str) -> Iterable[int]:
    """The numbers in a list."""
    found = values.get(key)
    return (each for each in found if _is_number(each)) if isinstance(found, list) else ()


def names(values: Mapping[str, Any], key: str) -> frozenset[str]:
    """The names in a list."""
    found = values.get(key)
    named = found if isinstance(found, list) else ()
    return frozenset(each for each in named if isinstance(each, str))


def panel_channels(values: Mapping[str, Any]) -> Iterable[PanelChannel]:
    """Channels on which a program sends from now on."""
    for each in _objects(values, "channels"):
        number = each.get("id")
        words = [each.get(key) for key in ("topic", "encoding", "schemaName")]
        named = [word for word in words if isinstance(word, str)]
        if _is_number(number) and len(named) == len(words):
            topic, encoding, schema_name = named
            yield PanelChannel(
                number=number, topic=topic, encoding=encoding, schema_name=schema_name
            )


def _objects(values: Mapping[str, Any], key: str) -> Iterable[dict[str, Any]]:
    found = values.get(key)
    return (each for each in found if isinstance(each, dict)) if isinstance(found, list) else ()


def _is_number(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < _MOST_NUMBER


def _text(op: str, **values: object) -> str:
    return json.dumps({"op": op, **values})
