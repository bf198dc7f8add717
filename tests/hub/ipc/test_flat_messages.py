"""Flat messages: one struct of their numbers, read without a value in between."""

from __future__ import annotations

import dataclasses
import struct
from dataclasses import dataclass
from typing import Any

import pytest

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import codec
from tests.hub.ipc.shapes import Even, Mode, Nothing, One, Open, Point, define, payload, plain


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


JOURNEY = define(Journey, "{ubyte,{int,long},{short,double},{}}")


_JOURNEY = Journey(
    number=1, start=Point(x=2, y=3), turn=Turn(mode=Mode.ON, rate=0.5), rest=Nothing()
)


@pytest.mark.parametrize(
    ("definition", "value", "letters", "numbers"),
    [
        (JOURNEY, _JOURNEY, "Bxxxiqhxxxxxxd", (1, 2, 3, 2, 0.5)),
        (define(Even, "{int}"), Even(number=4), "i", (4,)),
        (define(Nothing, "{}"), Nothing(), "", ()),
        (define(Open, "{byte,ushort}"), Open(x=1, y=2), "bxH", (1, 2)),
    ],
    ids=lambda item: type(item).__name__,
)
def test_flat_message_is_one_struct_of_its_numbers(
    definition: MessageDefinition[Any], value: Any, letters: str, numbers: tuple[Any, ...]
) -> None:
    assert definition.flat_values(value) == numbers
    assert definition.flat_letters == letters
    body = struct.pack("<" + definition.flat_letters, *numbers)
    assert payload(definition, value) == b"\0\1\0\0" + body
    back = definition.receive_flat(struct.unpack("<" + definition.flat_letters, body))
    assert back == value
    assert type(back) is type(value)


def test_flat_message_is_frozen_and_knows_its_enums_like_any_other() -> None:
    back = JOURNEY.receive_flat((1, 2, 3, 2, 0.5))
    assert type(back.turn.mode) is Mode
    with pytest.raises(dataclasses.FrozenInstanceError):
        back.start.x = 3


@pytest.mark.parametrize("numbers", [(), (1, 2, 3, 2), (1, 2, 3, 2, 0.5, 6), (1, 2, 3, 1, 0.5)])
def test_wrong_numbers_of_a_flat_message_are_refused(numbers: tuple[Any, ...]) -> None:
    with pytest.raises(CodecError):
        JOURNEY.receive_flat(numbers)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"start": None}, "M.start: NoneType is not a Point, it has no x"),
        ({"start": {"x": 1}}, "M.start needs a value for y"),
    ],
)
def test_value_without_the_numbers_of_a_flat_message_is_refused(
    changes: dict[str, Any], reason: str
) -> None:
    with pytest.raises(CodecError, match=reason):
        JOURNEY.flat_values(dataclasses.replace(_JOURNEY, **changes))


def test_numbers_of_a_flat_message_can_come_from_a_mapping() -> None:
    assert JOURNEY.flat_values(plain(_JOURNEY)) == (1, 2, 3, 2, 0.5)
    assert payload(JOURNEY, plain(_JOURNEY)) == payload(JOURNEY, _JOURNEY)


def test_number_that_the_type_of_a_flat_message_refuses_is_a_codec_error() -> None:
    with pytest.raises(CodecError, match="odd"):
        define(Even, "{int}").receive_flat((3,))


@pytest.mark.parametrize(
    "text",
    ["{string}", "{boolean}", "{{enum:2}}", "{[int:1]}", "{*int}", "{[{int}:1]}"],
)
def test_message_with_more_than_numbers_is_not_flat(text: str) -> None:
    assert codec.compiled(text).flat_letters is None
    if "[{" not in text:
        definition = define(One, text)
        with pytest.raises(CodecError, match="not of a flat format"):
            _ = definition.flat_values
        with pytest.raises(CodecError, match="not of a flat format"):
            _ = definition.receive_flat
