"""Spans of time, sizes and rates, as people write them."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.recording.live import words
from hub.toml_reader import RefusedError
from tests.support.cases import for_each


@for_each(
    ("read", "text", "value"),
    [
        (words.seconds_of, "2h", 7200.0),
        (words.seconds_of, "10 min", 600.0),
        (words.seconds_of, "90", 90.0),
        (words.seconds_of, 1.5, 1.5),
        (words.seconds_of, "1 d", 86_400.0),
        (words.bytes_of, "8 GiB", 8 * 2**30),
        (words.bytes_of, "500 MB", 500_000_000),
        (words.bytes_of, "1.5kB", 1500),
        (words.rate_of, "5/s", 5.0),
        (words.rate_of, "0.5 Hz", 0.5),
        (words.rate_of, 0, 0.0),
        (words.split_of, "10 min", (600.0, 0)),
        (words.split_of, "500 MB", (0.0, 500_000_000)),
        (words.size_of, "320x240", (320, 240)),
        (words.size_of, [64, 48], (64, 48)),
    ],
)
def test_words_have_their_value(read, text, value) -> None:
    assert read(text) == value


@for_each(
    ("read", "text"),
    [
        (words.seconds_of, "two hours"),
        (words.seconds_of, "-1 s"),
        (words.seconds_of, "2 GiB"),
        (words.seconds_of, "400 d"),
        (words.seconds_of, True),
        (words.seconds_of, float("nan")),
        (words.bytes_of, "10 min"),
        (words.bytes_of, "9999999 TiB"),
        (words.rate_of, "101"),
        (words.split_of, "0"),
        (words.split_of, "often"),
        (words.split_of, "1B"),
        (words.file_bytes_of, "0 B"),
        (words.file_bytes_of, "999 kB"),
        (words.size_of, "320"),
        (words.size_of, "0x240"),
        (words.size_of, [1, 2, 3]),
        (words.size_of, "99999x1"),
        (words.pattern_of, "a("),
        (words.pattern_of, ""),
        (words.pattern_of, 5),
    ],
)
def test_other_words_are_refused(read, text) -> None:
    with pytest.raises(RefusedError):
        read(text)


@given(value=st.one_of(st.text(max_size=50), st.integers(), st.floats(), st.none(), st.binary()))
def test_anything_is_read_or_refused(value) -> None:
    for read in (words.seconds_of, words.bytes_of, words.rate_of, words.split_of, words.size_of):
        with contextlib.suppress(RefusedError):
            read(value)
