"""The codec: CDR bytes computed by hand, identity for any format, CodecError for the rest."""

from __future__ import annotations

import tracemalloc
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError
from hub.ipc.formats import codec
from hub.ipc.formats import grammar as formats
from tests.hub.ipc.formats.trees import same, structs, values_of
from tests.support.cases import for_each

_HEAD = "00010000"
_GOLDEN = Path(__file__).parents[3] / "golden" / "wire" / "byte_orders"

_BY_HAND: list[tuple[str, Any, str]] = [
    ("{}", (), ""),
    ("{byte,double}", (-1, 1.0), "ff 00000000000000 000000000000f03f"),
    ("{double,byte}", (1.0, 127), "000000000000f03f 7f"),
    ("{short,int,long}", (1, 2, 3), "0100 0000 02000000 0300000000000000"),
    ("{ubyte,ushort,ubyte,uint}", (1, 2, 3, 4), "01 00 0200 03 000000 04000000"),
    ("{boolean,boolean,int}", (True, False, 1), "01 00 0000 01000000"),
    ("{string,byte}", ("ab", 5), "03000000 616200 05"),
    ("{string,int}", ("ab", 5), "03000000 616200 00 05000000"),
    ("{string,int}", ("abc", 5), "04000000 61626300 05000000"),
    ("{string,double}", ("", 1.0), "01000000 00 000000 000000000000f03f"),
    ("{string,double}", ("abcd", 1.0), "05000000 6162636400 00000000000000 000000000000f03f"),
    ("{string,string}", ("é", "x"), "03000000 c3a900 00 02000000 7800"),
    ("{int,<double:1>}", (1, np.array([1.0])), "01000000 01000000 000000000000f03f"),
    (
        "{int,byte,<double:1>}",
        (1, 9, np.array([1.0])),
        "01000000 09 000000 01000000 00000000 000000000000f03f",
    ),
    # An empty sequence is its count alone: no padding for elements that are not there.
    ("{int,byte,<double:1>,byte}", (0, 9, b"", 8), "00000000 09 000000 00000000 08"),
    ("{int,byte,<string:1>,byte}", (0, 9, [], 8), "00000000 09 000000 00000000 08"),
    ("{ubyte,<ubyte:1>,short}", (3, b"abc", 7), "03 000000 03000000 616263 00 0700"),
    (
        "{ubyte,<short:1>,<short:1>}",
        (1, np.array([5], "<i2"), np.array([6], "<i2")),
        "01 000000 01000000 0500 0000 01000000 0600",
    ),
    (
        "{ubyte,ushort,<ubyte:1,2>}",
        (2, 3, np.arange(6, dtype=np.uint8)),
        "02 00 0300 06000000 000102030405",
    ),
    # Structs have no alignment of their own; their members align where they stand.
    ("{byte,{byte,int},{byte}}", (1, (2, 3), (4,)), "01 02 0000 03000000 04"),
    ("{byte,[{byte,short}:3]}", (1, [(1, 2), (3, 4), (5, 6)]), "01 01 0200 03 00 0400 05 00 0600"),
    (
        "{ubyte,<{string,<double:1>}:1>}".replace("<double:1>", "double"),
        (2, [("a", 1.0), ("", 2.0)]),
        "02 000000 02000000 02000000 6100 0000 000000000000f03f"
        "01000000 00 000000 0000000000000040",
    ),
    ("{byte,[double:1]}", (1, np.array([1.0])), "01 00000000000000 000000000000f03f"),
    (
        "{string,[double:1],byte}",
        ("", np.array([1.0]), 7),
        "01000000 00 000000 000000000000f03f 07",
    ),
    ("{[short:2,3]}", (np.arange(6, dtype="<i2").reshape(2, 3),), "000001000200030004000500"),
    ("{byte,[boolean:3],short}", (1, np.array([True, False, True]), 2), "01 010001 0200"),
    ("{{enum a,b,c},byte,{enum:7}}", (2, 1, 7), "02000000 01 000000 07000000"),
    ("{byte,*double}", (1, None), "01 000000 00000000"),
    ("{byte,*double}", (1, 1.0), "01 000000 01000000 000000000000f03f"),
    ("{byte,*int,byte}", (1, None, 2), "01 000000 00000000 02"),
    ("{*{byte,*short},byte}", ((1, 2), 3), "01000000 01 000000 01000000 0200 03"),
    ("{[[short:2]:2],byte}", ([np.array([1, 2], "<i2"), np.array([3, 4], "<i2")], 5),
     "0100 0200 0300 0400 05"),
    (
        # Arrays of numbers inside an array of structs: each starts where the last one ended.
        "{byte,[{byte,[int:1],byte}:2]}",
        (1, [(2, np.array([3], "<i4"), 4), (5, np.array([6], "<i4"), 7)]),
        "01 02 0000 03000000 04 05 0000 06000000 07",
    ),
    ("{[ulong:2]}", ([1, 2**63 + 1],), "0100000000000000 0100000000000080"),
    # A linked list is a sequence of its nodes; a pointer to one adds nothing but the empty list.
    ("{byte,*!}", (1, (2, (3, None))), "03000000 01 02 03"),
    ("{*!,byte}", (None, 7), "01000000 07"),
    ("{byte,*!,short}", (1, (2, None, 3), 4), "02000000 01 00 0400 02 00 0300"),
    ("{byte,*{byte,*!},byte}", (1, None, 2), "01 000000 00000000 02"),
    ("{byte,*{byte,*!},byte}", (1, (5, (6, None)), 2), "01 000000 02000000 05 06 02"),
    (
        "{byte,{string,*!},int}",
        (1, ("a", ("", None)), 2),
        "01 000000 02000000 02000000 6100 0000 01000000 00 000000 02000000",
    ),
    (
        "{byte,[{byte,*!}:2]}",
        (1, [(2, None), (3, (4, None))]),
        "01 000000 01000000 02 000000 02000000 03 04",
    ),
    (
        "{ubyte,<ubyte:1>,*!}",
        (2, b"ab", (0, b"", None)),
        "02000000 02 000000 02000000 6162 00 00 00000000",
    ),
    ("{byte,{byte,*!},*!}", (1, (2, None), (3, (4, (5, None)), None)),
     "02000000 01 000000 01000000 02 03 0000 02000000 04 05"),
    ("**{byte,*!}", (2, None), "01000000 01000000 02"),
    ("{byte,4}", (1, b"abcd"), "01 61626364"),
    ("{[3:short]}", ([1, 2, 3],), "0100 0200 0300"),
    ("int", 5, "05000000"),
    ("[short:2]", np.array([1, 2], "<i2"), "01000200"),
]  # fmt: skip


def _payload(format_text: str, value: Any) -> bytes:
    return b"".join(codec.compiled(format_text).encode(value))


@for_each(("format_text", "value", "wire"), _BY_HAND)
def test_bytes_are_those_computed_by_hand(format_text: str, value: Any, wire: str) -> None:
    payload = _payload(format_text, value)
    assert payload.hex() == _HEAD + wire.replace(" ", "")
    assert _payload(format_text, codec.compiled(format_text).decode(payload)) == payload


@for_each("letters", range(9))
@for_each("kind", ["double", "long", "ulong", "[double:1]", "*double", "int"])
def test_alignment_is_right_at_each_offset(letters: int, kind: str) -> None:
    value = np.array([3.0]) if kind.startswith("[") else 3
    payload = _payload(f"{{string,{kind}}}", ("x" * letters, value))
    end = 4 + letters + 1
    if kind == "*double":
        end += -end % 4 + 4
    size = 4 if kind == "int" else 8
    raw = payload[4:][end:]
    assert len(raw) == -end % size + size
    assert not any(raw[: -end % size])
    assert same_number(codec.compiled(f"{{string,{kind}}}").decode(payload)[1])


def same_number(value: Any) -> bool:
    return float(np.asarray(value).reshape(-1)[0]) == 3.0


@st.composite
def _cases(draw: st.DrawFn) -> tuple[codec.Codec, Any]:
    tree: formats.Format = draw(structs())
    return codec.Codec(tree), draw(values_of(tree))


@given(_cases())
def test_decoding_gives_back_what_was_encoded(case: tuple[codec.Codec, Any]) -> None:
    coder, value = case
    payload = b"".join(coder.encode(value))
    assert same(coder.decode(payload), value)
    assert same(coder.decode(memoryview(b"12345678" + payload)[8:]), value)


@given(_cases())
def test_lists_are_as_good_as_tuples_and_arrays(case: tuple[codec.Codec, Any]) -> None:
    def listed(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return [listed(item) for item in value]
        return value.tolist() if isinstance(value, np.ndarray) else value

    coder, value = case
    assert b"".join(coder.encode(listed(value))) == b"".join(coder.encode(value))


@given(_cases(), st.data())
def test_truncated_payload_is_refused(case: tuple[codec.Codec, Any], data: st.DataObject) -> None:
    coder, value = case
    payload = b"".join(coder.encode(value))
    length = data.draw(st.integers(0, len(payload) - 1))
    with pytest.raises(CodecError):
        coder.decode(payload[:length])
    with pytest.raises(CodecError):
        coder.decode(payload + b"\0" * 4)


@given(_cases(), st.data())
def test_flipped_bits_give_a_value_or_a_codec_error(
    case: tuple[codec.Codec, Any], data: st.DataObject
) -> None:
    coder, value = case
    payload = bytearray(b"".join(coder.encode(value)))
    for _ in range(data.draw(st.integers(1, 4))):
        payload[data.draw(st.integers(0, len(payload) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    _decode_or_refuse(coder, bytes(payload))


@given(structs(), st.binary(max_size=80))
def test_any_bytes_give_a_value_or_a_codec_error(tree: formats.Struct, raw: bytes) -> None:
    _decode_or_refuse(codec.Codec(tree), raw)
    _decode_or_refuse(codec.Codec(tree), b"\0\1\0\0" + raw)


def _decode_or_refuse(coder: codec.Codec, raw: bytes) -> None:
    try:
        value = coder.decode(raw)
    except CodecError:
        return
    coder.encode(value)


@given(
    structs(),
    st.recursive(
        st.none() | st.integers() | st.floats() | st.text(max_size=3) | st.binary(max_size=3),
        lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.integers(0, 3), inner),
        max_leaves=8,
    ),
)
def test_any_value_is_encoded_or_refused_with_a_codec_error(
    tree: formats.Struct, value: Any
) -> None:
    coder = codec.Codec(tree)
    try:
        payload = b"".join(coder.encode(value))
    except CodecError:
        return
    coder.decode(payload)


_BOMBS = [
    ("{uint,<byte:1>}", "ffffffff ffffffff"),
    ("{uint,<string:1>}", "ffffffff ffffffff 00000000"),
    ("{uint,<{byte,double}:1>}", "ffffff7f ffffff7f 00"),
    ("{ulong,ulong,<byte:1,2>}", "00000000ffffffff 00000000ffffffff 00000000"),
    ("{long,long,<byte:1,2>}", "ffffffffffffffff 0100000000000000 ffffffff"),
    ("{string}", "ffffffff 00"),
    ("[string:16777216]", "00000000"),
    ("[{byte,byte}:8388608]", "00"),
    ("[double:16777216]", "00"),
    ("{int,*!}", "10270000"),
    ("{[byte:1000000],*!}", "10270000"),
    ("{uint,<{uint,<{uint,<byte:1>}:1>}:1>}", "10000000 10000000 ffffff00 ffffff00"),
]


@for_each(("format_text", "wire"), _BOMBS)
def test_declared_sizes_cost_no_memory(format_text: str, wire: str) -> None:
    coder = codec.compiled(format_text)
    raw = bytes.fromhex(_HEAD + wire.replace(" ", "")) + bytes(64)
    with pytest.raises(CodecError):
        coder.decode(raw)
    tracemalloc.start()
    try:
        with pytest.raises(CodecError):
            coder.decode(raw)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 50_000


_MISFITS: list[tuple[str, Any, str]] = [
    ("{int}", (2**31,), "format requires"),
    ("{ubyte}", (-1,), "format requires"),
    ("{int}", (1.5,), "integer"),
    ("{int}", ("1",), "integer"),
    ("{int}", (None,), "integer"),
    ("{double}", ("1",), "float"),
    ("{float}", (1e300,), "too large"),
    ("{boolean}", ("no",), "neither true nor false"),
    ("{boolean}", (2,), "neither true nor false"),
    ("{string}", (b"x",), "encode"),
    ("{string}", (5,), "encode"),
    ("{string}", ("a\0b",), "NUL"),
    ("{string}", ("\ud800",), "surrogates"),
    ("{int,int}", (1,), "1 values instead of 2"),
    ("{int,int}", (1, 2, 3), "3 values instead of 2"),
    ("{string,string}", "ab", "str instead of a sequence"),
    ("{char,char}", b"ab", "bytes instead of a sequence"),
    ("{uint,<string:1>}", (2, "ab"), "str instead of a sequence"),
    ("{int,<byte:1>}", (3, np.zeros(2, np.int8)), "2 elements instead of 3"),
    ("{int,<byte:1>,<int:1>}", (2, [1, 2], [1]), "1 elements instead of 2"),
    ("{int,int,<byte:1,2>}", (2, 3, [0] * 5), "5 elements instead of 6"),
    ("{int,<{int}:1>}", (1, []), "0 values instead of 1"),
    ("{int,<byte:1>}", (-1, []), "out of range"),
    ("{int,<byte:1>}", (1.0, [1]), "integer"),
    ("{int,int,<byte:1,2>}", (-1, -1, [0]), "sizes of"),
    ("{int,int,<byte:1,2>}", (-1, 0, []), "sizes of"),
    ("{int,int,<byte:1,2>}", (1, 1.0, [0]), "integer"),
    ("{int,*!}", None, "None instead of the first node"),
    ("{int,*!}", (1,), "1 values instead of 2"),
    ("{int,*!}", (1, (2, 3)), "int"),
    ("{int,*!}", (1, (2, None, None)), "3 values instead of 2"),
    ("{int,*{int,*!}}", (1, ("x", None)), "integer"),
    ("{{enum:2}}", (Decimal("sNaN"),), "InvalidOperation"),
    ("{[ubyte:2]}", ([1, 256],), "do not fit uint8"),
    ("{[ubyte:2]}", ([-1, 0],), "do not fit uint8"),
    ("{[int:1]}", ([2**40],), "do not fit int32"),
    ("{[byte:1]}", (np.array([200]),), "do not fit int8"),
    ("{[int:1]}", ([1.5],), "do not fit int32"),
    ("{[long:1]}", ([1.5],), "do not fit int64"),
    ("{[long:1]}", (["5"],), "do not fit int64"),
    ("{[long:1]}", ([2**63],), "int"),
    ("{[ulong:2]}", ([-1, 0],), "uint64|out of bounds|too large|convert"),
    ("{[int:1]}", ([np.nan],), "do not fit int32"),
    ("{[int:1]}", (["1"],), "are no int32"),
    ("{[float:1]}", ([1e300],), "do not fit float32"),
    ("{[double:1]}", ([None],), "do not fit float64"),
    ("{[boolean:1]}", ([2],), "do not fit bool"),
    ("{[short:2,3]}", (np.zeros((3, 2), np.int16),), "shape"),
    ("{[short:2]}", ([[1], [2, 3]],), "inhomogeneous"),
    ("{[double:1]}", (b"abc",), "multiple"),
    ("{{enum:2}}", (3,), "enum value 3 is not 0 to 2"),
    ("{{enum:2}}", (-1,), "not 0 to 2"),
    ("{{enum:2}}", (1.0,), "integer"),
    ("{*int}", ("x",), "integer"),
    ("{[{int}:2]}", ([(1,)],), "1 values instead of 2"),
    ("{[{int}:2]}", (None,), "len"),
]


@for_each(("format_text", "value", "reason"), _MISFITS)
def test_value_that_does_not_fit_is_refused_with_the_reason(
    format_text: str, value: Any, reason: str
) -> None:
    with pytest.raises(CodecError, match=reason) as caught:
        _payload(format_text, value)
    assert format_text in str(caught.value)


_WRONG_BYTES = [
    ("{int}", "01000000 00000000", "0 bytes|left over"),
    ("{byte,boolean,[boolean:2]}", "01 01 0102", "neither 0 nor 1"),
    ("{uint,<byte:1>}", "02000000 01000000 05", "size members say 2"),
    ("{string}", "03000000 610000", "without NUL at its end"),
    ("{string}", "02000000 6161", "without NUL at its end"),
    ("{string}", "02000000 ff00", "utf-8"),
    ("{{enum:2}}", "03000000", "enum value 3"),
    ("{{enum:2}}", "ffffffff", "enum value -1"),
    ("{*byte}", "02000000 0101", "a pointer to 2"),
    ("{boolean}", "02", "a boolean of 2 is neither 0 nor 1"),
    ("{string,boolean,int}", "01000000 00 ff 0000 01000000", "a boolean of 255"),
    ("{byte,byte,<byte:1,2>}", "ff ff 0000 01000000 05", "a negative size"),
    ("{byte,byte,<byte:1,2>}", "ff 00 0000 00000000", "a negative size"),
    ("{byte,<byte:1>}", "ff 000000 ffffffff 05", "size members say -1"),
    ("{byte,*!}", "00000000", "a list of 0 nodes"),
    ("*{byte,*!}", "11270000", "a list of 10001 nodes"),
    ("{byte,*!}", "00010000 05", "a list of 256 nodes"),
    ("{int,*!}", "02000000 01000000", "buffer"),
]


@for_each(("format_text", "wire", "reason"), _WRONG_BYTES)
def test_wrong_bytes_are_refused_with_the_reason(format_text: str, wire: str, reason: str) -> None:
    with pytest.raises(CodecError, match=reason):
        codec.compiled(format_text).decode(bytes.fromhex(_HEAD + wire.replace(" ", "")))


_BIG_ENDIAN: list[tuple[str, str, Any]] = [
    ("{short,int,long}", "0001 0000 00000002 0000000000000003", (1, 2, 3)),
    ("{ushort,uint,ulong}", "8000 0000 80000000 8000000000000000", (2**15, 2**31, 2**63)),
    ("{byte,float,double}", "ff 000000 3fc00000 3ff8000000000000", (-1, 1.5, 1.5)),
    ("{string,byte,boolean}", "00000003 616200 05 01", ("ab", 5, True)),
    ("{{enum a,b,c}}", "00000002", (2,)),
    ("{byte,[short:2,2]}", "01 00 0001 0002 0003 0004",
     (1, np.array([[1, 2], [3, 4]], np.int16))),
    ("{[ubyte:2],[boolean:2]}", "0102 0001", (np.array([1, 2], np.uint8), np.array([False, True]))),
    ("{uint,<double:1>}", "00000001 00000001 3ff0000000000000", (1, np.array([1.0]))),
    ("{uint,<double:1>}", "00000000 00000000", (0, np.array([], np.float64))),
    ("{uint,<{string,*int}:1>}", "00000001 00000001 00000001 00 000000 00000001 00000007",
     (1, [("", 7)])),
    ("*{short,*!}", "00000002 0001 0002", (1, (2, None))),
]  # fmt: skip


@for_each(("format_text", "wire", "value"), _BIG_ENDIAN)
def test_big_endian_payload_is_read_into_the_same_values(
    format_text: str, wire: str, value: Any
) -> None:
    coder = codec.compiled(format_text)
    payload = bytes.fromhex("00000000" + wire.replace(" ", ""))
    back = coder.decode(payload)
    assert same(back, value)
    assert b"".join(coder.encode(back))[:4] == b"\0\1\0\0"
    with pytest.raises(CodecError):
        coder.decode(payload[:-1])


@for_each("path", sorted(_GOLDEN.glob("*.txt")))
def test_both_byte_orders_of_a_golden_file_hold_the_same_values(path: Path) -> None:
    """The files were made by another library's ROS 2 writer."""
    format_text, little, big = path.read_text().split("\n\n")
    coder = codec.compiled(format_text)
    value = coder.decode(bytes.fromhex(big))
    assert same(value, coder.decode(bytes.fromhex(little)))
    assert b"".join(coder.encode(value)) == bytes.fromhex(little)
    assert bytes.fromhex(big) != bytes.fromhex(little)


def test_array_read_from_a_big_endian_payload_cannot_be_changed_either() -> None:
    back = codec.compiled("{[short:2]}").decode(bytes.fromhex("0000000000010002"))
    assert back[0].dtype.isnative
    with pytest.raises(ValueError, match="read-only"):
        back[0][0] = 1


@for_each("head", ["00010001", "01010000", "00030000", "0001", ""])
def test_other_encapsulations_are_refused(head: str) -> None:
    with pytest.raises(CodecError):
        codec.compiled("{int}").decode(bytes.fromhex(head) + b"\1\0\0\0")


def test_up_to_three_bytes_that_fill_a_word_are_allowed_at_the_end() -> None:
    payload = _payload("{byte}", (1,))
    assert codec.compiled("{byte}").decode(payload + b"\0\0\0") == (1,)


def test_size_members_of_numpy_integers_do_not_wrap_around() -> None:
    value = (np.uint8(16), np.uint8(16), bytes(256))
    assert len(_payload("{ubyte,ubyte,<ubyte:1,2>}", value)) == 4 + 8 + 256


@for_each(
    "view",
    [
        np.arange(12, dtype=np.uint8)[::2],
        np.arange(12, dtype=np.uint8)[::-2],
        np.arange(12, dtype=np.uint8).reshape(2, 6)[:, ::2],
        np.arange(12, dtype=np.uint8).reshape(6, 2)[:, 1],
        np.arange(6, dtype=">i8"),
        [1, 2, 3, 4, 5, 6],
        bytearray(b"abcdef"),
        memoryview(b"abcdef"),
    ],
)
def test_any_view_of_the_numbers_encodes_the_same_elements(view: Any) -> None:
    wanted = bytes(np.array(view).reshape(-1).astype(np.uint8))
    assert _payload("{uint,<ubyte:1>}", (6, view))[12:] == wanted
    assert _payload("{string,<ubyte:3>}".replace("<ubyte:3>", "[ubyte:6]"),
                    ("", np.array(view).reshape(-1)))[9:] == wanted  # fmt: skip


def test_list_has_a_limit_and_may_not_run_in_a_circle() -> None:
    coder = codec.compiled("*{int,*!}")
    first: Any = None
    for number in range(formats.MAX_NODES):
        first = (number, first)
    payload = b"".join(coder.encode(first))
    assert len(payload) == 8 + 4 * formats.MAX_NODES
    back = coder.decode(payload)
    assert b"".join(coder.encode(back)) == payload
    with pytest.raises(CodecError, match="longer than 10000 nodes"):
        coder.encode((0, first))
    longer = (formats.MAX_NODES + 1).to_bytes(4, "little") + payload[8:] + bytes(4)
    with pytest.raises(CodecError, match="a list of 10001 nodes"):
        coder.decode(payload[:4] + longer)
    circle: list[Any] = [1, None]
    circle[1] = circle
    with pytest.raises(CodecError, match="in a circle"):
        coder.encode(circle)


@pytest.mark.parametrize("count", [128, 129])
def test_array_is_the_same_among_numbers_whether_it_is_short_or_long(count: int) -> None:
    """Up to 1024 bytes it is packed together with its neighbours."""
    numbers = np.arange(2 * count, dtype=np.float64)
    wanted = numbers[::2].tobytes()
    for text, head in ((f"{{byte,[double:{count}],byte}}", 8), ("{string,[double:%d],byte}", 16)):
        format_text = text if "%" not in text else text % count
        first: Any = 1 if head == 8 else "12345"
        for array in (numbers[::2], list(numbers[::2]), numbers[::2].astype(np.int64)):
            payload = _payload(format_text, (first, array, 7))[4:]
            assert payload[head : head + 8 * count] == wanted
            assert payload[head + 8 * count :] == b"\7"


def test_transposed_picture_is_written_in_reading_order() -> None:
    picture = np.arange(6, dtype=np.int16).reshape(2, 3).T
    assert _payload("{[short:3,2]}", (picture,))[4:] == bytes.fromhex("000003000100040002000500")


def test_arrays_are_read_only_views_of_the_payload() -> None:
    payload = _payload("{uint,<ubyte:1>}", (5, b"abcde"))
    array = codec.compiled("{uint,<ubyte:1>}").decode(payload)[1]
    assert np.shares_memory(array, np.frombuffer(payload, np.uint8))
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1


def test_fixed_formats_have_payloads_of_one_length() -> None:
    coder = codec.compiled("{byte,[{byte,[short:3],double}:3],{enum:3}}")
    small = [(1, [(1, [0, 0, 0], 0.0)] * 3, 0), (9, [(7, [1, 2, 3], 1e9)] * 3, 3)]
    assert coder.fixed_length
    assert len({len(b"".join(coder.encode(value))) for value in small}) == 1
