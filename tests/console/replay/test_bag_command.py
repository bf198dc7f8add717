"""`rune replay` on recordings of other robots, as a person types it."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from hub.command_line import ExitCode
from tests.support import ros_bags
from tests.support.command_line import rune

CONTENT = [*ros_bags.entries(2)]


@pytest.mark.parametrize(
    ("storage", "mode"),
    [(StoragePlugin.MCAP, None), (StoragePlugin.SQLITE3, CompressionMode.FILE)],
)
def test_a_bag_is_shown(
    tmp_path: Path, storage: StoragePlugin, mode: CompressionMode | None
) -> None:
    bag = ros_bags.write_bag(tmp_path / "rover", storage=storage, compression=mode, content=CONTENT)
    picture = tmp_path / "moment.txt"
    done = rune("replay", str(bag), "--start", "1", "--export", str(picture))
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    shown = picture.read_text()
    for words in ("RECORDING", "camera", "image_raw  Image", "+0.50 m/s", "75%", "0:01.0 / 0:0"):
        assert words in shown.replace("-", " ") or words in shown


def test_a_cut_bag_is_shown_as_far_as_it_goes(tmp_path: Path) -> None:
    path = ros_bags.write_mcap(tmp_path / "a.mcap", CONTENT, chunk_size=20_000)
    data = path.read_bytes()
    picture = tmp_path / "moment.txt"
    path.write_bytes(data[: len(data) * 2 // 3])
    done = rune("replay", str(path), "--start", "1", "--export", str(picture))
    assert done.returncode == ExitCode.OK
    assert "cut" in done.stderr
    assert "may be wrong" in done.stderr
    assert "image_raw" in picture.read_text()
    picture.unlink()
    path.write_bytes(data[:500])
    done = rune("replay", str(path), "--export", str(picture))
    assert done.returncode == ExitCode.FAULT
    assert str(path) in done.stderr


def test_a_picture_away_from_the_damage_says_that_there_is_some(tmp_path: Path) -> None:
    path = ros_bags.write_mcap(tmp_path / "a.mcap", CONTENT, chunk_size=20_000)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    done = rune("replay", str(path), "--start", "0", "--as-seen", "--export", f"{path}.txt")
    assert done.returncode == ExitCode.OK
    assert "at byte" in done.stderr


def test_a_bag_of_ros_1_is_refused_with_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "drive.bag"
    path.write_bytes(b"#ROSBAG V2.0\n" + bytes(4096))
    done = rune("replay", str(path))
    assert done.returncode == ExitCode.USAGE
    assert "rosbags-convert" in done.stderr
