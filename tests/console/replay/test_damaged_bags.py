"""Damaged recordings of other robots are shown as far as they go, or refused in a sentence."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from rosbags.rosbag2 import StoragePlugin

from hub.errors import RecordingError
from rune_tui.errors import LogError
from rune_tui.model.topics import topics_of
from rune_tui.replay.bag_source import STEP_NS
from rune_tui.replay.opening import open_source
from tests.support import ros_bags

FOREIGN = Path(__file__).parents[2] / "data" / "bags"


def damaged(whole: bytes, chance: random.Random) -> bytes:
    """Some bytes are gone, of another value, 0, or there twice."""
    data = bytearray(whole)
    at, length = chance.randrange(len(data)), chance.randrange(1, 2000)
    match chance.randrange(5):
        case 0:
            del data[at:]
        case 1:
            for _ in range(chance.choice([1, 3, 20])):
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        case 2:
            data[at : at + length] = bytes(len(data[at : at + length]))
        case 3:
            data[at : at + 8] = chance.choice([b"\xff", b"\x7f", b"\x80"]) * 8
        case _:
            data[at:at] = data[:length]
    return bytes(data)


def show(path: Path, chance: random.Random) -> None:
    """Do what a person does."""
    source = open_source([path], None)
    try:
        for frame, _ in zip(source.frames(source.start - 1, source.end), range(3), strict=False):
            for robot in frame.state.robots.values():
                shown = topics_of(robot)
                assert shown is not None
                shown.value.read_fields()
                shown.value.read_series()
                assert all(each.value.pixels.size for each in robot.all_pictures.values())
        for key in ("down", "tab", "pagedown", "z"):
            source.press(key, source.start + STEP_NS)
        at = source.frame_before(chance.randrange(source.start, source.end + 1))
        assert at is None or next(source.frames(at - 1, at)).stamp == at
        source.overview()
        assert all(0 < len(each) < 1000 for each in source.faults)
    finally:
        source.close()


@pytest.fixture(scope="module", name="files")
def _files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("bags")
    rover = ros_bags.write_mcap(folder / "rover.mcap", [*ros_bags.entries(1)])
    bag = ros_bags.write_bag(folder / "bag", storage=StoragePlugin.SQLITE3)
    return [*sorted(FOREIGN.glob("*.mcap")), rover, next(bag.glob("*.db3"))]


@pytest.mark.parametrize("seed", range(3))
def test_any_damage_is_shown_or_a_sentence(files: list[Path], tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    refusals: list[str] = []
    for source in files:
        path = tmp_path / f"damaged{source.suffix}"
        path.write_bytes(damaged(source.read_bytes(), chance))
        try:
            show(path, chance)
        except (RecordingError, LogError) as error:
            refusals.append(str(error))
    assert all(0 < len(each) < 1000 for each in refusals)
    assert len(refusals) < len(files)
