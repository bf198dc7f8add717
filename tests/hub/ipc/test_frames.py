"""Message frames and control frames: round trip, layout, and refusal of everything else."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError, FrameError
from hub.ipc import control, frames
from hub.ipc.codec import compiled
from tests.hub.ipc.trees import values_of

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
    assert back == frames.Frame(name, publisher, fingerprint, sequence, stamp_ns, back.payload)
    assert bytes(back.payload) == payload


@pytest.mark.parametrize("length", range(1, 65))
def test_members_start_at_a_multiple_of_eight_after_any_name(length: int) -> None:
    raw = _frame("n" * length)
    assert (raw.index(b"abcd")) % 8 == 0


def test_frame_has_the_documented_layout() -> None:
    assert _frame("GCM_Stop", b"\0\1\0\0") == (
        b"GCM_Stop" + bytes(8) + struct.pack("<HHIQQqI", 1, 0, 1, 2, 3, 4, 4) + b"\0\1\0\0"
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


@pytest.mark.parametrize("version", [0, 2, 256, 65535])
def test_frame_of_another_version_is_refused_by_its_number(version: int) -> None:
    raw = bytearray(_frame())
    raw[8:10] = struct.pack("<H", version)
    with pytest.raises(FrameError, match=f"version {version}"):
        frames.unpack(bytes(raw))


@pytest.mark.parametrize("start", [b"\0Message", b"1Message", b"Mess\xff\0\0\0", b"a b\0\0\0\0\0"])
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
    kind = draw(st.sampled_from(control.KINDS))
    return kind.decode(b"".join(compiled(kind.format).encode(draw(values_of(kind.tree)))))


@given(_control_messages(), st.data())
def test_control_message_comes_back_and_is_refused_when_cut(
    message: Any, data: st.DataObject
) -> None:
    raw = control.pack(message)
    assert repr(control.unpack(raw)) == repr(message)
    with pytest.raises((FrameError, CodecError)):
        control.unpack(raw[: data.draw(st.integers(0, len(raw) - 1))])


@given(st.binary(max_size=80), st.integers(0, 255))
def test_any_bytes_are_a_control_message_or_refused(raw: bytes, kind: int) -> None:
    for each in (raw, b"RUNE\1" + bytes([kind, 0, 0]) + raw, b"RUNE\1" + bytes([kind, 0, 0])
                 + b"\0\1\0\0" + raw):  # fmt: skip
        try:
            control.unpack(each)
        except (FrameError, CodecError):
            continue


@pytest.mark.parametrize(
    ("raw", "reason"),
    [
        (b"", "no whole preamble"),
        (b"RUNE\1\1\0", "no whole preamble"),
        (b"RUNA\1\1\0\0", "does not start with RUNE"),
        (b"RUNE\2\1\0\0", "version 2"),
        (b"RUNE\1\0\0\0", "unknown kind 0"),
        (b"RUNE\1\x10\0\0", "unknown kind 16"),
    ],
)
def test_wrong_control_preamble_is_refused_with_the_reason(raw: bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        control.unpack(raw)
