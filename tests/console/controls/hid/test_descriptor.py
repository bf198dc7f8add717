"""Report descriptors, rule by rule."""

from __future__ import annotations

import pytest

from rune_tui.controls.hid.descriptor import MAX_BYTES, MAX_DEPTH, MAX_REPORT_BYTES, parse
from rune_tui.errors import ConsoleError, DescriptorError
from tests.console.controls.hid import writing as w
from tests.console.controls.hid.writing import application, axis, item
from tests.support.cases import for_each


def usages(descriptor: bytes) -> list[int]:
    return [usage for field in parse(descriptor).fields for usage in field.usages_of_elements()]


def test_nothing_at_all_describes_nothing() -> None:
    assert parse(b"").fields == ()


def test_page_is_that_of_the_main_item_not_of_the_usage() -> None:
    text = axis(0x30)
    late = text.replace(item(w.INPUT, 2), item(w.PAGE, 2) + item(w.INPUT, 2))
    assert usages(application(late)) == [0x20030]


def test_usage_of_four_bytes_brings_its_own_page() -> None:
    inner = item(w.PAGE, 9) + item(w.SIZE, 8) + item(w.COUNT, 1)
    inner += item(w.USAGE, 0x10031, 4) + item(w.INPUT, w.VARIABLE)
    assert usages(application(inner)) == [0x10031]


def test_usage_range_of_four_bytes_brings_its_own_page() -> None:
    inner = item(w.PAGE, 1) + item(w.SIZE, 1) + item(w.COUNT, 2)
    inner += item(w.USAGE_MINIMUM, 0x90001, 4) + item(w.USAGE_MAXIMUM, 0x90002, 4)
    assert usages(application(inner + item(w.INPUT, w.VARIABLE))) == [0x90001, 0x90002]


def test_last_usage_counts_for_all_elements_that_are_left() -> None:
    inner = item(w.SIZE, 8) + item(w.COUNT, 4) + item(w.USAGE, 0x30) + item(w.USAGE, 0x31)
    found = usages(application(inner + item(w.INPUT, w.VARIABLE)))
    assert found == [0x10030, 0x10031, 0x10031, 0x10031]


def test_usages_are_forgotten_after_a_main_item() -> None:
    inner = axis(0x30) + item(w.INPUT, w.VARIABLE)
    parsed = parse(application(inner))
    assert len(parsed.fields) == 1
    assert parsed.bits == {0: 16}


def test_of_alternative_usages_the_first_counts() -> None:
    inner = item(w.SIZE, 8) + item(w.COUNT, 2) + item(w.DELIMITER, 1) + item(w.USAGE, 0x32)
    inner += item(w.USAGE, 0x36) + item(w.DELIMITER, 0) + item(w.USAGE, 0x30)
    assert usages(application(inner + item(w.INPUT, w.VARIABLE))) == [0x10032, 0x10030]


@for_each(
    ("least", "most", "minimum", "maximum"),
    [
        (b"\x15\x00", b"\x25\xff", 0, 255),
        (b"\x14", b"\x26\xff\xff", 0, 65535),
        (b"\x15\x00", b"\x27\xff\xff\xff\xff", 0, 2**32 - 1),
        (b"\x15\x81", b"\x25\x7f", -127, 127),
        (b"\x16\x00\x80", b"\x26\xff\x7f", -32768, 32767),
        (b"\x16\xa2\xfe", b"\x26\x5e\x01", -350, 350),
        (b"\x15\xf0", b"\x25\xff", -16, -1),
        (b"\x15\x00", b"\x24", 0, 0),
    ],
)
def test_maximum_has_a_sign_only_where_the_minimum_is_negative(
    least: bytes, most: bytes, minimum: int, maximum: int
) -> None:
    inner = least + most + item(w.SIZE, 16) + item(w.COUNT, 1) + item(w.USAGE, 0x30)
    field = parse(application(inner + item(w.INPUT, w.VARIABLE))).fields[0]
    assert (field.minimum, field.maximum) == (minimum, maximum)


def test_pop_brings_back_what_was_pushed() -> None:
    inner = axis(0x30) + item(w.PUSH) + item(w.SIZE, 1) + item(w.MAXIMUM, 1) + item(w.PAGE, 9)
    inner += item(w.USAGE, 1) + item(w.INPUT, w.VARIABLE) + item(w.POP)
    inner += item(w.USAGE, 0x31) + item(w.INPUT, w.VARIABLE)
    fields = parse(application(inner)).fields
    assert [(each.size, each.maximum, each.usages[0][0]) for each in fields] == [
        (8, 255, 0x10030),
        (1, 1, 0x90001),
        (8, 255, 0x10031),
    ]


def test_reports_with_ids_are_counted_apart() -> None:
    inner = item(w.REPORT_ID, 3) + axis(0x30) + item(w.REPORT_ID, 200) + axis(0x31, size=16)
    inner += item(w.REPORT_ID, 3) + axis(0x32)
    parsed = parse(application(inner))
    assert parsed.numbered
    assert parsed.bits == {3: 16, 200: 16}
    assert [(each.report_id, each.bit) for each in parsed.fields] == [(3, 0), (200, 0), (3, 8)]


def test_outputs_and_features_take_no_room_in_inputs() -> None:
    inner = axis(0x30) + item(w.USAGE, 1) + item(0x90, 2) + item(w.USAGE, 1) + item(0xB0, 2)
    assert parse(application(inner + axis(0x31))).fields[1].bit == 8


def test_fields_belong_to_the_innermost_application() -> None:
    consumer = application(axis(0x30), usage=1, page=12)
    logical = item(w.COLLECTION, w.LOGICAL) + axis(0x32) + item(w.END)
    parsed = parse(application(axis(0x31), consumer, logical))
    assert [each.application for each in parsed.fields] == [0x10004, 0xC0001, 0x10004]


@for_each("tail", [b"\x00", b"\x00\x00\x00", b"\xff\xff", b"\x27\x01", b"\xfe"])
def test_what_follows_the_last_collection_does_no_harm(tail: bytes) -> None:
    plain = application(axis(0x30))
    assert parse(plain + tail) == parse(plain)


def test_unknown_and_long_items_are_skipped() -> None:
    odd = b"\xfe\x03\x00\xc0\xc0\xc0" + b"\x0d\x01" + b"\xd4"
    assert parse(application(odd, axis(0x30))) == parse(application(axis(0x30)))


@for_each(
    ("descriptor", "words"),
    [
        (item(w.END), "byte 0 of the report descriptor: the end of a collection"),
        (item(w.POP), "a pop without a push"),
        (item(w.PUSH) * (MAX_DEPTH + 1), "pushed states"),
        (item(w.COLLECTION, 1) * (MAX_DEPTH + 1), "nested"),
        (item(w.COLLECTION, 1), "1 open collections"),
        (application(axis())[:-3], "1 open collections"),
        (item(w.REPORT_ID, 0), "report id 0"),
        (item(w.REPORT_ID, 256), "report id 256"),
        (item(w.SIZE, 2**32 - 1) + item(w.COUNT, 2**32 - 1) + item(w.INPUT, 2), "a report of"),
        (item(w.SIZE, 8) + item(w.COUNT, MAX_REPORT_BYTES + 1) + item(w.INPUT, 2), "a report of"),
        (bytes(MAX_BYTES + 1), "4097 bytes"),
    ],
)
def test_nonsense_is_refused_in_a_sentence(descriptor: bytes, words: str) -> None:
    with pytest.raises(DescriptorError, match=words) as caught:
        parse(descriptor)
    assert isinstance(caught.value, ConsoleError)
    assert isinstance(caught.value, ValueError)
