"""Reads definitions of ROS types, as recordings carry them: ros2msg, ros2idl and ros1msg.

A definition comes with a file of others, so every size is limited. Types that a definition uses and
does not have are looked up in `known_types`.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from typing import Final, NoReturn

from hub.errors import RosMessageError
from hub.ros.idl import structs_of
from hub.values import dataclass

MOST_TEXT: Final = 1 << 20
"""Longest definition [characters]."""
MOST_FIELDS: Final = 2000
"""Most fields of a type, with those of all types within it; reading them takes 0.4 s at most."""
MOST_DEPTH: Final = 16
"""Types within types; Python reads no more than 20 sequences within sequences."""
MOST_ELEMENTS: Final = 1 << 24
"""Most elements of an array of constant length."""

NUMBERS: Final = {
    "bool": "boolean",
    "byte": "ubyte",
    "char": "ubyte",
    "octet": "ubyte",
    "int8": "byte",
    "uint8": "ubyte",
    "int16": "short",
    "uint16": "ushort",
    "int32": "int",
    "uint32": "uint",
    "int64": "long",
    "uint64": "ulong",
    "float32": "float",
    "float64": "double",
}
"""Numbers of ROS 2, and their names in Rune's formats."""
TEXT: Final = "string"
EMPTY: Final = "structure_needs_at_least_one_member"
"""The field of a type without fields, for which ROS 2 writes a byte."""

_SEPARATOR = re.compile(r"^={3,}[ \t]*\n", re.MULTILINE)
_HEAD = re.compile(r"(?:MSG|IDL): *([\w/]{1,300})[ \t]*\n")
_FIELD = re.compile(
    r"(?P<type>[A-Za-z][\w/]*)(?:<=\d{1,10})?(?P<array>\[(?:(?P<most><=)?(?P<count>\d{1,10}))?\])?"
    r"[ \t]+(?P<name>[A-Za-z]\w*)[ \t]*(?P<rest>.*)",
    re.ASCII,
)
_OLD_TIMES = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}


@dataclass(frozen=True, slots=True)
class RosField:
    """A field of a type.

    Attributes:
        name: Its name.
        kind: A number of `NUMBERS`, `TEXT`, or a type.
        count: None for a single value, 0 for a sequence of any length, else elements of an array.
    """

    name: str
    kind: str | RosType
    count: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RosType:
    """A type with its fields.

    Attributes:
        name: As ROS 2 writes it: "sensor_msgs/msg/Image".
        fields: In the order of the payload.
    """

    name: str
    fields: tuple[RosField, ...]

    @property
    def all_fields(self) -> int:
        """Number of its fields, with those of all types within it."""
        kinds = (each.kind for each in self.fields)
        return sum(1 if isinstance(kind, str) else kind.all_fields for kind in kinds)

    @functools.lru_cache(maxsize=1024)  # noqa: B019 - types live as long as the decoders of them
    def place(self, name: str) -> int:
        """Which field has this name; -1: none."""
        return next((at for at, each in enumerate(self.fields) if each.name == name), -1)


@dataclass(frozen=True, slots=True)
class FieldText:
    """A field as a definition spells it.

    Attributes:
        kind: Name of its type.
        name: Its name.
        count: As `RosField.count`.
    """

    kind: str
    name: str
    count: int | None


def full_name(name: str) -> str:
    """A type's name with its three parts: "std_msgs/Header" is "std_msgs/msg/Header"."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name


def ros_type(name: str, encoding: str, text: str) -> RosType:
    """The type of a definition.

    Args:
        name: Its name.
        encoding: "ros2msg", "ros2idl" or "ros1msg".
        text: The definition; empty: the type must be one of `known_types`.

    Raises:
        RosMessageError: The definition cannot be read, or is too large.
    """
    if len(text) > MOST_TEXT:
        _refuse(name, f"is longer than {MOST_TEXT} characters")
    found = dict(_definitions(full_name(name), encoding, text))
    return _TypeResolver(found, ros_version(encoding)).build(full_name(name))


def ros_version(encoding: str) -> int:
    """The version of ROS, 1 or 2, of an encoding of messages or of definitions."""
    return 1 if encoding in ("ros1", "ros1msg") else 2


def msg_fields(text: str) -> Iterator[FieldText]:
    """The fields of one ros2msg definition; constants are no fields.

    Raises:
        RosMessageError: A line is no field.
    """
    for line in text.splitlines():
        bare = line.strip()
        if not bare or bare.startswith(("#", "@")):
            continue
        match = _FIELD.fullmatch(bare)
        if match is None:
            refusal = f"the line {bare[:60]!r} of a definition is no field"
            raise RosMessageError(refusal)
        if match["rest"].startswith("="):
            continue
        count = None
        if match["array"]:
            count = 0 if match["most"] or not match["count"] else int(match["count"])
        if match["count"] == "0" or (count or 0) > MOST_ELEMENTS:
            refusal = f"the array {match['name'][:60]} has {match['count']} elements"
            raise RosMessageError(refusal)
        yield FieldText(_OLD_TIMES.get(match["type"], match["type"]), match["name"], count)


def _definitions(
    name: str, encoding: str, text: str
) -> Iterator[tuple[str, tuple[FieldText, ...]]]:
    """Each type of a definition with the types that it uses."""
    first, *others = _SEPARATOR.split(text.replace("\r\n", "\n"))
    # rosbag2 may name the first part too, and write it in another language than the others.
    if not first.strip() and others and _HEAD.match(others[0]):
        first = ""
    elif first.strip() or (not others and encoding and text):
        others = [f"MSG: {name}\n{first}", *others]
    for part in others:
        head = _HEAD.match(part)
        if head is None:
            _refuse(name, "has a part without a name")
        body = part[head.end() :]
        if part.startswith("IDL") or (encoding == "ros2idl" and part is others[0]):
            for struct, members in structs_of(body).items():
                yield struct, tuple(FieldText(*member) for member in members)
        else:
            yield full_name(head[1]), tuple(msg_fields(body))


class _TypeResolver:
    """Resolves the names of types."""

    def __init__(self, found: Mapping[str, tuple[FieldText, ...]], version: int) -> None:
        self._found, self._version = found, version
        self._done: dict[str, tuple[RosType, int, int]] = {}
        self._open: list[str] = []

    def build(self, name: str) -> RosType:
        return self._type(name)[0]

    def _type(self, name: str) -> tuple[RosType, int, int]:
        """The type, its number of fields with those within it, and its depth."""
        if name in self._done:
            return self._done[name]
        if name in self._open:
            _refuse(self._open[0], f"contains {name[:80]} within itself")
        if len(self._open) >= MOST_DEPTH:
            _refuse(self._open[0], f"has types within types deeper than {MOST_DEPTH}")
        fields = self._found.get(name)
        if fields is None:
            fields = _known(name, self._version)
        if fields is None:
            _refuse(self._open[0] if self._open else name, f"lacks the definition of {name[:80]}")
        self._open.append(name)
        made: list[RosField] = []
        total = depth = 0
        for each in fields:
            kind, inner, below = self._kind(each.kind, name)
            total, depth = total + inner, max(depth, below)
            if total > MOST_FIELDS:
                _refuse(self._open[0], f"has more than {MOST_FIELDS} fields")
            made.append(RosField(each.name, kind, each.count))
        self._open.pop()
        whole = tuple(made) or (RosField(EMPTY, "uint8"),)
        self._done[name] = RosType(name, whole), max(1, total), depth + 1
        return self._done[name]

    def _kind(self, spelt: str, owner: str) -> tuple[str | RosType, int, int]:
        if spelt in NUMBERS or spelt == TEXT:
            return spelt, 1, 0
        if spelt in ("wstring", "wchar", "float128", "long double"):
            _refuse(self._open[0], f"has a {spelt}, which Rune does not read")
        if "/" not in spelt:
            package = owner.rpartition("/")[0]
            beside = f"{package}/{spelt}"
            known = beside in self._found or _known(beside, self._version) is not None
            spelt = "std_msgs/msg/Header" if spelt == "Header" and not known else beside
        return self._type(full_name(spelt))


def _known(name: str, version: int) -> tuple[FieldText, ...] | None:
    """The fields of a type that all systems with this ROS have; None: it is none of them."""
    from hub.ros.known_types import known_text

    text = known_text(name, version)
    return None if text is None else tuple(msg_fields(text))


def _refuse(name: str, reason: str) -> NoReturn:
    text = f"the definition of {name[:80]} cannot be used: it {reason}"
    raise RosMessageError(text)
