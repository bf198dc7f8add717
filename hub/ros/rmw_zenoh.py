"""Keys, tokens and attachments with which ROS 2 nodes meet over Zenoh (rmw_zenoh); pure.

| what | text |
| --- | --- |
| key of a topic or service | DOMAIN/NAME/TYPE/HASH |
| token of a node | @ros2_lv/DOMAIN/SESSION/NODE/ENTITY/NN/ENCLAVE/NAMESPACE/NODE NAME |
| token of what a node has | the same with MP, MS, SS or SC, then /NAME/TYPE/HASH/QUALITY |
| attachment | sequence, time [ns], 16 bytes that name the publisher |

TYPE is written `geometry_msgs::msg::dds_::Twist_`. In tokens "%" stands for "/" within a part.
"""

from __future__ import annotations

import enum
import re
import struct
from typing import Final

from hub.errors import RosMessageError
from hub.values import dataclass

TOKENS: Final = "@ros2_lv"
"""The first part of all tokens."""
HASH_OF_HUMBLE: Final = "TypeHashNotSupported"
"""The hash of every type of ROS 2 Humble; so it meets no later one."""
GID_BYTES: Final = 16
MOST_TEXT: Final = 1024
"""Longest token that is read [characters]."""
_MOST_NUMBER: Final = 1 << 31
_USUAL_DEPTH: Final = 42
"""Depth of an endpoint whose token leaves it out: the default of rmw_zenoh."""
_NEW = struct.Struct("<qqB16s")
_OLD = struct.Struct("<16sq17sq11sB16s")
_OLD_NAMES: Final = (b"\x0fsequence_number", b"\x10source_timestamp", b"\x0asource_gid")
_NAME = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+", re.ASCII)
_TYPE = re.compile(r"(\w+)::(msg|srv|action)::dds_::(\w+)_", re.ASCII)
_ROS_TYPE = re.compile(r"(\w+)/(msg|srv|action)/(\w+)", re.ASCII)
_HASH = re.compile(r"RIHS01_[0-9a-f]{64}", re.ASCII)
_SESSION = re.compile(r"[0-9a-f]{1,32}", re.ASCII)


class EntityKind(enum.Enum):
    """What a token announces."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIBER = "MS"
    SERVER = "SS"
    CALLER = "SC"


@dataclass(frozen=True, slots=True, kw_only=True)
class QualityOfService:
    """The part of a quality of service that a line uses.

    Attributes:
        reliable: Whether messages are sent again until they come.
        latched: Whether later subscribers get the last messages ("transient local").
        depth: How many messages are kept.
    """

    reliable: bool = True
    latched: bool = False
    depth: int = 10

    @property
    def text(self) -> str:
        """It in a token."""
        reliable, latched = "" if self.reliable else "2", "1" if self.latched else ""
        return f"{reliable}:{latched}:,{self.depth}:,:,:,,"


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """A topic or service as one side of it has it.

    Attributes:
        name: Such as "/cmd_vel".
        type: As ROS 2 writes it: "geometry_msgs/msg/Twist".
        hash: Hash of the type.
        quality: Quality of service.
    """

    name: str
    type: str
    hash: str
    quality: QualityOfService = QualityOfService()

    def key(self, domain: int) -> str:
        """The key of its messages."""
        return f"{domain}/{self.name.strip('/')}/{_dds(self.type)}/{self.hash}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Entity:
    """A node, or what it publishes, subscribes to, serves or calls.

    Attributes:
        session: Identity of its Zenoh session.
        node: Number of its node in the session.
        number: Its own number; a node's is that of the node.
        kind: What it is.
        namespace: Namespace of its node: "/rover"; empty: none.
        node_name: Name of its node.
        endpoint: Its topic or service; None: it is a node.
    """

    session: str
    node: int = 0
    number: int
    kind: EntityKind
    namespace: str = ""
    node_name: str
    endpoint: Endpoint | None = None

    @property
    def full_node_name(self) -> str:
        """The name of its node with its namespace: "/rover/teleop"."""
        return f"{self.namespace}/{self.node_name}"

    def token(self, domain: int) -> str:
        """The token that announces it."""
        parts: list[object] = [TOKENS, domain, self.session, self.node, self.number]
        parts += [self.kind.value, "%", _mangled(self.namespace or "/"), self.node_name]
        if self.endpoint is not None:
            it = self.endpoint
            parts += [_mangled(it.name), _dds(it.type), it.hash, it.quality.text]
        return "/".join(map(str, parts))


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageOrigin:
    """What is attached to a message.

    Attributes:
        sequence: Counts the messages of this publisher.
        stamp_ns: When it was published, on the wall clock of the publisher [ns].
        gid: Names the publisher, 16 bytes.
    """

    sequence: int
    stamp_ns: int
    gid: bytes

    def pack(self) -> bytes:
        """Its bytes, as since April 2025."""
        return _NEW.pack(self.sequence, self.stamp_ns, GID_BYTES, self.gid)


def unpack_origin(raw: bytes | None) -> MessageOrigin:
    """What is attached to a message, in the form of today or of before April 2025.

    Raises:
        RosMessageError: There is nothing of these forms.
    """
    if raw is not None and len(raw) == _NEW.size:
        sequence, stamp_ns, length, gid = _NEW.unpack(raw)
        if length == GID_BYTES:
            return MessageOrigin(sequence=sequence, stamp_ns=stamp_ns, gid=gid)
    if raw is not None and len(raw) == _OLD.size:
        first, sequence, second, stamp_ns, third, length, gid = _OLD.unpack(raw)
        if (first, second, third) == _OLD_NAMES and length == GID_BYTES:
            return MessageOrigin(sequence=sequence, stamp_ns=stamp_ns, gid=gid)
    text = f"a message has {len(raw or b'')} bytes attached, which are not those of rmw_zenoh"
    raise RosMessageError(text)


def tokens_of(domain: int) -> str:
    """The pattern of all tokens of a domain."""
    return f"{TOKENS}/{domain}/**"


def type_in_key(key: str) -> str:
    """The type in the key of a message, such as "geometry_msgs/msg/Twist".

    Raises:
        RosMessageError: It is no key of rmw_zenoh.
    """
    kind = _TYPE.fullmatch(key.rpartition("/")[0].rpartition("/")[2])
    if kind is None or len(key) > MOST_TEXT:
        text = f"{key[:80]!r} is no key of rmw_zenoh"
        raise RosMessageError(text)
    return "/".join(kind.groups())


def parse_token(text: str) -> Entity:
    """The entity that a token announces.

    Raises:
        RosMessageError: It is no token of rmw_zenoh.
    """
    parts = text.split("/") if len(text) <= MOST_TEXT else []
    kind = next((each for each in EntityKind if parts[5:6] == [each.value]), None)
    if kind is None or parts[0] != TOKENS or len(parts) != (9 if kind is EntityKind.NODE else 13):
        raise _refused(text)
    namespace = parts[7].replace("%", "/")
    node = f"/{parts[8]}"
    if not _SESSION.fullmatch(parts[2]) or not _NAME.fullmatch(node):
        raise _refused(text)
    if namespace not in ("", "/") and not _NAME.fullmatch(namespace):
        raise _refused(text)
    return Entity(
        session=parts[2],
        node=_number(parts[3], text),
        number=_number(parts[4], text),
        kind=kind,
        namespace=namespace.rstrip("/"),
        node_name=parts[8],
        endpoint=None if kind is EntityKind.NODE else _endpoint(parts[9:], text),
    )


def _endpoint(parts: list[str], text: str) -> Endpoint:
    name, kind = parts[0].replace("%", "/"), _TYPE.fullmatch(parts[1])
    known = parts[2] == HASH_OF_HUMBLE or _HASH.fullmatch(parts[2])
    if not (_NAME.fullmatch(name) and kind and known):
        raise _refused(text)
    return Endpoint(
        name=name, type="/".join(kind.groups()), hash=parts[2], quality=_quality(parts[3], text)
    )


def _quality(spelt: str, text: str) -> QualityOfService:
    parts = spelt.split(":")
    if len(parts) != 6:
        raise _refused(text)
    depth = parts[2].partition(",")[2]
    return QualityOfService(
        reliable=parts[0] != "2",
        latched=parts[1] == "1",
        depth=_number(depth, text) if depth else _USUAL_DEPTH,
    )


def _number(spelt: str, text: str) -> int:
    if not (spelt.isascii() and spelt.isdecimal() and len(spelt) <= 10):
        raise _refused(text)
    return min(int(spelt), _MOST_NUMBER)


def _mangled(name: str) -> str:
    return name.replace("/", "%")


def _dds(name: str) -> str:
    """A type's name in keys.

    Raises:
        RosMessageError: It is no name of a type.
    """
    match = _ROS_TYPE.fullmatch(name)
    if match is None:
        text = f"{name[:80]!r} is no type of ROS 2; one is written geometry_msgs/msg/Twist"
        raise RosMessageError(text)
    package, kind, bare = match.groups()
    return f"{package}::{kind}::dds_::{bare}_"


def _refused(text: str) -> RosMessageError:
    return RosMessageError(f"{text[:80]!r} is no token of rmw_zenoh")
