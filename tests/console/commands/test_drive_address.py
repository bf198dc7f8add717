"""What `rune drive` takes as an address, and what it says to what is none."""

from __future__ import annotations

import pytest

from rune_tui.commands.drive import kind_and_address
from rune_tui.errors import DriveAddressError


def test_a_robot_file_in_place_of_an_address_gets_the_commands_that_take_it() -> None:
    with pytest.raises(DriveAddressError) as refused:
        kind_and_address("my robot.toml")
    said = str(refused.value)
    assert "`rune-hub run 'my robot.toml'`" in said
    assert "`rune run auto --hub 127.0.0.1`" in said
