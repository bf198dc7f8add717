"""The schema texts of a message: ros2msg, as recordings carry it, and OMG IDL.

Both describe a payload by its format, with the names of the dataclass's fields. So tools of ROS 2
read the bytes unchanged. A dataclass that is a type of ROS 2, field for field, has its name as the
class attribute `ros_type`, such as "geometry_msgs/msg/Twist". Where ROS 2 has no counterpart the
wire decides:

| format | in the schema |
| --- | --- |
| `byte`, `ubyte`, `char` | int8, uint8, uint8 |
| enum that a `Wire` makes a `char` | byte: tools differ on its sign, so only for small numbers |
| enum | int32 |
| array of several dimensions, or of arrays | one array of all elements |
| pointer | sequence of at most one |
| linked list | sequence of the node's type, which lacks the self pointer |
| array of or pointer to pointers, lists or sequences | array of a type of its own around them |

Two formats have no schema: an empty struct, for which ROS 2 writes a byte, and a message with
field names that ROS 2 does not allow.
"""

from __future__ import annotations

import itertools
import re
from typing import Any, NoReturn, cast

from hub.errors import MessageFormatError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.dataclass_codec import DataclassCodec
from hub.values import dataclass

PACKAGE = "rune_msgs"
"""ROS package of each type that is none of ROS 2's own."""

_SMALL_ENUM = "char of an enum"
_ROS = {
    "byte": "int8",
    "ubyte": "uint8",
    "char": "uint8",
    _SMALL_ENUM: "byte",
    "short": "int16",
    "ushort": "uint16",
    "int": "int32",
    "uint": "uint32",
    "long": "int64",
    "ulong": "uint64",
    "float": "float32",
    "double": "float64",
    "boolean": "bool",
    "string": "string",
}
_IDL = _ROS | {_SMALL_ENUM: "octet", "float": "float", "double": "double", "boolean": "boolean"}
_FIELD_NAME = re.compile(r"[a-z](?:_?[a-z0-9])*", re.ASCII)
_ROS_TYPE = re.compile(r"([a-z]\w*)/msg/([A-Z][A-Za-z0-9]*)", re.ASCII)


@dataclass(frozen=True, slots=True)
class _Field:
    """One field of a type.

    Attributes:
        name: Its name.
        kind: A primitive of the grammar, or a type of the schema.
        count: None for a single value, 0 for a sequence, else elements of an array.
        bounded: Whether it is a sequence with `count` elements at most.
    """

    name: str
    kind: str | _Kind
    count: int | None = None
    bounded: bool = False


@dataclass(frozen=True, slots=True)
class _Kind:
    """A type of the schema, in a ROS package."""

    package: str
    name: str
    fields: tuple[_Field, ...]


def ros_type(definition: MessageDefinition[Any]) -> str:
    """The name of the message's ROS 2 type: "rune_msgs/msg/GCMRobotState".

    Raises:
        MessageFormatError: The message has no ROS 2 type.
    """
    kind = _Schema(definition).kinds[-1]
    return f"{kind.package}/msg/{kind.name}"


def ros2msg(definition: MessageDefinition[Any]) -> str:
    """The message's fields as ROS 2 .msg text, and the types it uses.

    The form is the encoding "ros2msg" of MCAP files: each further type follows a line of 80 "="
    and "MSG: package/Name".

    Raises:
        MessageFormatError: The message has no ROS 2 type.
    """
    schema = _Schema(definition)
    lines: list[str] = []
    for kind in reversed(schema.kinds):
        if lines:
            lines += ["=" * 80, f"MSG: {kind.package}/{kind.name}"]
        lines += map(_ros_field, kind.fields)
    return "\n".join(lines) + "\n"


def omg_idl(definition: MessageDefinition[Any]) -> str:
    """The message and the types it uses as OMG IDL, in the modules that ROS 2 has for them.

    A field whose name is a word of IDL keeps it, as in the IDL that ROS 2 makes of its messages.

    Raises:
        MessageFormatError: The message has no ROS 2 type.
    """
    lines: list[str] = []
    for package, kinds in itertools.groupby(_Schema(definition).kinds, lambda kind: kind.package):
        lines += [f"module {package} {{", "  module msg {"]
        for kind in kinds:
            lines.append(f"    struct {kind.name} {{")
            lines += [f"      {_idl_field(each)};" for each in kind.fields]
            lines.append("    };")
        lines += ["  };", "};"]
    return "\n".join(lines) + "\n"


def _ros_field(each: _Field) -> str:
    kind = each.kind
    name = _ROS[kind] if isinstance(kind, str) else f"{kind.package}/{kind.name}"
    if each.count is None:
        return f"{name} {each.name}"
    return f"{name}[{'<=' if each.bounded else ''}{each.count or ''}] {each.name}"


def _idl_field(each: _Field) -> str:
    kind = each.kind
    name = _IDL[kind] if isinstance(kind, str) else f"{kind.package}::msg::{kind.name}"
    if each.bounded:
        return f"sequence<{name}, {each.count}> {each.name}"
    if each.count is None:
        return f"{name} {each.name}"
    return f"{name} {each.name}[{each.count}]" if each.count else f"sequence<{name}> {each.name}"


class _Schema:
    """The types of one message.

    Attributes:
        kinds: The types, each behind those that it uses; the message's own is the last.
    """

    def __init__(self, definition: MessageDefinition[Any]) -> None:
        self.kinds: list[_Kind] = []
        self._known: dict[tuple[type[Any], formats.Format], _Kind] = {}
        self._format = definition.wire_format
        tree = definition.tree
        own = self._standard(definition.type)
        package, self._root = own or (PACKAGE, type_name(definition.name))
        if tree.next_place is None:
            self._add(package, self._root, self._fields(tree, definition.record, self._root))
        else:
            nodes = self._field("nodes", tree, definition.record, self._root)
            self._add(package, self._root, (nodes,))

    def _standard(self, kind: type[Any]) -> tuple[str, str] | None:
        """Package and name of the ROS 2 type that a dataclass is; None: it is none."""
        name: str = getattr(kind, "ros_type", "")
        match = _ROS_TYPE.fullmatch(name)
        if name and match is None:
            self._refuse(f"{name[:80]!r} is not written package/msg/Name")
        return match and (match[1], match[2])

    def _refuse(self, reason: str) -> NoReturn:
        raise MessageFormatError(self._format, 0, f"no ROS 2 type: {reason}")

    def _add(self, package: str, name: str, fields: tuple[_Field, ...]) -> _Kind:
        if not fields:
            self._refuse(f"{name} is an empty struct")
        kind = _Kind(package, name, fields)
        self.kinds.append(kind)
        return kind

    def _free(self, name: str) -> str:
        """The name, with a number if another type has it."""
        taken = {self._root, *(kind.name for kind in self.kinds if kind.package == PACKAGE)}
        numbered = (f"{name}{number}" for number in itertools.count(2))
        return next(each for each in itertools.chain([name], numbered) if each not in taken)

    def _fields(
        self, tree: formats.Struct, record: DataclassCodec, owner: str
    ) -> tuple[_Field, ...]:
        return tuple(
            _Field(member.name, _SMALL_ENUM)
            if member.inward is not None and node == formats.Primitive("char")
            else self._field(member.name, node, member.record, owner)
            for member, node in zip(record.members, tree.members, strict=True)
            if not isinstance(node, formats.SelfPointer)
        )

    def _field(
        self, name: str, node: formats.Format, record: DataclassCodec | None, owner: str
    ) -> _Field:
        if not _FIELD_NAME.fullmatch(name):
            self._refuse(f"{name!r} is no name for a field there")
        kind, count, bounded = self._shape(node, record, owner + type_name(name))
        return _Field(name, kind, count, bounded)

    def _shape(
        self, node: formats.Format, record: DataclassCodec | None, owner: str
    ) -> tuple[str | _Kind, int | None, bool]:
        """Type, count and whether it is bounded, as `_Field` has them."""
        if isinstance(node, formats.Primitive):
            return node.name, None, False
        if isinstance(node, formats.Enum):
            return "int", None, False
        if isinstance(node, formats.Struct):
            count = None if node.next_place is None else 0
            return self._struct(node, record), count, False
        if isinstance(node, formats.FixedArray):
            count = node.count
            while isinstance(node.element, formats.FixedArray):
                node = node.element
                count *= node.count
            return self._element(node.element, record, owner), count, False
        if isinstance(node, formats.VariableArray):
            return self._element(node.element, record, owner), 0, False
        if isinstance(node, formats.Pointer):
            target = node.target
            if isinstance(target, formats.Struct) and target.next_place is not None:
                return self._struct(target, record), 0, False
            return self._element(target, record, owner), 1, True
        raise AssertionError(node)

    def _element(
        self, node: formats.Format, record: DataclassCodec | None, owner: str
    ) -> str | _Kind:
        """The type of one element; an inner array gets a type of its own."""
        kind, count, bounded = self._shape(node, record, owner)
        if count is None:
            return kind
        return self._add(PACKAGE, self._free(owner), (_Field("items", kind, count, bounded),))

    def _struct(self, node: formats.Struct, known: DataclassCodec | None) -> _Kind:
        record = cast("DataclassCodec", known)
        key = (record.kind, node)
        if key not in self._known:
            standard = self._standard(record.kind)
            package, name = standard or (PACKAGE, type_name(record.kind.__name__))
            fields = self._fields(node, record, name)
            # Several dataclasses may be one type, each with ranges of its own.
            same = self._find(package, name, fields) if standard else None
            name = name if standard else self._free(name)
            self._known[key] = same or self._add(package, name, fields)
        return self._known[key]

    def _find(self, package: str, name: str, fields: tuple[_Field, ...]) -> _Kind | None:
        """The type of this name in the schema; None: it has none yet."""
        for kind in self.kinds:
            if (kind.package, kind.name) == (package, name):
                if kind.fields != fields:
                    self._refuse(f"two types are {package}/msg/{name}, and they differ")
                return kind
        return None


def type_name(name: str) -> str:
    """A name with underscores as a type's name in ROS 2: "GCM_robot_state", "GCMRobotState"."""
    return "".join(part[0].upper() + part[1:] for part in name.split("_") if part)
