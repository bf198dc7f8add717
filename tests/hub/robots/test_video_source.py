"""What a robot file may name as the source of pictures, and the words when none come."""

from __future__ import annotations

import errno
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CameraError
from hub.robots.video_reader import taken
from hub.robots.video_source import Pace, SourceKind, video_source, why_not
from tests.support.cases import for_each


@for_each(
    ("text", "kind", "shown"),
    [
        ("/dev/video0", SourceKind.DEVICE, "/dev/video0"),
        ("/srv/drive.mp4", SourceKind.FILE, "/srv/drive.mp4"),
        ("rtsp://10.0.0.7/stream", SourceKind.STREAM, "rtsp://10.0.0.7/stream"),
        ("http://me:secret@cam:80/a@b", SourceKind.STREAM, "http://cam:80/a@b"),
    ],
)
def test_sources_are_told_apart_and_shown_without_passwords(
    text: str, kind: SourceKind, shown: str
) -> None:
    source = video_source(text)
    assert (source.kind, source.shown, source.address) == (kind, shown, text)
    assert source.live is (kind is not SourceKind.FILE)


@for_each("text", ["file:///etc/passwd", "concat://a", "://", "RTSP ://x"])
def test_other_kinds_of_addresses_are_refused(text: str) -> None:
    with pytest.raises(
        CameraError, match="begins with one of rtsp://, rtsps://, http://, https://"
    ):
        video_source(text)


@for_each(
    ("number", "what_to_do"),
    [
        (errno.ENOENT, "plug it in, or correct 'source'"),
        (errno.ENODEV, "plug it in"),
        (errno.EACCES, "add the user to the group"),
        (errno.EBUSY, "end that program"),
        (errno.ENOTTY, "gives no pictures: " + os.strerror(errno.ENOTTY)),
    ],
)
def test_trouble_with_a_device_says_what_to_do(number: int, what_to_do: str) -> None:
    said = why_not(video_source("/dev/video3"), OSError(number, os.strerror(number)))
    assert said.startswith("the camera /dev/video3 ")
    assert what_to_do in said


def test_no_message_tells_the_password() -> None:
    source = video_source("rtsp://me:secret@cam/x")
    for fault in (OSError(errno.EIO, "bad", source.address), ValueError(f"no {source.address}")):
        said = why_not(source, fault)
        assert "secret" not in said
        assert "rtsp://cam/x" in said


def test_a_file_runs_at_its_own_speed() -> None:
    pace = Pace(0.04)
    assert pace.delay(5.0, 100.0) == 0.0
    assert pace.delay(5.1, 100.02) == pytest.approx(0.08)
    assert pace.delay(5.2, 100.15) == pytest.approx(0.05)


def test_a_file_that_begins_anew_goes_on_after_one_period() -> None:
    pace = Pace(0.04)
    pace.delay(0.0, 100.0)
    assert pace.delay(0.5, 100.1) == pytest.approx(0.4)
    assert pace.delay(0.0, 100.5) == pytest.approx(0.04)
    assert pace.delay(0.1, 100.54) == pytest.approx(0.1)


def test_pictures_without_times_come_one_a_period() -> None:
    pace = Pace(0.04)
    pace.delay(None, 100.0)
    assert pace.delay(None, 100.01) == pytest.approx(0.03)
    assert pace.delay(float("nan"), 100.04) == pytest.approx(0.04)


def test_a_file_that_was_held_up_does_not_hurry() -> None:
    pace = Pace(0.04)
    pace.delay(0.0, 100.0)
    assert pace.delay(0.1, 107.0) == 0.0
    assert pace.delay(0.2, 107.0) == pytest.approx(0.1)


TIMES = st.one_of(st.none(), st.floats(allow_nan=True, allow_infinity=True))


@given(times=st.lists(TIMES, max_size=20))
def test_no_times_in_a_file_make_anybody_wait_long(times: list[float | None]) -> None:
    pace = Pace(0.04)
    now = 1000.0
    for time in times:
        delay = pace.delay(time, now)
        assert 0.0 <= delay <= 1.0
        now += delay


def test_a_camera_s_own_time_counts_where_it_is_on_our_clock() -> None:
    assert taken(99.9, 100.0) == 99.9
    assert taken(None, 100.0) == 100.0
    assert taken(1.7e9, 100.0) == 100.0  # since the epoch
    assert taken(0.5, 100.0) == 100.0  # since it was opened


@for_each(
    ("text", "address", "codec", "local"),
    [
        ("rtp://0.0.0.0:5600", "rtp://0.0.0.0:5600", "H264", ""),
        ("rtp://:5600", "rtp://127.0.0.1:5600", "H264", "127.0.0.1"),
        ("rtp://192.168.2.1:5600?codec=h265", "rtp://192.168.2.1:5600", "H265", "192.168.2.1"),
        ("udp://[::1]:5600", "udp://[::1]:5600", "", "::1"),
        ("udp://239.0.0.1:5600", "udp://239.0.0.1:5600", "", ""),
    ],
)
def test_datagrams_come_to_an_address_of_this_machine(
    text: str, address: str, codec: str, local: str
) -> None:
    source = video_source(text)
    assert (source.kind, source.shown, source.address) == (SourceKind.STREAM, text, address)
    assert source.options.get("localaddr", "") == local
    assert f" {codec}/90000\n" in source.session if codec else not source.session


@for_each(
    "text",
    [
        *("rtp://", "udp://:0", "udp://0.0.0.0:99999", "udp://camera:5600", "rtp://0.0.0.0"),
        *("udp://:5600/x", "udp://:5600?codec=h265", "rtp://:5600?codec=vp8", "rtp://u@:5600#x"),
        *("udp://:5600?localaddr=0.0.0.0&pkt_size=1", "rtp://:5600\r\na=x", "udp://[::1:5600"),
    ],
)
def test_an_address_for_datagrams_has_an_own_address_and_a_port(text: str) -> None:
    with pytest.raises(CameraError, match="give an address of this machine and a port"):
        video_source(text)
