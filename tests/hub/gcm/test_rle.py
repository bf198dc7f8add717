"""Run-length coding: exact, never much longer than raw, and safe against any bytes."""

from __future__ import annotations

import tracemalloc

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError
from hub.gcm import rle
from tests.support.cases import for_each

_Pixels = npt.NDArray[np.uint8]


@st.composite
def _pictures(draw: st.DrawFn) -> _Pixels:
    """From noise to one colour, grey with and without a third axis, up to four channels."""
    shape: tuple[int, ...] = (draw(st.integers(1, 40)), draw(st.integers(1, 40)))
    channels = draw(st.sampled_from([None, 1, 2, 3, 4]))
    shape += () if channels is None else (channels,)
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    kind = draw(st.sampled_from(["noise", "flat", "columns", "blocks"]))
    if kind == "flat":
        return np.full(shape, draw(st.integers(0, 255)), np.uint8)
    noise = random.integers(0, draw(st.sampled_from([2, 256])), shape, np.uint8)
    if kind == "columns":
        noise[:] = noise[0]
    elif kind == "blocks":
        noise = noise.repeat(draw(st.integers(1, 20)), axis=1)
    return noise


def _decoded(coded: _Pixels, like: _Pixels) -> _Pixels:
    channels = like.shape[2] if like.ndim == 3 else 1
    return rle.decode(coded, like.shape[0], like.shape[1], channels).reshape(like.shape)


@given(_pictures())
def test_full_quality_is_exact(picture: _Pixels) -> None:
    before = picture.copy()
    assert np.array_equal(_decoded(rle.encode(picture), picture), picture)
    assert np.array_equal(picture, before)


@given(_pictures(), st.integers(-5, 120))
def test_coded_picture_is_never_longer_than_raw_and_one_byte(
    picture: _Pixels, quality: int
) -> None:
    assert len(rle.encode(picture, quality=quality)) <= picture.size + 1


@given(_pictures(), st.integers(1, 99))
def test_error_below_full_quality_is_bounded(picture: _Pixels, quality: int) -> None:
    """Kept bits a channel go from 8 down to 3: half of what was dropped is the largest error."""
    dropped = 5 - quality * 5 // 100
    decoded = _decoded(rle.encode(picture, quality=quality), picture)
    error = np.abs(decoded.astype(int) - picture)
    assert error.max() <= (1 << dropped) // 2


def test_less_quality_makes_a_natural_picture_shorter() -> None:
    rows, columns = np.mgrid[0:120, 0:160]
    picture = (rows + columns // 2).astype(np.uint8)[..., None].repeat(3, axis=2)
    picture += np.random.default_rng(0).integers(0, 3, picture.shape, np.uint8)
    lengths = [len(rle.encode(picture, quality=quality)) for quality in (20, 60, 100)]
    assert lengths == sorted(lengths)
    assert lengths[0] < picture.size / 4


@given(_pictures())
def test_view_that_is_not_contiguous_codes_the_same(picture: _Pixels) -> None:
    view = picture[::-1, ::2]
    assert np.array_equal(_decoded(rle.encode(view), view), view)


@for_each("length", [1, 254, 255, 256, 509, 510, 511, 1020, 100_000])
def test_runs_of_any_length(length: int) -> None:
    picture = np.zeros((1, length + 1), np.uint8)
    picture[0, -1] = 1
    assert np.array_equal(_decoded(rle.encode(picture), picture), picture)


@given(st.binary(max_size=300), st.integers(-1, 40), st.integers(-1, 40), st.integers(-1, 6))
def test_any_bytes_are_a_picture_of_the_asked_size_or_refused(
    raw: bytes, height: int, width: int, channels: int
) -> None:
    for each in (raw, bytes([len(raw) % 3]) + raw):
        try:
            picture = rle.decode(np.frombuffer(each, np.uint8), height, width, channels)
        except CodecError:
            continue
        assert picture.shape == (height, width, channels)
        assert picture.dtype == np.uint8


@given(_pictures(), st.data())
def test_coded_picture_that_was_damaged_is_a_picture_or_refused(
    picture: _Pixels, data: st.DataObject
) -> None:
    coded = rle.encode(picture)
    coded[data.draw(st.integers(0, len(coded) - 1))] ^= data.draw(st.integers(1, 255))
    try:
        assert _decoded(coded, picture).shape == picture.shape
    except CodecError:
        return


@given(_pictures(), st.data())
def test_coded_picture_that_was_cut_is_refused(picture: _Pixels, data: st.DataObject) -> None:
    coded = rle.encode(picture)
    with pytest.raises(CodecError):
        _decoded(coded[: data.draw(st.integers(0, len(coded) - 1))], picture)


@for_each(
    ("raw", "height", "width"),
    [
        (b"", 1, 1),
        (b"\1\xff\0", 100_000, 100_000),
        (b"\2\xff\xff\0\0", 2**40, 2**40),
        (b"\0", 2**31, 2**31),
        (b"\1" + b"\xff" * 100 + b"\0" * 100, 160, 160),
        (b"\1\0\0", 1, 1),
        (b"\3\1\0", 1, 1),
        (b"\1\1\0", 0, 1),
        (b"\1\1\0", -1, -1),
    ],
)
def test_declared_size_costs_no_memory(raw: bytes, height: int, width: int) -> None:
    coded = np.frombuffer(raw, np.uint8)
    tracemalloc.start()
    try:
        with pytest.raises(CodecError):
            rle.decode(coded, height, width, 1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 50_000


@for_each(
    "pixels",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros((5, 0, 3), np.uint8),
        np.zeros((2, 2, 5), np.uint8),
        np.zeros((2, 2, 3, 1), np.uint8),
        np.zeros(4, np.uint8),
        np.zeros((2, 2), np.float32),
    ],
)
def test_what_is_no_picture_is_refused(pixels: _Pixels) -> None:
    with pytest.raises(CodecError, match="no picture"):
        rle.encode(pixels)
