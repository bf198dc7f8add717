"""Whatever goes into parser and codec, nothing but their own errors comes out."""

from __future__ import annotations

import datetime
import decimal
import fractions
import random
import time
import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hub.errors import CodecError, MessageFormatError
from hub.gcm.catalog import MESSAGES
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import codec
from hub.ipc.formats import grammar as formats
from tests.hub.gcm.test_wire import value_of
from tests.hub.ipc.formats.trees import structs, values_of
from tests.hub.ipc.ros_shape import definition_of
from tests.support.repetitions import repetitions

_ODD_ARRAYS: list[Any] = [
    np.array(["1", "x"]),
    np.array([b"1"]),
    np.array([1, "x", None], object),
    np.array([2**70, -1], object),
    np.array([decimal.Decimal("sNaN")], object),
    np.array(["2020-01-01"], "M8[D]"),
    np.array([1j]),
    np.array(5),
    np.array([]),
    np.zeros((2, 0, 3)),
    np.array([(1, 2.0)], "i4,f8"),
    np.arange(6, dtype=">i2"),
    np.array([np.nan, np.inf, -np.inf]),
    np.float64(1.5),
    np.int8(-3),
    np.bool_(1),
    np.str_("x"),
    np.zeros((1,) * 32),
]
_ODD_OBJECTS: list[Any] = [
    object(),
    object,
    int,
    Ellipsis,
    iter([1, 2]),
    {1, 2},
    range(3),
    memoryview(np.arange(4.0)),
    memoryview(b"abcdef")[::2],
    bytearray(b"\0\1"),
    datetime.date(2020, 1, 1),
    10**400,
    -(10**400),
    "\ud800",
    "a\0b",
    1e308,
    len,
]
# By number, for not all of them have a hash.
_ODD = st.integers(0, len(_ODD_ARRAYS) + len(_ODD_OBJECTS) - 1).map(
    [*_ODD_ARRAYS, *_ODD_OBJECTS].__getitem__
)
_ANYTHING = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.complex_numbers(),
        st.text(max_size=4),
        st.binary(max_size=9),
        st.decimals(),
        st.builds(fractions.Fraction, st.integers(), st.integers(1)),
        _ODD,
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=5),
        st.lists(inner, max_size=5).map(tuple),
        st.dictionaries(st.sampled_from(["a0", "a1", "b0", "items", "x"]), inner, max_size=4),
    ),
    max_leaves=8,
)


@st.composite
def _spoiled(draw: st.DrawFn, value: Any) -> Any:
    """The value with something else in one place."""
    if isinstance(value, (list, tuple)) and value and draw(st.integers(0, 4)):
        place = draw(st.integers(0, len(value) - 1))
        changed = list(value)
        changed[place] = draw(_spoiled(value[place]))
        return type(value)(changed)
    return draw(_ANYTHING)


@st.composite
def _spoiled_cases(draw: st.DrawFn) -> tuple[formats.Struct, Any]:
    tree = draw(structs())
    value = draw(values_of(tree))
    for _ in range(draw(st.integers(1, 2))):
        value = draw(_spoiled(value))
    return tree, value


def _encode_or_refuse(coder: codec.Codec | MessageDefinition[Any], value: Any) -> None:
    try:
        payload = b"".join(coder.encode(value))
    except CodecError:
        return
    back = coder.decode(payload)
    assert b"".join(coder.encode(back)) == payload


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(_spoiled_cases())
def test_any_value_is_encoded_or_refused(case: tuple[formats.Struct, Any]) -> None:
    tree, value = case
    _encode_or_refuse(codec.Codec(tree), value)
    definition = definition_of(tree)
    _encode_or_refuse(definition, value)
    try:
        made = definition.build(value)
    except CodecError:
        return
    _encode_or_refuse(definition, made)


@given(
    st.sampled_from(MESSAGES),
    st.dictionaries(st.sampled_from(["linear", "angular", "x", "reason"]) | st.none(), _ANYTHING),
)
def test_any_mapping_is_encoded_or_refused(
    definition: MessageDefinition[Any], value: dict[Any, Any]
) -> None:
    _encode_or_refuse(definition, value)


@settings(max_examples=repetitions(200, 20_000))
@given(st.sampled_from(MESSAGES), st.data())
def test_damaged_payload_is_a_message_or_refused(
    definition: MessageDefinition[Any], data: st.DataObject
) -> None:
    payload = bytearray(b"".join(definition.encode(value_of(definition))))
    payload[1] = data.draw(st.integers(0, 1))
    for _ in range(data.draw(st.integers(0, 4))):
        payload[data.draw(st.integers(0, len(payload) - 1))] = data.draw(st.integers(0, 255))
    length = data.draw(st.integers(0, len(payload)) | st.just(len(payload)))
    try:
        message = definition.decode(bytes(payload[:length]))
    except CodecError:
        return
    definition.encode(message)


_WORDS = ("{", "}", "[", "]", "<", ">", "*", "*!", ":", ",", ",", " ", "enum", "a", "b", "1", "2")


@given(st.lists(st.sampled_from([*_WORDS, *formats.PRIMITIVES]), max_size=30).map("".join))
def test_any_words_of_the_grammar_are_a_format_or_refused(text: str) -> None:
    try:
        tree = formats.parse(text)
    except MessageFormatError:
        return
    assert formats.parse(str(tree)) == tree
    codec.Codec(tree)


_SOAK_FORMATS = (
    "{byte,double,ubyte,ushort,char,uint,short,ulong,boolean,long,float,int}",
    "{string,byte,string,double,uint,<string:5>}",
    "{ubyte,[float:16],[short:2,3],ubyte,<double:4>,byte,[ulong:2],ushort,<ubyte:8>,uint,<short:1,4>}",
    "{byte,{byte,double},[{byte,short}:3],uint,<{string,{enum idle,running},[double:2]}:4>}",
    "{byte,*double,*{short,*!},{long,string,*!},ubyte,<*{byte,int}:5>}",
    "{ubyte,<{ubyte,<{ubyte,<boolean:1>,string}:1>,*{string,*!}}:1>}",
)
_SOAK_FRAMES = 1_000_000
_SOAK_S = 120.0


def _mutated(random_numbers: random.Random, seeds: list[bytes]) -> bytes:
    """A payload that was cut, lengthened, overwritten, flipped or spliced, or random bytes."""
    raw = bytearray(random_numbers.choice(seeds))
    way = random_numbers.randrange(6)
    if way == 0:
        return random_numbers.randbytes(random_numbers.randrange(80))
    if way == 1:
        del raw[random_numbers.randrange(len(raw) + 1) :]
    elif way == 2:
        at = random_numbers.randrange(len(raw) + 1)
        raw[at:at] = random_numbers.randbytes(random_numbers.randrange(1, 9))
    elif way == 3:
        other = random_numbers.choice(seeds)
        raw[random_numbers.randrange(len(raw)) :] = other[random_numbers.randrange(len(other)) :]
    for _ in range(random_numbers.randrange(4)):
        if raw:
            at = random_numbers.randrange(len(raw))
            raw[at] = random_numbers.choice((0, 1, 2, 127, 128, 255, raw[at] ^ 1 << at % 8))
    return bytes(raw)


def _soak_case(number: int, text: str) -> tuple[codec.Codec, list[bytes]]:
    coder, tree = codec.compiled(text), formats.parse(text)
    examples: list[bytes] = []

    @settings(max_examples=40, database=None, derandomize=True)
    @given(values_of(tree))
    def collect(value: Any) -> None:
        examples.append(b"".join(coder.encode(value)))

    collect()
    seeds = examples + [b"\0\0" + each[2:] for each in examples[: 10 + number]]
    return coder, seeds


@pytest.mark.soak
def test_million_of_mutated_payloads_are_values_or_refused() -> None:
    cases = [_soak_case(*each) for each in enumerate(_SOAK_FORMATS)]
    random_numbers = random.Random(20_260_000)
    end = time.monotonic() + _SOAK_S
    refused = taken = 0
    tracemalloc.start()
    try:
        while refused + taken < _SOAK_FRAMES and time.monotonic() < end:
            coder, seeds = random_numbers.choice(cases)
            for _ in range(100):
                raw = _mutated(random_numbers, seeds)
                try:
                    value = coder.decode(raw)
                except CodecError:
                    refused += 1
                    continue
                taken += 1
                coder.encode(value)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert refused > taken / 10
    assert taken > 1000
    assert refused + taken >= _SOAK_FRAMES / 10
    assert peak < 20_000_000
