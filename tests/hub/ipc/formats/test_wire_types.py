"""The format that follows from the types of a dataclass's fields, and the numbers before arrays."""

from __future__ import annotations

import enum
import struct
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import pytest

from hub.errors import CodecError, MessageFormatError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.wire_types import (
    FLOAT32,
    Counted,
    Fixed,
    Sequence,
    Uint8,
    Uint64,
    Wire,
    format_of,
)
from tests.support.cases import for_each


class Colour(enum.IntEnum):
    RED = 0
    BLUE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    x: float
    y: Annotated[float, FLOAT32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Everything:
    yes: bool
    number: int
    text: str
    octet: Uint8
    large: Uint64
    colour: Colour
    place: Place
    maybe: Place | None
    grid: Annotated[npt.NDArray[np.int16], Fixed(2, 3)]
    names: Annotated[tuple[str, ...], Counted("name_count", "uint")]
    places: Annotated[tuple[Place, ...], Counted()]
    numbers: Annotated[tuple[int, ...], Fixed(2), Wire("short")]
    inner: Annotated[Annotated[float, FLOAT32], Wire("{enum A,B}")]


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    number: int
    next: Node | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    name: str = ""
    data: Annotated[npt.NDArray[np.uint8], Counted("length", "uint")]
    places: Annotated[tuple[Place, ...], Counted()] = ()


_FLOATS = struct.pack("<2f", 1.0, 2.0)
WAY = MessageDefinition(name="Way", type=Way)
_PLACES = (Place(x=1.0, y=2.0), Place(x=3.0, y=4.0))


def _payload(value: Any) -> bytes:
    return b"".join(WAY.encode(value))


def test_format_follows_from_the_types() -> None:
    assert format_of(Everything) == (
        "{boolean,int,string,ubyte,ulong,{enum:3},{double,float},*{double,float},[short:2,3],"
        "uint,<string:10>,int,<{double,float}:12>,[short:2],{enum A,B}}"
    )
    assert format_of(Node) == "{int,*!}"
    assert WAY.wire_format == "{string,uint,<ubyte:2>,int,<{double,float}:4>}"
    assert WAY.fields == "name, length, data, count, places[]{x, y}"


def test_numbers_of_elements_are_written_and_are_no_fields() -> None:
    value = Way(data=np.arange(3, dtype=np.uint8), places=_PLACES)
    explicit = MessageDefinition[Any](
        name="Way", type=Way, format="{string,uint,<ubyte:2>,int,<{double,float}:4>}"
    )
    payload = _payload(value)
    assert payload == b"".join(explicit.encode(value))
    back = WAY.decode(payload)
    assert (back.data.tolist(), back.places) == ([0, 1, 2], _PLACES)
    assert not hasattr(back, "count")


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    numbers: Annotated[npt.NDArray[np.float32], Sequence()]
    places: Annotated[tuple[Place, ...], Sequence()]


ROW = MessageDefinition(name="Row", type=Row)


def test_sequence_has_its_length_and_no_other_member() -> None:
    assert ROW.wire_format == "{<float>,<{double,float}>}"
    assert ROW.fields == "numbers, places[]{x, y}"
    payload = b"".join(ROW.encode(Row(numbers=np.float32([1, 2, 3]), places=_PLACES[:1])))
    assert payload == struct.pack("<4B I 3f I 4x d f", 0, 1, 0, 0, 3, 1, 2, 3, 1, 1, 2)
    back = ROW.decode(payload)
    assert (back.numbers.tolist(), back.places) == ([1.0, 2.0, 3.0], _PLACES[:1])


@pytest.mark.parametrize("numbers", [[1, 2], (1.0, 2.0), np.array([1, 2], np.int8), _FLOATS])
def test_sequence_of_numbers_takes_what_arrays_take(numbers: Any) -> None:
    payload = b"".join(ROW.encode(Row(numbers=numbers, places=())))
    assert ROW.decode(payload).numbers.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("wrong", [None, 3, "ab", ["a"]])
def test_what_is_no_sequence_is_refused(wrong: Any) -> None:
    with pytest.raises(CodecError):
        ROW.encode(Row(numbers=wrong, places=()))
    with pytest.raises(CodecError):
        ROW.encode(Row(numbers=[], places=wrong))


def test_sequence_longer_than_its_payload_is_refused() -> None:
    with pytest.raises(CodecError, match="elements cannot be in it"):
        ROW.decode(struct.pack("<4B I", 0, 1, 0, 0, 1 << 31))


def test_mapping_may_give_the_number_of_elements_if_it_is_right() -> None:
    values = {"name": "", "data": b"", "places": [{"x": 1.0, "y": 2.0}]}
    assert _payload(values | {"count": 1}) == _payload(values)


@pytest.mark.parametrize("count", [2, "1", None])
def test_mapping_with_a_wrong_number_of_elements_is_refused(count: Any) -> None:
    values = {"name": "", "data": b"", "places": [{"x": 1.0, "y": 2.0}]}
    with pytest.raises(
        CodecError, match=r"Way\.count is .*, but places has 1 element; leave it out"
    ):
        WAY.encode(values | {"count": count})


@pytest.mark.parametrize("wrong", [None, 3, np.zeros((2, 3), np.uint8)])
def test_what_has_no_number_of_elements_is_refused(wrong: Any) -> None:
    with pytest.raises(CodecError):
        WAY.encode(Way(data=wrong))


def test_payload_with_another_number_of_elements_is_refused() -> None:
    payload = bytearray(_payload(Way(data=np.zeros(1, np.uint8))))
    assert payload[12] == 1
    payload[12] = 2
    with pytest.raises(CodecError, match="size members"):
        WAY.decode(bytes(payload))


@for_each("hint", [bytes, tuple[int, ...], list[int], int | str, dict[str, int], Any])
def test_type_that_says_no_format_is_refused_with_the_field(hint: Any) -> None:
    kind = type("Bad", (), {"__annotations__": {"field": hint}})
    with pytest.raises(MessageFormatError, match=r"Bad\.field: its type says no format"):
        format_of(dataclass(kind))
