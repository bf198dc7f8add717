"""Commands that write files say so where the disk is full, and leave no part of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.folder import MissionFolder
from hub.missions.keeper import MissionKeeper, MissionLimits
from tests.support.command_line import rune_hub
from tests.support.full_disk import files_no_longer_than
from tests.support.recorded_drive import write_drive


@pytest.fixture
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_drive(Path("drive.mcap"))
    keeper = MissionKeeper(MissionFolder(Path("kept"), "rover"), MissionLimits(least_free_mb=0.0))
    keeper.open()
    nothing = np.empty(0, np.uint8)
    keeper.mark(InterestPoint(kind=PointKind.VICTIM, x=1.0, y=2.0, thumbnail=nothing), "Ada")
    keeper.close()


@pytest.mark.usefixtures("_here")
@pytest.mark.parametrize(
    "line",
    [
        "keys make ada --role operate --folder keys",
        "arena hall -o hall.png",
        "log cut drive.mcap -o cut.mcap --to +3s",
        "log convert drive.mcap -o bag --ros-names",
        "log recover drive.mcap -o whole.mcap",
        "log csv drive.mcap -o tables",
        "mission export --folder kept -o out",
    ],
)
def test_a_full_disk_is_said_and_leaves_nothing(line: str) -> None:
    command = line.split()
    rune_hub(command[0], "--help")  # so that its modules are there
    before = {path for path in Path().rglob("*") if path.is_file()}
    with files_no_longer_than(1):
        done = rune_hub(*command)
    assert done.returncode != 0
    assert "cannot be written" in done.stderr, done
    left = {path for path in Path().rglob("*") if path.is_file()} - before
    assert all(path.stat().st_size == 0 for path in left), left
