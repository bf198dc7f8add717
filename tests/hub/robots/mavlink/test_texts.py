"""Texts of a vehicle: joined, filtered, plain, bounded."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.diagnostics import Severity
from hub.plain_text import is_plain
from hub.robots.mavlink.vehicle.texts import VehicleTexts

FIFTY = "x" * 50


def words(texts):
    return [each.text for each in texts.take()]


def test_a_text_without_a_number_is_whole():
    texts = VehicleTexts()
    texts.add(2, "Arm: Gyros inconsistent", 0, 0, 1.0)
    texts.add(6, "Throttle armed", 0, 0, 1.1)
    first, second = texts.take()
    assert (first.level, first.text) == (Severity.ERROR, "Arm: Gyros inconsistent")
    assert second.level is Severity.OK
    assert texts.take() == []


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0), (0, 1, 1, 2)])
def test_parts_are_joined_in_any_order(order):
    texts = VehicleTexts()
    parts = [FIFTY, "y" * 50, "end"]
    for place in order:
        texts.add(4, parts[place], 7, place, 1.0)
    assert words(texts) == [FIFTY + "y" * 50 + "end"]


def test_a_text_between_parts_does_not_part_them():
    texts = VehicleTexts()
    texts.add(4, FIFTY, 7, 0, 1.0)
    texts.add(4, "another", 0, 0, 1.0)
    texts.add(4, "end", 7, 1, 1.0)
    assert words(texts) == ["another", FIFTY + "end"]


def test_a_missing_part_is_seen_after_a_second():
    texts = VehicleTexts()
    texts.add(4, FIFTY, 7, 0, 1.0)
    texts.add(4, "end", 7, 2, 1.1)
    texts.step(1.9)
    assert words(texts) == []
    texts.step(2.0)
    assert words(texts) == [f"{FIFTY}...end"]


def test_a_text_whose_last_part_is_full_ends_after_a_second():
    texts = VehicleTexts()
    texts.add(4, FIFTY, 7, 0, 1.0)
    texts.step(2.0)
    assert words(texts) == [FIFTY]


def test_repeated_texts_and_floods_are_left_out():
    texts = VehicleTexts()
    for second in range(0, 10, 2):
        texts.add(6, "Field Elevation Set: 0m", 0, 0, float(second))
        texts.add(2, "PreArm: Need Position Estimate", 0, 0, float(second) + 0.1)
        texts.add(2, "PreArm: Need Position Estimate", 0, 0, float(second) + 0.2)
    assert words(texts) == ["PreArm: Need Position Estimate"] * 5
    for number in range(10_000):
        texts.add(2, f"text {number}", 0, 0, 100.0)
    assert len(words(texts)) == 20
    assert texts.left_out == 5 + 9980


def test_escape_sequences_are_shown_as_text():
    texts = VehicleTexts()
    texts.add(0, "\x1b[2J\x1b]0;owned\x07 stop\u202e", 0, 0, 1.0)
    (text,) = words(texts)
    assert text == r"\x1b[2J\x1b]0;owned\x07 stop\u202e"


@given(
    st.lists(
        st.tuples(
            st.integers(0, 255),
            st.text(max_size=60),
            st.integers(0, 65535) | st.integers(0, 6),
            st.integers(0, 255) | st.integers(0, 3),
            st.floats(0.0, 0.7),
        )
    )
)
def test_any_parts_make_short_plain_texts(parts):
    texts = VehicleTexts()
    now = 0.0
    for severity, text, number, part, later in parts:
        now += later
        texts.add(severity, text, number, part, now)
        texts.step(now)
    assert len(texts.since(0.0)) <= 50
    assert all(is_plain(each.text) and len(each.text) <= 400 for each in texts.take())
