"""Message frames and control frames: round trip, layout, and refusal of everything else."""

from __future__ import annotations

import contextlib
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError, FrameError
from hub.ipc.formats.codec import compiled
from hub.ipc.wire import control_codec, frames
from tests.hub.ipc.formats.trees import values_of
from tests.support.cases import for_each

_NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,63}", fullmatch=True)
_U64 = st.integers(0, 2**64 - 1)


def _frame(name: str = "Message", payload: bytes = b"\0\1\0\0abcd") -> bytes:
    return frames.pack(
        frames.prefix(name),
        publisher=1,
        fingerprint=2,
        sequence=3,
        stamp_ns=4,
        payload=[payload[:3], payload[3:]],
    )


@given(_NAMES, st.integers(0, 2**32 - 1), _U64, _U64, st.integers(-(2**63), 2**63 - 1), st.binary())
def test_frame_comes_back_as_it_was(
    name: str, publisher: int, fingerprint: int, sequence: int, stamp_ns: int, payload: bytes
) -> None:
    raw = frames.pack(
        frames.prefix(name),
        publisher=publisher,
        fingerprint=fingerprint,
        sequence=sequence,
        stamp_ns=stamp_ns,
        payload=[payload],
    )
    back = frames.unpack(raw)
    assert back == frames.Frame(
        name, frames.INLINE, publisher, fingerprint, sequence, stamp_ns, back.payload
    )
    assert bytes(back.payload) == payload


def test_members_start_at_a_multiple_of_eight_after_any_name() -> None:
    starts = {length: _frame("n" * length).index(b"abcd") for length in range(1, 65)}
    assert {length: start for length, start in starts.items() if start % 8} == {}


def test_frame_has_the_documented_layout() -> None:
    assert _frame("GCM_Stop", b"\0\1\0\0") == (
        b"GCM_Stop" + bytes(8) + struct.pack("<HHIQQqI", 6, 0, 1, 2, 3, 4, 4) + b"\0\1\0\0"
    )


def test_topic_selects_one_name_and_no_longer_one() -> None:
    assert _frame("GCM_Stop").startswith(frames.topic("GCM_Stop"))
    assert not _frame("GCM_Stopped").startswith(frames.topic("GCM_Stop"))


def test_frame_cut_anywhere_is_refused() -> None:
    raw = _frame()
    for length in range(len(raw)):
        with pytest.raises(FrameError):
            frames.unpack(raw[:length])
    with pytest.raises(FrameError):
        frames.unpack(raw + b"\0")


@for_each("version", [0, 1, 2, 256, 65535])
def test_frame_of_another_version_is_refused_by_its_number(version: int) -> None:
    raw = bytearray(_frame())
    raw[8:10] = struct.pack("<H", version)
    with pytest.raises(FrameError, match=f"version {version}"):
        frames.unpack(bytes(raw))


@for_each("start", [b"\0Message", b"1Message", b"Mess\xff\0\0\0", b"a b\0\0\0\0\0"])
def test_frame_without_a_message_name_is_refused(start: bytes) -> None:
    with pytest.raises(FrameError):
        frames.unpack(start + _frame()[8:])


def test_name_padding_must_be_empty() -> None:
    raw = bytearray(_frame("abc"))
    raw[6] = 1
    with pytest.raises(FrameError):
        frames.unpack(bytes(raw))


@given(st.binary(max_size=200), st.binary(max_size=60))
def test_any_bytes_are_a_frame_or_refused(raw: bytes, rest: bytes) -> None:
    for each in (raw, b"Message\0" + raw, _frame()[:20] + rest, b"x" * 70 + raw):
        try:
            frames.unpack(each)
        except FrameError:
            continue


@st.composite
def _control_messages(draw: st.DrawFn) -> Any:
    kind = draw(st.sampled_from(control_codec.KINDS))
    return kind.decode(b"".join(compiled(kind.wire_format).encode(draw(values_of(kind.tree)))))


@given(_control_messages(), st.data())
def test_control_message_comes_back_and_is_refused_when_cut(
    message: Any, data: st.DataObject
) -> None:
    raw = control_codec.pack(message)
    assert repr(control_codec.unpack(raw)) == repr(message)
    with pytest.raises((FrameError, CodecError)):
        control_codec.unpack(raw[: data.draw(st.integers(0, len(raw) - 1))])


@given(st.binary(max_size=80), st.integers(0, 255))
def test_any_bytes_are_a_control_message_or_refused(raw: bytes, kind: int) -> None:
    for each in (raw, b"RUNE\6" + bytes([kind, 0, 0]) + raw, b"RUNE\6" + bytes([kind, 0, 0])
                 + b"\0\1\0\0" + raw):  # fmt: skip
        try:
            control_codec.unpack(each)
        except (FrameError, CodecError):
            continue


@for_each(
    ("raw", "reason"),
    [
        (b"", "no whole preamble"),
        (b"RUNE\6\1\0", "no whole preamble"),
        (b"RUNA\2\1\0\0", "does not start with RUNE"),
        (b"RUNE\1\1\0\0", "version 1"),
        (b"RUNE\6\0\0\0", "unknown kind 0"),
        (b"RUNE\6\x60\0\0", "unknown kind 96"),
    ],
)
def test_wrong_control_preamble_is_refused_with_the_reason(raw: bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        control_codec.unpack(raw)


def test_topic_of_a_descriptor_carries_descriptors_alone() -> None:
    def made(kind: int, *, in_ring: bool) -> bytes:
        return frames.pack(
            frames.prefix("Message", frames.RING if in_ring else b""),
            publisher=1,
            fingerprint=2,
            sequence=3,
            stamp_ns=4,
            payload=[b"x"],
            kind=kind,
        )

    assert frames.unpack(made(frames.IN_RING, in_ring=True)).kind == frames.IN_RING
    assert frames.unpack(made(frames.BATCH, in_ring=False)).kind == frames.BATCH
    for kind, in_ring in ((frames.INLINE, True), (frames.IN_RING, False), (5, False)):
        with pytest.raises(FrameError, match="topic does not carry"):
            frames.unpack(made(kind, in_ring=in_ring))


@given(st.lists(st.binary(max_size=40), max_size=9), st.integers(1, 5))
def test_frames_of_a_train_come_back_and_a_damaged_one_is_refused(
    whole: list[bytes], cut: int
) -> None:
    raw = frames.bundle(whole)
    assert frames.is_bundle(raw)
    assert frames.split_bundle(raw) == whole
    if raw[:-cut] and raw[:-cut] != b"*":
        with contextlib.suppress(FrameError):
            assert frames.split_bundle(raw[:-cut]) == whole[: len(frames.split_bundle(raw[:-cut]))]
    with pytest.raises(FrameError, match="ends inside a frame"):
        frames.split_bundle(raw + b"\xff" * 4)


@pytest.mark.parametrize("kind", [b"", frames.FAR])
def test_a_topic_says_whether_its_publisher_has_neighbours(kind: bytes) -> None:
    raw = frames.pack(
        frames.prefix("Message", kind),
        publisher=1,
        fingerprint=2,
        sequence=3,
        stamp_ns=4,
        payload=[b"x"],
    )
    assert raw.startswith(frames.topic("Message", kind))
    assert frames.unpack(raw).name == "Message"


@given(st.lists(st.tuples(st.integers(-(2**63), 2**63 - 1), st.binary(max_size=40)), max_size=9))
def test_messages_of_a_batch_come_back(messages: list[tuple[int, bytes]]) -> None:
    packed = [frames.pack_item(stamp, [payload[:1], payload[1:]]) for stamp, payload in messages]
    whole = memoryview(b"".join(frames.batch(packed)))
    assert [(stamp, bytes(payload)) for stamp, payload in frames.items(whole)] == messages
    assert frames.count(whole) == len(messages)
    for item, (stamp, payload) in zip(packed, messages, strict=True):
        assert len(item) % 8 == 0
        assert frames.item_payload(item) == (stamp, payload)


@given(st.binary(max_size=120), st.lists(st.binary(max_size=20), max_size=4), st.data())
def test_any_bytes_are_a_batch_or_refused(
    raw: bytes, payloads: list[bytes], data: st.DataObject
) -> None:
    good = b"".join(frames.batch([frames.pack_item(1, [payload]) for payload in payloads]))
    place = data.draw(st.integers(0, len(good) - 1))
    flipped = good[:place] + bytes([good[place] ^ 1 << place % 8]) + good[place + 1 :]
    for each in (raw, good[:place], flipped, good + raw):
        try:
            frames.items(memoryview(each))
        except FrameError:
            continue


def test_flat_frames_are_those_of_the_long_way_and_read_them() -> None:
    form = compiled("{ulong,double,{short,int}}")
    flat = frames.FlatFrames(frames.prefix("Flat"), form.fingerprint, form.flat_letters or "")
    numbers = (7, 0.5, -3, 9)
    payload = b"".join(form.encode((7, 0.5, (-3, 9))))
    raw = flat.pack(1, 2, 3, numbers)
    header = {"publisher": 1, "fingerprint": form.fingerprint, "sequence": 2, "stamp_ns": 3}
    assert raw == frames.pack(frames.prefix("Flat"), payload=[payload], **header)
    assert flat.pack_item(3, numbers) == frames.pack_item(3, [payload])
    assert flat.values(memoryview(payload)) == numbers
    assert flat.values(memoryview(payload + b"\0")) is None
    assert flat.values(memoryview(b"\0\0" + payload[2:])) is None
    batch = b"".join(frames.batch([flat.pack_item(3, numbers)] * 2))
    assert flat.items(memoryview(batch)) == [(3, numbers)] * 2
    for wrong in (batch[:-8], b"\3" + batch[1:], batch[:16] + b"\1" + batch[17:]):
        assert flat.items(memoryview(wrong)) is None
