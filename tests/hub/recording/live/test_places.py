"""A folder that cannot hold recordings is named with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.errors import RecordingError
from hub.recording.live.places import RecordingFolder, demand_folder
from tests.support.cases import for_each


@for_each(("wanted", "reason"), [("/dev/null", "Not a directory"), ("/proc/nope", "No such file")])
def test_a_folder_that_cannot_be_made_is_named(wanted: str, reason: str) -> None:
    folder = RecordingFolder(wanted, "rover").path
    with pytest.raises(
        RecordingError, match=f"nothing is recorded: {folder} cannot be made: {reason}"
    ):
        demand_folder(folder)


def test_a_folder_is_made_with_those_above_it(tmp_path: Path) -> None:
    demand_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
