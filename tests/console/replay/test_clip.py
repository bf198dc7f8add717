"""A part of a recording becomes a video whose frames are those of the replay."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.navigation import ROBOT_STATE
from rune_tui.compositor.picture import image
from rune_tui.errors import LogError, PictureFileError
from rune_tui.files.console_recording import ConsoleRecording
from rune_tui.replay.clip import ClipOptions, write_clip
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.opening import open_source
from rune_tui.replay.player import Player
from rune_tui.startup.opening import open_layout
from tests.console.replay.logged_session import logged_session
from tests.support.messages import robot_state

SECOND = 1_000_000_000
SMALL = ClipOptions(start=SECOND, end=3 * SECOND, frames_per_s=2.0, scale=2, as_seen=True)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return logged_session(tmp_path_factory.mktemp("session"), 5)


@pytest.fixture
def player(session: Path) -> Iterator[Player]:
    with closing(Player(partial(ConsoleLog, session))) as player:
        yield player


def nothing(share: float) -> None:
    del share


def frames_of(path: Path) -> list[np.ndarray]:
    av = pytest.importorskip("av")
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_an_exact_video_has_each_pixel_of_the_replay(
    session: Path, player: Player, tmp_path: Path
) -> None:
    path = tmp_path / "clip.mp4"
    count = write_clip(player, path, ClipOptions(**_fields(SMALL), lossless=True), nothing)
    frames = frames_of(path)
    assert len(frames) == count == 5
    with closing(Player(partial(ConsoleLog, session))) as other:
        for number, frame in enumerate(frames):
            cells = other.seek(other.source.start + SECOND + number * SECOND // 2)
            cells = cells or other.drawer.cells
            assert cells is not None
            want = np.asarray(image(cells, scale=2))
            assert np.array_equal(frame[: want.shape[0], : want.shape[1]], want)


def _fields(options: ClipOptions) -> dict[str, object]:
    names = ("start", "end", "frames_per_s", "scale", "as_seen")
    return {name: getattr(options, name) for name in names}


def test_a_video_says_that_it_is_a_recording_unless_it_must_not(
    player: Player, tmp_path: Path
) -> None:
    bare, marked = tmp_path / "bare.mp4", tmp_path / "marked.mp4"
    write_clip(player, bare, SMALL, nothing)
    write_clip(player, marked, ClipOptions(**{**_fields(SMALL), "as_seen": False}), nothing)
    (first, *_), (other, *_) = frames_of(bare), frames_of(marked)
    assert other.shape[0] > first.shape[0]
    assert np.abs(other[1, 1].astype(int) - (176, 32, 144)).max() < 24


def test_a_gif_lasts_as_long_as_its_part_at_the_rate(player: Player, tmp_path: Path) -> None:
    path = tmp_path / "clip.gif"
    options = ClipOptions(**_fields(SMALL), rate=2.0)
    assert write_clip(player, path, options, nothing) == 3
    with Image.open(path) as gif:
        lasts = 0
        for number in range(getattr(gif, "n_frames", 1)):
            gif.seek(number)
            lasts += gif.info["duration"]
    assert lasts == 1500


def test_a_part_without_frames_and_a_place_that_refuses_are_sentences(
    player: Player, tmp_path: Path
) -> None:
    late = ClipOptions(start=100 * SECOND)
    with pytest.raises(LogError, match="has nothing in this part"):
        write_clip(player, tmp_path / "late.gif", late, nothing)
    with pytest.raises(PictureFileError, match=r"none/x\.gif cannot be written: No such file"):
        write_clip(player, tmp_path / "none" / "x.gif", SMALL, nothing)
    assert list(tmp_path.iterdir()) == []


def test_progress_ends_at_the_whole(player: Player, tmp_path: Path) -> None:
    shares: list[float] = []
    write_clip(player, tmp_path / "clip.gif", SMALL, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_a_disk_that_is_full_is_said_and_nothing_is_left(
    player: Player, tmp_path: Path, suffix: str
) -> None:
    (tmp_path / f".clip.part{suffix}").symlink_to("/dev/full")
    much = dataclasses.replace(SMALL, frames_per_s=50.0, scale=16)  # it is written before the end
    with pytest.raises(PictureFileError, match="cannot be written: No space left"):
        write_clip(player, tmp_path / f"clip{suffix}", much, nothing)
    assert not [each for each in tmp_path.iterdir() if "clip" in each.name]


def test_a_video_skips_a_long_hole(tmp_path: Path) -> None:
    path, now = tmp_path / "hub.mcap", 1000.0
    body = RobotBody(name="rover", kind="a", radius=0.2)
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    for begin in (1000.0, 1000.0 + 90 * 3600.0):
        now = begin
        recording.add("rover", ROBOT_DESCRIPTION, body, now)
        for tick in range(20):
            now = begin + tick / 10
            recording.add("rover", ROBOT_STATE, robot_state(x=float(tick)), now)
    recording.close()
    layout = open_layout("minimal")
    with closing(Player(lambda: open_source([path], layout))) as player:
        options = ClipOptions(frames_per_s=2.0, scale=2, as_seen=True)
        count = write_clip(player, tmp_path / "clip.gif", options, nothing)
        assert 10 <= count <= 20, (
            "two drives of 2 s, and 5 s in which one sees the end of the first"
        )
        assert list(player.source.faults) == []
        player.playing = True
        for now_s in range(12):
            player.tick(float(now_s))
        assert player.position == player.source.end
