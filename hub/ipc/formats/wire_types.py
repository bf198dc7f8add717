"""The format of a message, from the types of its dataclass's fields.

| type of the field | in the format |
| --- | --- |
| `bool`, `int`, `float`, `str` | `boolean`, `int`, `double`, `string` |
| an `IntEnum` | `{enum:largest}` |
| a dataclass | a struct |
| `X` or None | a pointer; to the dataclass itself: the self pointer of a list |
| a numpy array, `tuple[X, ...]`, with `Fixed(n)` | an array of n |
| the same with `Counted(name)` | an integer member `name`, and an array of that length |
| the same with `Sequence()` | a sequence of any length, as ROS 2 has it |
| any of them with `Wire(text)` | the text, such as `uint` for an `int` |

The integer member before a `Counted` array is no field: the codec writes and checks it.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import types
import typing
from collections.abc import Iterator
from typing import Annotated, Any, TypeAlias

import numpy as np

from hub.errors import MessageFormatError
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES
from hub.values import dataclass


@dataclass(frozen=True, slots=True)
class Wire:
    """The format of a field whose type has several, such as the size of a number.

    Attributes:
        format: Format string; of an array it is the format of one element.
    """

    format: str


@dataclass(frozen=True, slots=True)
class Fixed:
    """An array of constant shape.

    Attributes:
        dimensions: Elements along each dimension.
    """

    dimensions: tuple[int, ...]

    def __init__(self, *dimensions: int) -> None:
        object.__setattr__(self, "dimensions", dimensions)


@dataclass(frozen=True, slots=True)
class Counted:
    """An array of any length, with its number of elements before it on the wire.

    Attributes:
        name: Name of that number.
        wire: Its format: an integer.
    """

    name: str = "count"
    wire: str = "int"


@dataclass(frozen=True, slots=True)
class Sequence:
    """An array of any length; no other member has its number of elements."""


Uint8: TypeAlias = Annotated[int, Wire("ubyte")]
Uint16: TypeAlias = Annotated[int, Wire("ushort")]
Uint32: TypeAlias = Annotated[int, Wire("uint")]
Uint64: TypeAlias = Annotated[int, Wire("ulong")]
FLOAT32 = Wire("float")
"""For a `float` of 4 bytes."""

_BY_TYPE: dict[Any, formats.Format] = {
    bool: formats.Primitive("boolean"),
    int: formats.Primitive("int"),
    float: formats.Primitive("double"),
    str: formats.Primitive("string"),
}
_BY_DTYPE = {dtype: name for name, dtype in DTYPES.items() if name != "char"}


@dataclass(frozen=True, slots=True, kw_only=True)
class WireMember:
    """A member of a struct.

    Attributes:
        name: Its name.
        hint: Type of the field, with its declarations.
        counts: The field whose elements this member counts; empty: it is a field itself.
    """

    name: str
    hint: Any
    counts: str = ""


@functools.lru_cache(maxsize=256)
def members(kind: Any) -> tuple[WireMember, ...]:
    """The members of a dataclass's struct: its fields, and the numbers of `Counted` arrays.

    Raises:
        MessageFormatError: The types of the fields cannot be found.
    """
    try:
        hints = typing.get_type_hints(kind, include_extras=True)
    except (NameError, TypeError) as error:
        reason = f"the types of {kind.__name__}'s fields cannot be found: {error}"
        raise MessageFormatError(kind.__name__, 0, reason) from error
    return tuple(_members(kind, hints))


def _members(kind: type[Any], hints: dict[str, Any]) -> Iterator[WireMember]:
    for field in dataclasses.fields(kind):
        hint = hints[field.name]
        counted = _annotation(hint, Counted)
        if counted is not None:
            yield WireMember(name=counted.name, hint=int, counts=field.name)
        yield WireMember(name=field.name, hint=hint)


def format_of(kind: Any) -> str:
    """The format string of a dataclass.

    Raises:
        MessageFormatError: The type of a field has no format.
    """
    return str(_struct(kind))


@functools.lru_cache(maxsize=256)
def _struct(kind: Any) -> formats.Struct:
    nodes: list[formats.Format] = []
    for member in members(kind):
        counted = _annotation(member.hint, Counted)
        if member.counts:
            continue
        if counted is not None:
            nodes.append(formats.parse(counted.wire))
        nodes.append(_format(member.hint, kind, f"{kind.__name__}.{member.name}", len(nodes)))
    return formats.Struct(tuple(nodes))


def _format(hint: Any, owner: Any, where: str, place: int) -> formats.Format:
    """The format of a field; `place` is the number of members before it."""
    bare = typing.get_args(hint)[0] if typing.get_origin(hint) is Annotated else hint
    fixed, counted = _annotation(hint, Fixed), _annotation(hint, Counted)
    wire, sequence = _annotation(hint, Wire), _annotation(hint, Sequence)
    if fixed is not None or counted is not None or sequence is not None:
        element = formats.parse(wire.format) if wire else _element(bare, owner, where)
        if fixed is not None:
            return formats.FixedArray(element, fixed.dimensions)
        return formats.VariableArray(element, (place,) if counted is not None else ())
    if wire is not None:
        return formats.parse(wire.format)
    if bare in _BY_TYPE:
        return _BY_TYPE[bare]
    if isinstance(bare, type) and issubclass(bare, enum.IntEnum):
        return formats.Enum(max(bare))
    if isinstance(bare, type) and dataclasses.is_dataclass(bare):
        return _struct(bare)
    kinds = [each for each in typing.get_args(bare) if each is not types.NoneType]
    if typing.get_origin(bare) in (typing.Union, types.UnionType) and len(kinds) == 1:
        if kinds[0] is owner:
            return formats.SelfPointer()
        return formats.Pointer(_format(kinds[0], owner, where, place))
    reason = f"{where}: its type says no format; arrays need Fixed, Counted or Sequence"
    raise MessageFormatError(str(bare), 0, reason)


def _element(bare: Any, owner: Any, where: str) -> formats.Format:
    """The format of the elements of an array."""
    arguments = typing.get_args(bare)
    if typing.get_origin(bare) is np.ndarray:
        return formats.Primitive(_BY_DTYPE[np.dtype(typing.get_args(arguments[1])[0])])
    return _format(arguments[0] if arguments else bare, owner, where, 0)


Annotation = typing.TypeVar("Annotation")


def _annotation(hint: Any, kind: type[Annotation]) -> Annotation | None:
    """The last annotation of this kind; an outer one overrides inner ones."""
    found = [each for each in getattr(hint, "__metadata__", ()) if isinstance(each, kind)]
    return found[-1] if found else None
