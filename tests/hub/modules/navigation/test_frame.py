"""The frame of the map: kept over a restart of navigation, another when the place is lost."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hub.gcm.navigation import DriveState
from hub.modules.navigation.frame import FrameMemory, MapFrame, chosen
from hub.pose import Pose
from tests.hub.sim.arenas import arena_of
from tests.support.magellan import SimulatedMagellan
from tests.support.messages import drive_state

ROOM = """
name = "room"
[start]
at = [0.6, 0.6]
[hall]
[[wall]]
from = [0.0, 0.0]
to = [4.0, 0.0]
"""
ODOM = Pose(x=0.3, y=-0.1, theta=0.2)


@pytest.fixture(scope="module")
def state() -> DriveState:
    return SimulatedMagellan(arena_of(ROOM), seed=1).drive_state(1.0)


def _numbered(state: DriveState, number: int, *, x: float = 0.0, **changes: int) -> DriveState:
    """The report with another dead reckoning, perhaps elsewhere."""
    where = drive_state(x=x) if x else state
    return dataclasses.replace(state, odometry=where.odometry, **{"reckoning": number, **changes})


def test_navigation_that_begins_anew_finds_frame_and_correction(
    state: DriveState, tmp_path: Path
) -> None:
    path = tmp_path / "pose"
    before = FrameMemory(path)
    first = before.reported(_numbered(state, 7, origin=0))
    assert first == MapFrame(reckoning=7, number=7)
    assert before.reported(_numbered(state, 7, x=3.0)) is None
    before.corrected(ODOM)
    after = FrameMemory(path)
    assert after.reported(_numbered(state, 7, x=3.0)) == MapFrame(reckoning=7, number=7, odom=ODOM)


def test_a_driver_that_begins_anew_has_another_frame(state: DriveState, tmp_path: Path) -> None:
    memory = FrameMemory(tmp_path / "pose")
    memory.reported(_numbered(state, 7, origin=0))
    memory.corrected(ODOM)
    assert memory.reported(_numbered(state, 8, origin=0)) == MapFrame(reckoning=8, number=8)


def test_where_the_hardware_knows_its_place_the_frame_stays(state: DriveState) -> None:
    again = SimulatedMagellan(arena_of(ROOM), seed=1).drive_state(2.0)
    first = chosen(_numbered(state, 7), MapFrame())
    second = chosen(_numbered(again, 8), first)
    assert first.number == second.number == state.origin != 0
    elsewhere = arena_of(ROOM.replace("[0.6, 0.6]", "[1.6, 0.6]"))
    assert SimulatedMagellan(elsewhere, seed=1).drive_state(1.0).origin != state.origin


def test_a_pose_that_may_have_been_corrected_before_is_of_an_unknown_frame(
    state: DriveState,
) -> None:
    driven = _numbered(state, 7, x=3.0)
    first, second = chosen(driven, MapFrame()), chosen(driven, MapFrame())
    assert 0 != first.number != second.number != 0
    assert chosen(_numbered(driven, 0), MapFrame()) == MapFrame()


@given(raw=st.binary(max_size=200) | st.text(max_size=60).map(str.encode))
@example(raw=b"[1, 2, 1" + b"0" * 400 + b", 0, 0]")
def test_any_file_is_read_as_nothing_or_a_frame(raw: bytes, tmp_path_factory) -> None:
    path = tmp_path_factory.getbasetemp() / "pose-of-anybody"
    path.write_bytes(raw)
    assert FrameMemory(path).frame == MapFrame()


def test_a_file_elsewhere_is_not_followed(tmp_path: Path, state: DriveState) -> None:
    (tmp_path / "other").write_text("[7, 7, 0.0, 0.0, 0.0]")
    (tmp_path / "pose").symlink_to(tmp_path / "other")
    memory = FrameMemory(tmp_path / "pose")
    assert memory.reported(_numbered(state, 7, x=3.0)).number != 7
    assert (tmp_path / "other").read_text() == "[7, 7, 0.0, 0.0, 0.0]"
