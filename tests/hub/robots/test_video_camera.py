"""A real camera's way: files and streams that PyAV makes, lost and found again."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from hub.errors import CameraError
from hub.gcm.vision import CameraCommand
from hub.robots.interfaces import Picture
from hub.robots.video_camera import VideoCamera
from hub.robots.video_reader import VideoReader
from hub.robots.video_source import video_source
from hub.sim.spatial_pose import SpatialPose
from tests.hub.robots.videos import CameraServer, frame_of, jpeg_of, make_video
from tests.support.waiting import until

pytest.importorskip("av", reason="PyAV is not installed: pip install 'robot-user-nexus[camera]'")

Open = Callable[[str], VideoCamera]


@pytest.fixture
def open_camera() -> Iterator[Open]:
    opened: list[VideoCamera] = []

    def open_it(source: str) -> VideoCamera:
        camera = VideoCamera(source, horizontal_fov=1.2, forward=0.1, height=0.4)
        opened.append(camera)
        return camera

    yield open_it
    for camera in opened:
        camera.close()


def first(camera: VideoCamera, width_px: int = 9999, height_px: int = 9999) -> Picture:
    """The first picture that comes."""
    taken: list[Picture] = []

    def comes() -> bool:
        try:
            taken.append(camera.take(width_px, height_px, 0.0))
        except CameraError:
            return False
        return True

    until(comes, 10.0, lambda: trouble(camera))
    return taken[0]


def trouble(camera: VideoCamera) -> str:
    """What a request is told; empty if it gets a picture."""
    try:
        camera.take(1, 1, 0.0)
    except CameraError as error:
        return str(error)
    return ""


def test_a_file_gives_its_pictures_in_its_colours(open_camera: Open, tmp_path: Path) -> None:
    camera = open_camera(str(make_video(tmp_path / "drive.mp4")))
    picture = first(camera)
    assert picture.pixels.shape == (96, 128, 3)
    assert picture.pixels.dtype == np.uint8
    assert np.abs(picture.pixels[70, 10].astype(int) - (220, 30, 30)).max() < 20
    assert np.abs(picture.pixels[70, 110].astype(int) - (30, 30, 220)).max() < 20


@pytest.mark.parametrize("size", [(64, 48), (32, 24), (20, 90), (128, 7), (1, 1), (127, 95)])
def test_pictures_have_the_size_that_was_asked_for(
    open_camera: Open, tmp_path: Path, size: tuple[int, int]
) -> None:
    camera = open_camera(str(make_video(tmp_path / "drive.mp4")))
    picture = first(camera, *size)
    assert picture.pixels.shape == (size[1], size[0], 3)
    # The middle of the picture is where red and blue meet.
    if size[0] > 8:
        assert picture.pixels[-1, 1, 0] > 150
        assert picture.pixels[-1, -2, 2] > 150
    assert (picture.horizontal_fov < 1.2) == (size[0] * 96 < size[1] * 128)


def test_shrinking_takes_the_mean_of_what_it_leaves_out(open_camera: Open, tmp_path: Path) -> None:
    stripes = np.zeros((96, 128, 3), np.uint8)
    stripes[:, ::2] = 255
    camera = open_camera(str(make_video(tmp_path / "stripes.mkv", [stripes] * 5, codec="ffv1")))
    small = first(camera, 32, 24).pixels
    assert np.abs(small[:, 2:-2].astype(int) - 127).max() < 12


def test_a_file_begins_anew_when_it_ends(open_camera: Open, tmp_path: Path) -> None:
    camera = open_camera(str(make_video(tmp_path / "short.mp4", count=5, rate=50)))
    first(camera)
    seen: list[float] = []

    def darker_again() -> bool:
        # There is no moment without a picture.
        brightness = float(camera.take(128, 96, 0.0).pixels[:20].mean())
        seen.append(brightness)
        return brightness < max(seen) - 30

    for _ in range(3):
        seen.clear()
        until(darker_again, 10.0)


def test_a_still_picture_is_a_file_too(open_camera: Open, tmp_path: Path) -> None:
    path = tmp_path / "still.jpg"
    path.write_bytes(jpeg_of(frame_of(0)))
    assert first(open_camera(str(path))).pixels.shape == (96, 128, 3)


def test_a_camera_that_stands_still_says_so(open_camera: Open, tmp_path: Path) -> None:
    camera = open_camera(str(make_video(tmp_path / "drive.mp4")))
    camera.move(CameraCommand(pan=1.0))
    camera.set_headlight(1.0)
    camera.place(SpatialPose(x=1.0, y=1.0, yaw=1.0), 1.0)
    camera.advance(1.0)
    state = camera.camera_state(5.0)
    assert (state.stamp, state.pan, state.tilt, state.zoom, state.slewing) == (5.0, 0, 0, 0, 0)
    assert (state.pan_limit, state.tilt_limit) == (0.0, 0.0)
    assert (state.horizontal_fov, state.mount_forward, state.mount_height) == (1.2, 0.1, 0.4)
    assert np.isnan(state.headlight)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (str, "No such file or directory; correct 'source' under"),
        (lambda path: path.mkdir(), "Is a directory"),
        (lambda path: path.write_bytes(b"no video " * 99), "cannot be shown: Invalid data"),
        (lambda path: path.write_bytes(b""), "cannot be shown: "),
    ],
    ids=["missing", "folder", "text", "empty"],
)
def test_a_file_that_is_no_video_is_told_in_one_sentence(
    open_camera: Open, tmp_path: Path, make: Callable[[Path], object], why: str
) -> None:
    path = tmp_path / "drive.mp4"
    make(path)
    camera = open_camera(str(path))
    until(lambda: why in trouble(camera), 10.0, lambda: trouble(camera))
    assert str(path) in trouble(camera)


def test_a_file_that_is_put_there_later_is_found(tmp_path: Path) -> None:
    path = tmp_path / "drive.mp4"
    with closing(VideoReader(video_source(str(path)), pauses=(0.02,))) as reader:
        until(lambda: "No such file" in said(reader), 10.0)
        make_video(path)
        until(lambda: not said(reader), 10.0, lambda: said(reader))


def said(reader: VideoReader) -> str:
    try:
        reader.newest()
    except CameraError as error:
        return str(error)
    return ""


def test_a_damaged_file_harms_nobody(tmp_path: Path) -> None:
    whole = make_video(tmp_path / "whole.mkv", count=30, rate=100).read_bytes()
    random = np.random.default_rng(4)
    for number in range(12):
        damaged = np.frombuffer(whole, np.uint8).copy()
        places = random.integers(0, len(damaged), 40 * (number + 1))
        damaged[places] = random.integers(0, 256, len(places))
        path = tmp_path / f"{number}.mkv"
        path.write_bytes(damaged.tobytes()[: int(random.integers(1, len(whole)))])
        source = video_source(str(path))
        with closing(VideoReader(source, pauses=(0.02,))) as reader:
            # It comes to an end of the matter: a picture, or a reason why there is none.
            until(lambda r=reader: "yet; ask" not in said(r), 10.0)
            assert "video-reader" in [thread.name for thread in threading.enumerate()]


def test_a_camera_that_is_not_plugged_in_is_told(open_camera: Open) -> None:
    camera = open_camera("/dev/video-not-there")
    until(lambda: "is not there; plug it in, or correct 'source'" in trouble(camera), 10.0)


def test_a_device_that_is_no_camera_is_told(open_camera: Open) -> None:
    camera = open_camera("/dev/null")
    until(lambda: "the camera /dev/null gives no pictures" in trouble(camera), 10.0)


def test_without_pyav_requests_are_told_what_to_install(
    open_camera: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    camera = open_camera("/dev/video0")
    until(lambda: r"pip install 'robot-user-nexus[camera]'" in trouble(camera), 10.0)


def test_a_stream_that_is_lost_is_told_and_comes_back_by_itself() -> None:
    with closing(CameraServer()) as server:
        source = video_source(server.address)
        # A clock that stands still: no picture is ever too old.
        with closing(VideoReader(source, pauses=(0.05,), clock=lambda: 100.0)) as reader:
            until(lambda: not said(reader), 10.0, lambda: said(reader))
            assert reader.newest().size == (128, 96)
            server.sends.clear()
            until(lambda: said(reader), 10.0)
            assert "pass" not in said(reader)
            assert f"http://{server.address.partition('@')[2]}" in said(reader)
            server.sends.set()
            until(lambda: not said(reader), 10.0, lambda: said(reader))


def test_a_live_picture_that_is_old_is_not_shown_as_new() -> None:
    now = [100.0]
    with closing(CameraServer()) as server:
        source = video_source(server.address)
        with closing(VideoReader(source, clock=lambda: now[0])) as reader:
            until(lambda: not said(reader), 10.0, lambda: said(reader))
            server.stalls.set()

            def time_passes() -> bool:
                now[0] += 5.0
                return "for 5 s; see what it does" in said(reader)

            until(time_passes, 10.0, lambda: said(reader))


def test_a_picture_that_would_fill_the_memory_is_not_decoded(
    open_camera: Open, tmp_path: Path
) -> None:
    path = tmp_path / "vast.jpg"
    path.write_bytes(jpeg_of(np.zeros((4200, 4200), np.uint8)))
    camera = open_camera(str(path))
    until(lambda: f"video file {path} cannot be shown" in trouble(camera), 10.0)
