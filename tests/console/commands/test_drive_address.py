"""What `rune drive` takes as an address, and what it says to what is none."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from rune_tui.commands.drive import kind_and_address, run
from rune_tui.errors import DriveAddressError


def test_a_robot_file_in_place_of_an_address_gets_the_commands_that_take_it() -> None:
    with pytest.raises(DriveAddressError) as refused:
        kind_and_address("my robot.toml")
    said = str(refused.value)
    assert "`rune-hub run 'my robot.toml'`" in said
    assert "`rune run auto --hub 127.0.0.1`" in said


def test_a_robot_file_that_is_there_is_kept_before_anything_is_looked_for(tmp_path: Path) -> None:
    kept = tmp_path / "robot.toml"
    kept.write_text("mine")
    options = argparse.Namespace(address="ws://127.0.0.1:8765", ssh=None, output=kept)
    with pytest.raises(DriveAddressError, match=f"{kept} is there"):
        run(options, tmp_path / "log", lambda _, __: 0)
    assert kept.read_text() == "mine"
