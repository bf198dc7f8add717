"""The user's own file of roles: it counts before all else, and may hold anything."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.hid.sdl import roles_from_sdl
from rune_tui.controls.joystick.mappings import Mappings
from rune_tui.controls.joystick.user_files import user_file
from rune_tui.layout.names import ROLES
from tests.console.controls.joystick.pads import ALL, LEFT_X, LEFT_Y, PAD, REST, device
from tests.console.controls.test_joystick_set import Table

SWAPPED = "030000006d04000016c2000010010000,Pad,leftx:a1,lefty:a0,a:b0,platform:Linux,"
PADS_LINE = st.sampled_from([SWAPPED.partition("leftx")[0], "# ", ""])


@pytest.fixture
def path() -> Path:
    """Where the file is looked for."""
    found = user_file("gamecontrollerdb.txt")
    found.parent.mkdir(parents=True)
    return found


def test_what_the_file_calls_the_left_stick_drives_as_the_left_stick(path: Path) -> None:
    path.write_text(f"# mine\n{SWAPPED}\n")
    table = Table(ALL)
    table.plug(device())
    table.report(*REST)
    events = table.report((LEFT_X, 255), (LEFT_Y, 128))
    assert ("lefty", True, False, -1.0) in events
    assert not [name for name, _, _, _ in events if name.startswith("leftx")]


def test_without_a_line_for_the_pad_and_without_the_file_all_is_as_it_was(path: Path) -> None:
    mappings = Mappings()
    assert mappings.applied(device(), PAD) == PAD
    path.write_text(SWAPPED)
    assert mappings.applied(device(pid=1), PAD) == PAD
    assert mappings.applied(device(), PAD) != PAD
    assert mappings.fault == ""


@pytest.mark.parametrize("damage", ["pipe", "folder", "large"])
def test_a_file_that_cannot_be_read_is_told_of_and_the_pad_works(path: Path, damage: str) -> None:
    if damage == "pipe":
        os.mkfifo(path)
    elif damage == "folder":
        path.mkdir()
    else:
        path.write_bytes(bytes((1 << 22) + 1))
    table = Table(ALL)
    table.plug(device())
    table.report(*REST)
    assert ("leftx", True, False, 1.0) in table.report((LEFT_X, 255))
    (said,) = table.joysticks.tick(table.now)
    assert "gamecontrollerdb.txt" in said


@given(st.lists(st.tuples(PADS_LINE, st.text(max_size=60)).map("".join), max_size=4))
def test_any_text_gives_known_roles_or_none(lines: list[str]) -> None:
    given_roles = [each.role for each in roles_from_sdl(lines, PAD, 0x046D, 0xC216, 3).controls]
    assert all(role in ROLES or not role for role in given_roles)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(sorted(ROLES)),
            st.sampled_from("abh+-~"),
            st.sampled_from(["0", "1", "02", "3", "77", "\u0663", "9" * 5000]),
            st.sampled_from(["", "~", ".4", "x"]),
        ),
        max_size=8,
    )
)
def test_any_places_give_no_role_twice(places: list[tuple[str, str, str, str]]) -> None:
    pairs = ",".join(f"{role}:{''.join(place)}" for role, *place in places)
    found = roles_from_sdl(
        [f"{SWAPPED.partition('leftx')[0]}{pairs}"], PAD, 0x046D, 0xC216, 3
    ).controls
    given_roles = [each.role for each in found if each.role]
    assert len(given_roles) == len(set(given_roles))


@pytest.mark.parametrize("line", ["", "a,", SWAPPED])
def test_a_file_of_any_lines_does_not_hold_up_hands(path: Path, line: str) -> None:
    path.write_text(f"{SWAPPED}\n" + f"{line}\n" * ((1 << 22) // (len(line) + 1) - 1024))
    mappings = Mappings()
    start = time.thread_time()
    assert mappings.applied(device(), PAD) != PAD
    assert not mappings.fault
    assert time.thread_time() - start < 0.2
