"""Coding of grid maps: exact, short, and safe against any bytes."""

from __future__ import annotations

import tracemalloc
import zlib

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError
from hub.gcm import map_coding
from tests.support.cases import for_each

_Map = npt.NDArray[np.int8]


@st.composite
def _maps(draw: st.DrawFn) -> _Map:
    """From noise to one level; with long runs and with none."""
    shape = draw(st.integers(1, 60)), draw(st.integers(1, 60))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    kind = draw(st.sampled_from(["noise", "levels", "flat", "blocks"]))
    if kind == "flat":
        return np.full(shape, draw(st.integers(-128, 127)), np.int8)
    if kind == "noise":
        return random.integers(-128, 128, shape, np.int8)
    levels = random.choice(np.array([-1, 0, 100], np.int8), shape)
    return levels if kind == "levels" else levels.repeat(draw(st.integers(1, 40)), axis=1)


@given(_maps())
def test_map_comes_back_exactly(cells: _Map) -> None:
    back = map_coding.decode(map_coding.encode(cells), *cells.shape)
    assert back.dtype == np.int8
    assert np.array_equal(back, cells)


@given(_maps())
def test_coded_map_is_hardly_longer_than_the_cells(cells: _Map) -> None:
    assert len(map_coding.encode(cells)) <= cells.size + 1 + 11


@given(_maps())
def test_view_that_is_not_contiguous_codes_the_same(cells: _Map) -> None:
    view = cells[::-1, ::2]
    coded = map_coding.encode(view)
    assert np.array_equal(coded, map_coding.encode(view.copy()))
    assert np.array_equal(map_coding.decode(coded, *view.shape), view)


@for_each("length", [1, 65_534, 65_535, 65_536, 131_070, 131_071, 400_000])
def test_runs_of_any_length(length: int) -> None:
    cells = np.zeros((1, length + 1), np.int8)
    cells[0, -1] = 100
    coded = map_coding.encode(cells)
    assert coded[0] == (0 if length == 1 else 1)
    assert np.array_equal(map_coding.decode(coded, 1, length + 1), cells)


def test_noise_is_coded_as_cells_and_rooms_as_runs() -> None:
    noise = np.random.default_rng(1).integers(-1, 101, (50, 50), np.int8)
    assert map_coding.encode(noise)[0] == 0
    assert map_coding.encode(np.zeros((50, 50), np.int8))[0] == 1


@given(st.binary(max_size=200), st.integers(-1, 40), st.integers(-1, 40))
def test_any_bytes_are_a_map_of_the_asked_size_or_refused(
    raw: bytes, height: int, width: int
) -> None:
    for each in (raw, bytes([len(raw) % 3]) + zlib.compress(raw)):
        try:
            cells = map_coding.decode(np.frombuffer(each, np.uint8), height, width)
        except CodecError:
            continue
        assert cells.shape == (height, width)
        assert cells.dtype == np.int8


@given(_maps(), st.data())
def test_coded_map_that_was_damaged_or_cut_is_refused(cells: _Map, data: st.DataObject) -> None:
    """Its check sum sees to that; only the first byte has none, but another way has other bytes."""
    coded = map_coding.encode(cells).copy()
    with pytest.raises(CodecError):
        map_coding.decode(coded[: data.draw(st.integers(0, len(coded) - 1))], *cells.shape)
    place = data.draw(st.integers(3, len(coded) - 1))
    coded[place] ^= 1 << data.draw(st.integers(0, 7))
    try:
        back = map_coding.decode(coded, *cells.shape)
    except CodecError:
        return
    # Bits that deflate leaves unused at the end of its last block may flip.
    assert np.array_equal(back, cells)


@given(_maps())
def test_map_of_another_size_is_refused(cells: _Map) -> None:
    coded = map_coding.encode(cells)
    for height, width in ((cells.shape[0] + 1, cells.shape[1]), (cells.shape[0] - 1, 1)):
        if height * width != cells.size:
            with pytest.raises(CodecError):
                map_coding.decode(coded, height, width)


_BOMB = zlib.compress(bytes(1 << 24), 9)


@for_each(
    ("raw", "height", "width"),
    [
        (b"", 1, 1),
        (b"\0" + _BOMB, 100, 100),
        (b"\1" + _BOMB, 100, 100),
        (b"\1" + zlib.compress(b"\xff\xff" * 1000 + bytes(1000)), 4096, 4096),
        (b"\1" + zlib.compress(b"\xff\xff\0"), 2**40, 2**40),
        (b"\1" + zlib.compress(b"\xff\xff\0"), 4097, 4096),
        (b"\1" + zlib.compress(b"\4\0\0\0"), 2, 2),
        (b"\1" + zlib.compress(b"\4\0\0") + b"more", 2, 2),
        (b"\1" + zlib.compress(b"\4\0\0")[:-1], 2, 2),
        (b"\2" + zlib.compress(b"\4\0\0"), 2, 2),
        (b"\0" + zlib.compress(b"\4\0\0"), 2, 2),
        (b"\1" + zlib.compress(b"\1\0\0"), 0, 1),
        (b"\1" + zlib.compress(b"\1\0\0"), -1, -1),
    ],
)
def test_declared_size_costs_no_memory(raw: bytes, height: int, width: int) -> None:
    coded = np.frombuffer(raw, np.uint8)
    tracemalloc.start()
    try:
        with pytest.raises(CodecError):
            map_coding.decode(coded, height, width)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 100_000


@for_each(
    "cells",
    [
        np.zeros((0, 5), np.int8),
        np.zeros((2, 2, 1), np.int8),
        np.zeros(4, np.int8),
        np.zeros((2, 2), np.uint8),
        np.broadcast_to(np.int8(0), (4097, 4096)),
    ],
)
def test_what_is_no_map_is_refused(cells: _Map) -> None:
    with pytest.raises(CodecError, match="are no map"):
        map_coding.encode(cells)
