"""Rings of shared memory: what is read is whole or nothing, and nobody can be led astray."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import FrameError
from hub.ipc.transport.shared_ring import Place, RingReader, RingWriter, available
from tests.support.repetitions import repetitions

pytestmark = pytest.mark.skipif(not available, reason="this system has no anonymous files")


@pytest.fixture
def writer() -> Iterator[RingWriter]:
    made = RingWriter(1000)
    yield made
    made.close()


def test_payload_comes_back_joined_and_aligned(writer: RingWriter) -> None:
    place = writer.write([b"\0\1\0\0", memoryview(bytes(range(200))), np.arange(3.0)])
    reader = RingReader(place)
    payload = reader.read(place)
    assert payload == b"\0\1\0\0" + bytes(range(200)) + np.arange(3.0).tobytes()
    assert np.frombuffer(payload, np.uint8, 8, 4).ctypes.data % 8 == 0
    assert writer.read(place) == payload
    reader.close()


def test_overwritten_payload_is_not_read(writer: RingWriter) -> None:
    places = [writer.write([str(number).encode()]) for number in range(200)]
    reader = RingReader(places[-1])
    found = [reader.read(place) for place in places]
    kept = [bytes(payload) for payload in found if payload is not None]
    assert kept == [str(number).encode() for number in range(200 - len(kept), 200)]
    assert 0 < len(kept) < 64
    reader.close()


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 1))
def test_forged_descriptor_reads_nothing_outside(generation: int, start: int, length: int) -> None:
    writer = RingWriter(100)
    try:
        true = writer.write([b"truth"])
        forged = Place(
            process=true.process,
            file=true.file,
            ring=true.ring,
            generation=generation,
            start=start,
            length=length,
        )
        reader = RingReader(true)
        for place in (forged, Place.unpack(forged.pack())):
            payload = reader.read(place)
            assert payload is None or len(payload) == length
        reader.close()
    finally:
        writer.close()


@given(st.binary(max_size=60))
def test_any_bytes_are_a_descriptor_or_refused(raw: bytes) -> None:
    try:
        assert Place.unpack(raw).pack() == raw
    except FrameError:
        assert len(raw) != 36


def test_another_file_under_the_same_number_is_not_taken_for_the_ring(
    writer: RingWriter, tmp_path: object
) -> None:
    place = writer.write([b"x"])
    del tmp_path
    read, write = os.pipe()
    unsealed = os.memfd_create("rune-ring")
    os.write(unsealed, bytes(10_000))
    try:
        for file in (read, unsealed, 1_000_000):
            for ring in (place.ring, os.fstat(unsealed).st_ino):
                wrong = Place(
                    process=os.getpid(), file=file, ring=ring, generation=1, start=0, length=1
                )
                with pytest.raises(OSError):  # noqa: PT011 - whatever the system says
                    RingReader(wrong)
    finally:
        for file in (read, write, unsealed):
            os.close(file)


def test_ring_cannot_be_cut_off_under_its_readers(writer: RingWriter) -> None:
    place = writer.write([b"x"])
    with pytest.raises(PermissionError):
        os.truncate(f"/proc/{place.process}/fd/{place.file}", 0)


def test_ring_is_freed_by_its_writer_and_stays_readable_for_who_has_it() -> None:
    writer = RingWriter(100)
    place = writer.write([b"still here"])
    reader = RingReader(place)
    writer.close()
    assert reader.read(place) == b"still here"
    with pytest.raises(OSError):  # noqa: PT011
        RingReader(place)
    reader.close()


def test_no_reader_ever_sees_half_a_payload() -> None:
    """One thread writes while another reads; each payload is the same byte throughout."""
    writer = RingWriter(40_000)
    places: list[Place] = [writer.write([bytes(40_000)])]
    done = threading.Event()

    def write() -> None:
        number = 0
        while not done.is_set():
            number += 1
            places.append(writer.write([bytes([number % 256]) * 40_000]))

    thread = threading.Thread(target=write)
    thread.start()
    reader = RingReader(places[0])
    read = 0
    try:
        while read < repetitions(100, 2000):
            payload = reader.read(places[-1])
            if payload is not None:
                assert len(set(bytes(payload))) == 1
                read += 1
    finally:
        done.set()
        thread.join()
        reader.close()
        writer.close()
