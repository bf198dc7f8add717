"""ZMTP as an inbox reads it: any bytes, in pieces of any length."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import FrameError
from hub.ipc.wire import zmtp
from hub.ipc.wire.frames import MAX_FRAME

SENT = zmtp.GREETING + zmtp.command(b"READY", b"\x0bSocket-Type\x00\x00\x00\x04PUSH")


def framed(message: bytes, *, long: bool) -> bytes:
    if long or len(message) > 255:
        return b"\x02" + len(message).to_bytes(8, "big") + message
    return bytes([0, len(message)]) + message


def read(stream: zmtp.Stream, pieces: list[bytes]) -> list[bytes]:
    found = []
    for piece in pieces:
        data, places = stream.feed(piece)
        found += [data[a:b] for a, b in zip(places[::2], places[1::2], strict=True)]
    return found


def cut(whole: bytes, at: list[int]) -> list[bytes]:
    places = [0, *sorted(each % (len(whole) + 1) for each in at), len(whole)]
    return [whole[a:b] for a, b in itertools.pairwise(places)]


MESSAGES = st.lists(st.tuples(st.binary(max_size=600), st.booleans()), max_size=8)


@given(MESSAGES, st.lists(st.integers(0, 1 << 16), max_size=12))
def test_messages_come_whole_and_in_order_however_they_are_cut(
    messages: list[tuple[bytes, bool]], at: list[int]
) -> None:
    whole = SENT + b"".join(framed(message, long=long) for message, long in messages)
    stream = zmtp.Stream()
    assert read(stream, cut(whole, at)) == [message for message, _ in messages]
    assert stream.ready


@given(
    st.binary(max_size=300),
    st.lists(st.integers(0, 1 << 16), max_size=4),
    st.sampled_from((b"", SENT)),
)
def test_rubbish_gives_messages_or_one_error(rubbish: bytes, at: list[int], before: bytes) -> None:
    stream = zmtp.Stream()
    try:
        found = read(stream, cut(before + rubbish, at))
    except FrameError:
        return
    assert sum(map(len, found)) <= len(rubbish)


def test_a_ping_is_answered_with_its_context() -> None:
    stream = zmtp.Stream()
    _, places = stream.feed(SENT + zmtp.command(b"PING", b"\x00\x0aabc"))
    assert not places
    assert stream.answer() == zmtp.command(b"PONG", b"abc")
    assert stream.answer() == b""


@pytest.mark.parametrize(
    ("sent", "reason"),
    [
        (bytes(64), "no greeting"),
        (zmtp.GREETING.replace(b"NULL\0", b"CURVE"), "no greeting"),
        (zmtp.GREETING + b"\x00\x01x", "before READY"),
        (zmtp.GREETING + zmtp.command(b"ERROR", b"\x00"), "instead of READY"),
        (SENT + b"\x02" + (MAX_FRAME + 1).to_bytes(8, "big"), "is announced"),
    ],
)
def test_what_is_no_push_socket_is_refused(sent: bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        zmtp.Stream().feed(sent)
