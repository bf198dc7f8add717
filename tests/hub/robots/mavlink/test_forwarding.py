"""Frames for another ground station."""

from __future__ import annotations

from hub.robots.mavlink.forwarding import FrameForwarder
from hub.robots.mavlink.wire.frames import FramePacker


def frames(count: int) -> list[bytes]:
    packer = FramePacker(1, 1)
    return [packer.pack("ATTITUDE", time_boot_ms=number + 1, yaw=1.0) for number in range(count)]


def test_datagrams_have_whole_frames_in_order_wherever_the_stream_is_cut() -> None:
    sent = frames(200)
    stream = b"noise" + b"".join(sent)
    forwarder = FrameForwarder()
    datagrams = [
        each
        for at in range(0, len(stream), 3000)
        for each in forwarder.datagrams(stream[at : at + 3000])
    ]
    assert b"".join(datagrams) == b"".join(sent)
    assert forwarder.passed == 200
    assert max(map(len, datagrams)) <= 1400
    assert len(datagrams) < 20
    starts = {each[:10] for each in sent}
    assert all(each[:10] in starts for each in datagrams)


def test_what_comes_back_is_counted() -> None:
    forwarder = FrameForwarder()
    forwarder.came_back(b"".join(frames(3)) + b"noise")
    assert (forwarder.returned, forwarder.passed) == (3, 0)
