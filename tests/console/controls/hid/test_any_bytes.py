"""Whatever is described is decoded; whatever bytes come, nothing breaks."""

from __future__ import annotations

import random
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.errors import DescriptorError
from rune_tui.layout.spec import ControlKind
from tests.console.controls.hid import writing as w
from tests.console.controls.hid.fixtures import NAMES, device
from tests.console.controls.hid.writing import item
from tests.system.harness import in_soak

AXES = (0x30, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A field: its items, the values that a report has in it, what is to be read out of it."""

    descriptor: bytes
    values: list[tuple[int, int]]
    expected: list[int | None]


def _limits(draw: st.DrawFn, size: int) -> tuple[int, int]:
    """A range that fits into so many bits."""
    half = 1 << (size - 1)
    signed = draw(st.booleans())
    bounds = st.integers(-half, half - 1) if signed else st.integers(0, 2 * half - 1)
    least, most = sorted(draw(st.tuples(bounds, bounds).filter(lambda both: both[0] != both[1])))
    # The minimum's sign says how a value is read, so a range of its own has to begin below zero.
    return (min(least, -1) if signed else least), most


@st.composite
def one_axis(draw: st.DrawFn) -> Part:
    size = draw(st.integers(2, 32))
    least, most = _limits(draw, size)
    least = min(least, most - 1)
    nullable = draw(st.booleans())
    low, high = (-1 << (size - 1), (1 << (size - 1)) - 1) if least < 0 else (0, (1 << size) - 1)
    value = draw(st.integers(low, high) if nullable else st.integers(least, most))
    if least >= 2**31:  # an item's minimum has a sign
        least = 2**31 - 1
    descriptor = w.axis(
        draw(st.sampled_from(AXES)),
        size=size,
        minimum=least,
        maximum=most,
        flags=w.VARIABLE | (w.NULL if nullable else 0),
    )
    inside = least <= value <= most or not nullable
    if draw(st.booleans()):
        descriptor = item(w.PUSH) + descriptor + item(w.POP)
    return Part(descriptor=descriptor, values=[(value, size)], expected=[value if inside else None])


@st.composite
def one_hat(draw: st.DrawFn) -> Part:
    least = draw(st.integers(0, 1))
    count = draw(st.sampled_from((4, 8)))
    value = draw(st.integers(0, 15))
    inside = least <= value < least + count
    return Part(
        descriptor=w.axis(0x39, size=4, minimum=least, maximum=least + count - 1, flags=0x42),
        values=[(value, 4)],
        expected=[value if inside else None],
    )


@st.composite
def some_buttons(draw: st.DrawFn) -> Part:
    first, count = draw(st.integers(1, 40)), draw(st.integers(1, 20))
    values = draw(st.lists(st.integers(0, 1), min_size=count, max_size=count))
    page, size = (0, None) if draw(st.booleans()) else (9 << 16, 4)
    descriptor = item(w.PAGE, 9) + item(w.MINIMUM, 0) + item(w.MAXIMUM, 1)
    descriptor += item(w.SIZE, 1) + item(w.COUNT, count)
    descriptor += item(w.USAGE_MINIMUM, page | first, size)
    descriptor += item(w.USAGE_MAXIMUM, page | (first + count - 1), size)
    return Part(
        descriptor=descriptor + item(w.INPUT, w.VARIABLE),
        values=[(value, 1) for value in values],
        expected=list(values),
    )


@st.composite
def an_array(draw: st.DrawFn) -> Part:
    buttons, elements = draw(st.integers(1, 12)), draw(st.integers(1, 5))
    least = draw(st.integers(-3, 3))
    values = draw(st.lists(st.integers(-8, 7), min_size=elements, max_size=elements))
    if least >= 0:
        values = [value & 15 for value in values]
    descriptor = item(w.PAGE, 9) + w.signed_item(w.MINIMUM, least)
    descriptor += w.signed_item(w.MAXIMUM, least + buttons - 1)
    descriptor += item(w.SIZE, 4) + item(w.COUNT, elements)
    descriptor += item(w.USAGE_MINIMUM, 1) + item(w.USAGE_MAXIMUM, buttons) + item(w.INPUT, 0)
    return Part(
        descriptor=descriptor,
        values=[(value, 4) for value in values],
        expected=[int(least + n in values) for n in range(buttons)],
    )


@st.composite
def some_padding(draw: st.DrawFn) -> Part:
    size = draw(st.integers(1, 17))
    return Part(descriptor=w.padding(size), values=[(draw(st.integers(0, 99)), size)], expected=[])


REPORT = st.lists(
    st.one_of(one_axis(), one_hat(), some_buttons(), an_array(), some_padding()), max_size=6
)


@given(reports=st.lists(REPORT, min_size=1, max_size=3), numbered=st.booleans())
def test_what_is_described_and_sent_is_what_is_decoded(
    *, reports: list[list[Part]], numbered: bool
) -> None:
    if not numbered:
        reports = reports[:1]
    inner = b""
    for report_id, parts in enumerate(reports, 1):
        inner += item(w.REPORT_ID, report_id) if numbered else b""
        inner += b"".join(part.descriptor for part in parts)
    decoder = DeviceDecoder(w.application(inner), vid=0, pid=0)
    first = 0
    for report_id, parts in enumerate(reports, 1):
        sent = w.report(
            (value for part in parts for value in part.values), report_id if numbered else None
        )
        expected = [value for part in parts for value in part.expected]
        assert sorted(decoder.decode(sent)) == list(enumerate(expected, first)), sent.hex()
        first += len(expected)
    assert len(decoder.controls) == first


def try_out(descriptor: bytes, generator: random.Random) -> bool:
    """Decodes what comes; whether there were any controls."""
    try:
        decoder = DeviceDecoder(
            descriptor,
            vid=generator.choice((0, 0x054C, 0x057E)),
            pid=generator.choice((0x2009, 0x09CC, 0x0CE6)),
            bus=generator.choice((3, 5)),
        )
    except DescriptorError:
        return False
    for length in (0, 1, generator.randrange(80)):
        first = bytes([generator.choice((1, 1, 2, 0x11, 0x30, 0x31, 200))])
        report = (first + generator.randbytes(length))[:length]
        for which, value in decoder.decode(report):
            control = decoder.controls[which]
            if control.kind is ControlKind.HAT and value is not None:
                assert control.minimum <= value <= control.maximum
    return decoder.joystick


DATA = {
    w.PAGE: (1, 1, 1, 2, 9, 9, 12, 0xFF00),
    w.MINIMUM: (0, 0, 1, 0x81, 0xFF),
    w.MAXIMUM: (1, 7, 8, 0x7F, 0xFF, 0xFFFF),
    w.SIZE: (1, 1, 4, 8, 8, 10, 16, 32, 33),
    w.REPORT_ID: (1, 1, 2, 0x11, 0x30, 0x31),
    w.COUNT: (1, 1, 2, 5, 16),
    w.USAGE: (0, 4, 5, 0x30, 0x31, 0x32, 0x36, 0x39, 0xC4, 0x10035),
    w.USAGE_MINIMUM: (0, 1, 1, 0x30),
    w.USAGE_MAXIMUM: (1, 8, 0x34, 0xFFFF),
    w.DELIMITER: (0, 1),
    w.INPUT: (0, 1, 2, 2, 2, 6, 0x42),
    w.COLLECTION: (0, 2),
}
"""Data that make sense in items."""


def some_items(generator: random.Random) -> bytes:
    """Items as descriptors have them, in an order that none has; now and then any data."""
    inner, depth, pushed = [], 0, 0
    for _ in range(generator.randrange(50)):
        if generator.random() < 0.05 and (depth or pushed):
            inner.append(item(w.END) if depth else item(w.POP))
            depth, pushed = (depth - 1, pushed) if depth else (0, pushed - 1)
        elif generator.random() < 0.02:
            inner.append(item(w.PUSH))
            pushed += 1
        elif generator.random() < 0.2:
            inner.append(w.axis(generator.choice(DATA[w.USAGE]), size=generator.randrange(1, 34)))
        else:
            prefix = generator.choice((*DATA, w.USAGE, w.INPUT, w.INPUT))
            any_data = generator.random() < 0.01
            data = generator.getrandbits(24) if any_data else generator.choice(DATA[prefix])
            inner.append(item(prefix, data))
            depth += prefix == w.COLLECTION
    return w.application(*inner, *[item(w.END)] * depth, usage=generator.choice((4, 5, 8)))


@pytest.mark.parametrize("count", [400, *in_soak(500_000)])
def test_no_bytes_break_it(count: int) -> None:
    generator, decoded = random.Random(count), 0
    for _ in range(count):
        try_out(generator.randbytes(generator.randrange(120)), generator)
        decoded += try_out(some_items(generator), generator)
    assert decoded > count / 4


@pytest.mark.parametrize("count", [30, *in_soak(20_000)])
@pytest.mark.parametrize("name", NAMES)
def test_no_damage_to_a_real_descriptor_breaks_it(name: str, count: int) -> None:
    whole, generator, decoded = device(name).descriptor, random.Random(name), 0
    for _ in range(count):
        damaged = bytearray(whole)
        for _ in range(generator.randrange(1, 5)):
            place = generator.randrange(len(damaged))
            damaged[place : place + generator.randrange(3)] = generator.randbytes(
                generator.randrange(3)
            )
        decoded += try_out(bytes(damaged), generator)
        try_out(whole[: generator.randrange(len(whole))], generator)
    assert decoded > count / 10 or name == "ion_icade_bt"
