"""Definitions: dataclasses against formats, and definitions told to and from central."""

from __future__ import annotations

import dataclasses
import enum
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError, MessageFormatError
from hub.gcm.catalog import MESSAGES
from hub.ipc import codec, control
from hub.ipc.definition import MessageDefinition
from hub.ipc.description import from_listing, to_listing


class Mode(enum.IntEnum):
    OFF = 0
    ON = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    x: int
    y: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Path:
    mode: Mode
    start: Point
    count: int
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class One:
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Nothing:
    pass


@dataclass(frozen=True, slots=True, kw_only=True)
class Even:
    number: int

    def __post_init__(self) -> None:
        if self.number % 2:
            text = "odd"
            raise ValueError(text)


@dataclass(kw_only=True)
class Open:
    x: int
    y: int


PATH = MessageDefinition(name="Path", format="{{enum:2},{int,int},uint,<{int,int}:3>}", type=Path)
_VALUE = Path(
    mode=Mode.ON, start=Point(x=1, y=2), count=2, points=(Point(x=3, y=4), Point(x=5, y=6))
)


def _define(kind: type[Any], text: str) -> MessageDefinition[Any]:
    return MessageDefinition(name="M", format=text, type=kind)


def _payload(definition: MessageDefinition[Any], value: Any) -> bytes:
    return b"".join(definition.encode(value))


@pytest.mark.parametrize(
    ("definition", "value"),
    [
        (PATH, _VALUE),
        (_define(One, "{string}"), One(text="a")),
        (_define(Nothing, "{}"), Nothing()),
        (_define(Even, "{int}"), Even(number=2)),
        (_define(Open, "{int,int}"), Open(x=1, y=2)),
    ],
    ids=lambda item: type(item).__name__,
)
def test_dataclass_comes_back_as_it_was(definition: MessageDefinition[Any], value: Any) -> None:
    back = definition.decode(_payload(definition, value))
    assert type(back) is type(value)
    assert back == value


def test_decoded_value_is_frozen_and_hashable_like_any_other() -> None:
    back = PATH.decode(_payload(PATH, _VALUE))
    assert hash(back) == hash(_VALUE)
    assert type(back.mode) is Mode
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.count = 3
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.start.x = 3


def test_field_names_are_shown_in_the_nesting_of_the_format() -> None:
    assert PATH.fields == "mode, start{x, y}, count, points[]{x, y}"


@pytest.mark.parametrize(
    ("kind", "text", "reason"),
    [
        (Point, "int", "struct"),
        (Point, "{int}", "2 fields"),
        (Point, "{int,{int}}", "needs a dataclass"),
        (Point, "{int,[{int}:2]}", "needs a dataclass"),
        (Point, "{uint,<{int}:1>}", "needs a dataclass"),
        (int, "{int}", "needs a dataclass"),
        (Point, "{int,", "position 5"),
    ],
)
def test_type_that_does_not_fit_its_format_is_refused(
    kind: type[Any], text: str, reason: str
) -> None:
    with pytest.raises(MessageFormatError, match=reason):
        _define(kind, text)


@pytest.mark.parametrize("name", ["", "a b", "1a", "a\0", "ä", "a.b", "x" * 65])
def test_name_that_could_be_mistaken_on_the_wire_is_refused(name: str) -> None:
    with pytest.raises(MessageFormatError):
        MessageDefinition(name=name, format="{}", type=Nothing)


@pytest.mark.parametrize(
    "value",
    [
        None,
        One(text="x"),
        dataclasses.replace(_VALUE, mode=1.5),
        dataclasses.replace(_VALUE, mode=None),
        dataclasses.replace(_VALUE, start=None),
        dataclasses.replace(_VALUE, start=(1, 2)),
        dataclasses.replace(_VALUE, points=None),
        dataclasses.replace(_VALUE, points=(1, 2)),
        dataclasses.replace(_VALUE, count=3),
        dataclasses.replace(_VALUE, count="2"),
    ],
    ids=lambda value: str(value)[:70],
)
def test_value_of_another_kind_is_refused(value: Any) -> None:
    with pytest.raises(CodecError):
        PATH.encode(value)


def test_enum_number_without_a_name_is_refused() -> None:
    payload = bytearray(_payload(PATH, _VALUE))
    payload[4] = 1
    with pytest.raises(CodecError, match=r"Path.mode: 1 is none of \[0, 2\]"):
        PATH.decode(bytes(payload))


def test_value_that_its_type_refuses_is_a_codec_error() -> None:
    definition = _define(Even, "{int}")
    with pytest.raises(CodecError, match="odd"):
        definition.decode(bytes.fromhex("0001000003000000"))


@pytest.mark.parametrize("values", [(), (1,), (1, 2, 3)])
def test_wrong_number_of_members_is_refused(values: tuple[int, ...]) -> None:
    with pytest.raises(CodecError):
        _define(Point, "{int,int}").build(values)


@pytest.mark.parametrize("definition", [*MESSAGES, PATH], ids=lambda d: d.name)
def test_listing_tells_enough_to_decode_without_the_dataclass(
    definition: MessageDefinition[Any],
) -> None:
    told = to_listing(definition)
    known = from_listing(told)
    assert known.fingerprint == definition.fingerprint
    assert known.fields == definition.fields
    assert to_listing(known) == told


def test_generated_dataclass_holds_the_values() -> None:
    shown = from_listing(to_listing(PATH)).decode(_payload(PATH, _VALUE))
    assert shown.start.y == 2
    assert [point.x for point in shown.points] == [3, 5]
    assert shown.mode == 2


def _listing(fields: str, text: str = "{int,int}", **changes: Any) -> control.Define:
    entry = control.Define(
        name="M",
        format=text,
        fields=fields,
        keep="newest",
        plane="state",
        rate_hz=0.0,
        lifespan_s=0.0,
    )
    return dataclasses.replace(entry, **changes)


@pytest.mark.parametrize(
    "entry",
    [
        _listing("x"),
        _listing("x, x"),
        _listing("x, class"),
        _listing("x, __init__"),
        _listing("x, y}"),
        _listing("x, y{"),
        _listing("x; y"),
        _listing("x, y, " + "junk! " * 10),
        _listing("a{" * 50_000),
        _listing("a{" * 1000),
        _listing("x, " + " " * 20_000 + "y"),
        _listing("x, y", "{int,{int}}"),
        _listing("x, y", "{uint,<{int}:1>}"),
        _listing("x, y{z", "{int,{int}}"),
        _listing("x, y", "{int"),
        _listing("x, y", name="no name"),
        _listing("x, y", name="M" * 100_000),
        _listing("x, y", keep="some"),
        _listing("x, y", plane="astral"),
    ],
    ids=lambda entry: f"{entry.fields[:12]}-{entry.format}",
)
def test_listing_that_describes_no_message_is_refused(entry: control.Define) -> None:
    with pytest.raises(MessageFormatError) as caught:
        from_listing(entry)
    assert len(str(caught.value)) < 500


@given(st.text(max_size=40) | st.text("ab{}[], ", max_size=40), st.sampled_from(["{}", "{int}"]))
def test_any_fields_are_taken_or_refused(fields: str, text: str) -> None:
    try:
        from_listing(_listing(fields, text))
    except MessageFormatError:
        return
    assert fields.strip(", ") == "" or text == "{int}"


def test_arrays_of_a_decoded_value_are_numpy_views() -> None:
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Scan:
        ranges: np.ndarray

    definition = _define(Scan, "{[float:3]}")
    back = definition.decode(_payload(definition, Scan(ranges=[1, 2, 3])))
    assert back.ranges.dtype == np.float32
    assert back.ranges.tolist() == [1, 2, 3]


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    mode: Mode
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Journey:
    number: int
    start: Point
    turn: Turn
    rest: Nothing


JOURNEY = _define(Journey, "{ubyte,{int,long},{short,double},{}}")
_JOURNEY = Journey(
    number=1, start=Point(x=2, y=3), turn=Turn(mode=Mode.ON, rate=0.5), rest=Nothing()
)


@pytest.mark.parametrize(
    ("definition", "value", "letters", "numbers"),
    [
        (JOURNEY, _JOURNEY, "Bxxxiqhxxxxxxd", (1, 2, 3, 2, 0.5)),
        (_define(Even, "{int}"), Even(number=4), "i", (4,)),
        (_define(Nothing, "{}"), Nothing(), "", ()),
        (_define(Open, "{byte,ushort}"), Open(x=1, y=2), "bxH", (1, 2)),
    ],
    ids=lambda item: type(item).__name__,
)
def test_flat_message_is_one_struct_of_its_numbers(
    definition: MessageDefinition[Any], value: Any, letters: str, numbers: tuple[Any, ...]
) -> None:
    assert definition.flat_values(value) == numbers
    assert definition.flat_letters == letters
    body = struct.pack("<" + definition.flat_letters, *numbers)
    assert _payload(definition, value) == b"\0\1\0\0" + body
    back = definition.build_flat(struct.unpack("<" + definition.flat_letters, body))
    assert back == value
    assert type(back) is type(value)


def test_flat_message_is_frozen_and_knows_its_enums_like_any_other() -> None:
    back = JOURNEY.build_flat((1, 2, 3, 2, 0.5))
    assert type(back.turn.mode) is Mode
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.start.x = 3


@pytest.mark.parametrize("numbers", [(), (1, 2, 3, 2), (1, 2, 3, 2, 0.5, 6), (1, 2, 3, 1, 0.5)])
def test_wrong_numbers_of_a_flat_message_are_refused(numbers: tuple[Any, ...]) -> None:
    with pytest.raises(CodecError):
        JOURNEY.build_flat(numbers)


def test_number_that_the_type_of_a_flat_message_refuses_is_a_codec_error() -> None:
    with pytest.raises(CodecError, match="odd"):
        _define(Even, "{int}").build_flat((3,))


@pytest.mark.parametrize(
    "text",
    ["{string}", "{boolean}", "{{enum:2}}", "{[int:1]}", "{*int}", "{[{int}:1]}"],
)
def test_message_with_more_than_numbers_is_not_flat(text: str) -> None:
    assert codec.compiled(text).flat_letters is None
    if "[{" not in text:
        definition = _define(One, text)
        with pytest.raises(CodecError, match="not of a flat format"):
            _ = definition.flat_values
        with pytest.raises(CodecError, match="not of a flat format"):
            _ = definition.build_flat
