"""The messages between a bridge for Foxglove and its client; pure.

Texts are JSON objects with a name, `op`. Binary messages are little-endian; their first byte says
what they are:

| to | first byte | rest |
| --- | --- | --- |
| client | 1 data | u32 subscription, u64 time [ns], payload |
| client | 3 answer of a service | u32 service, u32 call, u32 length, encoding, payload |
| client | 4 file | u32 request, u8 fault or 0, u32 length, reason of the fault, file |
| bridge | 1 data | u32 channel, payload |
| bridge | 2 request of a service | u32 service, u32 call, u32 length, encoding, payload |

What is unknown is left out: other names, other first bytes, other fields.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, TypeGuard

from hub.errors import RosMessageError
from hub.plain_text import is_plain, plain
from hub.robots.ros.foxglove.bridge_events import (
    BridgeAnswer,
    BridgeChannels,
    BridgeData,
    BridgeEvent,
    BridgeGraph,
    BridgeInfo,
    BridgeParameters,
    BridgeServices,
    BridgeStatus,
    GoneChannels,
    GoneServices,
    GoneStatuses,
)
from hub.robots.ros.line import Payload, RosService, RosTopic
from hub.ros.panel_door_name import is_panel_door
from hub.ros.plain_json import json_values
from hub.ros.schema import full_name

SUBPROTOCOLS: Final = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""What a client offers: newer bridges take only the first, older ones only the second."""
PUBLISHING: Final = "clientPublish"
GRAPH: Final = "connectionGraph"
SIMULATED_TIME: Final = "time"
PARAMETERS: Final = "parameters"
FILES: Final = "assets"
"""Capabilities of bridges."""
ENCODINGS: Final = ("cdr", "ros1")
"""Encodings of messages that a line sends, the preferred first."""
MOST_SCHEMA: Final = 1 << 18
"""Longest definition of a message [characters]."""

_MOST_NAME: Final = 255
_MOST_VALUES: Final = 200_000
"""Most values of a text, about; reading them keeps the driver for some 0.2 s."""
_MOST_TEXT: Final = 300
"""Longest sentence of a bridge that is shown; the rest is cut off."""
_ERROR: Final = 2
"""Level of sentences that are errors."""
_MOST_NODES: Final = 100
"""Most publishers or subscribers of a topic that are kept."""

_DATA = struct.Struct("<BIQ")
_OWN_DATA = struct.Struct("<BI")
_SERVICE = struct.Struct("<BIII")
_FILE = struct.Struct("<BIBI")
_DATA_OP: Final = 1
_REQUEST_OP: Final = 2
_ANSWER_OP: Final = 3
_FILE_OP: Final = 4
_NO_REASON: Final = "the robot gives no reason"

Refuse = Callable[[str], None]


def read_binary(data: Payload) -> BridgeEvent | None:
    """A binary message of a bridge; None: it is of a kind that is not needed.

    Raises:
        RosMessageError: It makes no sense.
    """
    view = memoryview(data)
    op = view[0] if view else 0
    if op == _DATA_OP and len(view) >= _DATA.size:
        _, subscription, time_ns = _DATA.unpack_from(view)
        return BridgeData(
            subscription=subscription, time_ns=time_ns, payload=view[_DATA.size :].toreadonly()
        )
    if op == _ANSWER_OP and len(view) >= _SERVICE.size:
        _, _, call, length = _SERVICE.unpack_from(view)
        if length <= len(view) - _SERVICE.size:
            return BridgeAnswer(call=call, payload=view[_SERVICE.size + length :].toreadonly())
    if op == _FILE_OP and len(view) >= _FILE.size:
        _, call, fault, length = _FILE.unpack_from(view)
        begin = _FILE.size + length
        if not fault and begin <= len(view):
            return BridgeAnswer(call=call, payload=view[begin:].toreadonly())
        why = _cut(bytes(view[_FILE.size : begin]).decode(errors="replace"))
        return BridgeAnswer(call=call, payload=None, why=why or _NO_REASON)
    if op in (0, _DATA_OP, _ANSWER_OP, _FILE_OP):
        text = f"a binary message of {len(view)} bytes is too short for its kind, {op}"
        raise RosMessageError(text)
    return None


def read_text(data: Payload, refuse: Refuse) -> BridgeEvent | None:
    """A text of a bridge; None: it is of a kind that is not needed.

    Args:
        data: JSON.
        refuse: Takes the reason for each part that is left out, since it makes no sense.

    Raises:
        RosMessageError: Nothing of it makes sense.
    """
    text = bytes(data)
    if text.count(b",") > _MOST_VALUES:
        refusal = f"a text has more than {_MOST_VALUES} values"
        raise RosMessageError(refusal)
    values = json_values(text)
    op = values.get("op")
    if not isinstance(op, str):
        refusal = "a text has no name, `op`"
        raise RosMessageError(refusal)
    read = _READERS.get(op)
    return read(values, refuse) if read is not None else None


def _info(values: dict[str, Any], _: Refuse) -> BridgeInfo:
    metadata = values.get("metadata")
    distribution = metadata.get("ROS_DISTRO", "") if isinstance(metadata, dict) else ""
    return BridgeInfo(
        capabilities=frozenset(_names(values.get("capabilities"))),
        encodings=_names(values.get("supportedEncodings")),
        distribution=distribution if _is_name(distribution) else "",
        session=_cut(values.get("sessionId")),
        of_hub=is_panel_door(values.get("name")),
    )


def _channels(values: dict[str, Any], refuse: Refuse) -> BridgeChannels:
    found: dict[int, RosTopic] = {}
    for each in _objects(values, "channels", refuse):
        encoding, schema = each.get("encoding"), each.get("schema") or ""
        schema_encoding = each.get("schemaEncoding") or ""
        name, kind = each.get("topic"), each.get("schemaName")
        number = _id(each.get("id"), 63)
        if not (_is_name(name) and _is_name(kind, least=0) and _is_name(encoding, least=0)):
            refuse("a channel has no topic, type or encoding in words")
        elif not (isinstance(schema, str) and len(schema) <= MOST_SCHEMA):
            refuse(f"the definition of {name} is no text, or is longer than {MOST_SCHEMA}")
        elif number is None or not _is_name(schema_encoding, least=0):
            refuse(f"the channel of {name} has no number, or its definition no encoding")
        else:
            found[number] = RosTopic(
                name=name,
                schema_name=full_name(kind),
                encoding=encoding,
                schema_encoding=schema_encoding or _usual_schema(encoding, schema),
                schema=schema.encode("utf-8", "replace"),
            )
    return BridgeChannels(channels=found)


def _usual_schema(encoding: str, schema: str) -> str:
    """The encoding of a definition that a bridge does not name."""
    if encoding == "ros1":
        return "ros1msg"
    return "ros2msg" if encoding == "cdr" and schema else ""


def _gone_channels(values: dict[str, Any], refuse: Refuse) -> GoneChannels:
    return GoneChannels(ids=_ids(values, "channelIds", refuse))


def _services(values: dict[str, Any], refuse: Refuse) -> BridgeServices:
    found: dict[int, RosService] = {}
    for each in _objects(values, "services", refuse):
        name, kind, request = each.get("name"), each.get("type"), each.get("request")
        number = _id(each.get("id"), 32)
        if number is None or not (_is_name(name) and _is_name(kind, least=0)):
            refuse("a service has no number, or no name or type in words")
            continue
        encoding = request.get("encoding") if isinstance(request, dict) else ""
        package, _, rest = kind.partition("/")
        found[number] = RosService(
            name=name,
            type=f"{package}/srv/{rest}" if rest and "/" not in rest else kind,
            encoding=encoding if _is_name(encoding) else "",
        )
    return BridgeServices(services=found)


def _gone_services(values: dict[str, Any], refuse: Refuse) -> GoneServices:
    return GoneServices(ids=_ids(values, "serviceIds", refuse))


def _status(values: dict[str, Any], _: Refuse) -> BridgeStatus:
    return BridgeStatus(
        text=_cut(values.get("message")),
        id=_cut(values.get("id")),
        is_error=values.get("level") == _ERROR,
    )


def _gone_statuses(values: dict[str, Any], _: Refuse) -> GoneStatuses:
    return GoneStatuses(ids=_names(values.get("statusIds")))


def _parameters(values: dict[str, Any], refuse: Refuse) -> BridgeParameters:
    found: dict[str, object] = {}
    for each in _objects(values, "parameters", refuse):
        name, value = each.get("name"), each.get("value")
        if not _is_name(name):
            refuse("a parameter has no name in words")
        elif value is not None:  # None: it is not set
            found[name] = float(value) if each.get("type") == "float64" and _whole(value) else value
    return BridgeParameters(values=found, question=_cut(values.get("id")))


def _graph(values: dict[str, Any], refuse: Refuse) -> BridgeGraph:
    publishers, subscribers = (
        {
            each["name"]: _names(each.get(ids))[:_MOST_NODES]
            for each in _objects(values, topics, refuse)
            if _is_name(each.get("name"))
        }
        for topics, ids in (
            ("publishedTopics", "publisherIds"),
            ("subscribedTopics", "subscriberIds"),
        )
    )
    return BridgeGraph(
        publishers=publishers, subscribers=subscribers, gone=_names(values.get("removedTopics"))
    )


def _service_failure(values: dict[str, Any], _: Refuse) -> BridgeAnswer:
    call = _id(values.get("callId"), 32)
    if call is None:
        text = "the failure of a service has no number"
        raise RosMessageError(text)
    why = _cut(values.get("message")) or _NO_REASON
    return BridgeAnswer(call=call, payload=None, why=why)


_READERS: Final[Mapping[str, Callable[[dict[str, Any], Refuse], BridgeEvent]]] = {
    "serverInfo": _info,
    "advertise": _channels,
    "unadvertise": _gone_channels,
    "advertiseServices": _services,
    "unadvertiseServices": _gone_services,
    "status": _status,
    "removeStatus": _gone_statuses,
    "parameterValues": _parameters,
    "connectionGraphUpdate": _graph,
    "serviceCallFailure": _service_failure,
}


def _is_name(value: object, *, least: int = 1) -> TypeGuard[str]:
    return isinstance(value, str) and least <= len(value) <= _MOST_NAME and is_plain(value)


def _whole(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool)


def _id(value: object, bits: int) -> int | None:
    return value if _whole(value) and 0 <= value < 1 << bits else None


def _cut(value: object) -> str:
    """A text of a bridge as it can be shown; empty: it is none."""
    return plain(value[:_MOST_TEXT]) if isinstance(value, str) else ""


def _names(value: object) -> tuple[str, ...]:
    return tuple(each for each in value if _is_name(each)) if isinstance(value, list) else ()


def _ids(values: dict[str, Any], key: str, refuse: Refuse) -> tuple[int, ...]:
    found = values.get(key)
    numbers = [_id(each, 63) for each in found] if isinstance(found, list) else [None]
    if None in numbers:
        refuse(f"a text has numbers in {key!r} that are none")
    return tuple(each for each in numbers if each is not None)


def _objects(values: dict[str, Any], key: str, refuse: Refuse) -> Iterable[dict[str, Any]]:
    found = values.get(key) or []
    if not isinstance(found, list):
        refuse(f"a text has no list in {key!r}")
        return
    for each in found:
        if isinstance(each, dict):
            yield each
        else:
            refuse(f"a text has something else than objects in {key!r}")


def subscribe(channels: Mapping[int, int]) -> bytes:
    """Subscribe to channels: the number of the channel by that of the subscription."""
    wanted = [{"id": own, "channelId": channel} for own, channel in channels.items()]
    return _text("subscribe", subscriptions=wanted)


def unsubscribe(subscription: int) -> bytes:
    """End a subscription."""
    return _text("unsubscribe", subscriptionIds=[subscription])


def advertise(number: int, topic: str, type_name: str, encoding: str) -> bytes:
    """Publish a topic from now on.

    Args:
        number: The number of the own channel.
        topic: Its name.
        type_name: Its type as ROS 2 writes it.
        encoding: The encoding of its messages.
    """
    name = type_name.replace("/msg/", "/") if encoding == "ros1" else type_name
    channel = {"id": number, "topic": topic, "encoding": encoding, "schemaName": name}
    return _text("advertise", channels=[channel])


def unadvertise(number: int) -> bytes:
    """Publish the topic of an own channel no more."""
    return _text("unadvertise", channelIds=[number])


def get_parameters(names: tuple[str, ...], question: str) -> bytes:
    """Ask for parameters; no names: for all."""
    return _text("getParameters", parameterNames=names, id=question)


def fetch_file(name: str, question: int) -> bytes:
    """Ask for a file by its name, such as "package://base/hull.stl"."""
    return _text("fetchAsset", uri=name, requestId=question)


def subscribe_graph() -> bytes:
    """Ask for the nodes that publish and subscribe, now and at each change."""
    return _text("subscribeConnectionGraph")


def _text(op: str, **values: object) -> bytes:
    return json.dumps({"op": op, **values}).encode()


def data(channel: int, payload: Payload) -> bytes:
    """A message of an own channel."""
    return b"".join((_OWN_DATA.pack(_DATA_OP, channel), payload))


def request(service: int, call: int, encoding: str, payload: Payload) -> bytes:
    """A request of a service."""
    name = encoding.encode()
    return b"".join((_SERVICE.pack(_REQUEST_OP, service, call, len(name)), name, payload))
