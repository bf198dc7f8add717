"""Recordings are shown in their own layout, in another, and several on one time line."""

from __future__ import annotations

import contextlib
import random
import shutil
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from hub.errors import RecordingError
from hub.gcm.body import ROBOT_DESCRIPTION, CameraBody, RobotBody
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.vision import IMAGE, Image, ImageCoding
from rune_tui.errors import LogError
from rune_tui.files.console_recording import ConsoleRecording
from rune_tui.model.own_records import RUNE_TERMINAL, TerminalRecord
from rune_tui.replay.command import still_written
from rune_tui.replay.desk import Desk
from rune_tui.replay.opening import follow_time_zone, open_source
from rune_tui.replay.player import Player
from rune_tui.replay.timed_log import PERIOD_NS, paired
from rune_tui.startup.opening import open_layout
from tests.console.replay.logged_session import COLUMNS, ROWS, logged_session
from tests.support.messages import camera_state, robot_state

SECOND = 1_000_000_000


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return logged_session(tmp_path_factory.mktemp("session"), 12.0)


def test_another_layout_shows_the_messages_by_time(session: Path) -> None:
    layout = open_layout("xroboview")
    with closing(Player(lambda: open_source([session], layout))) as player:
        assert player.source.end - player.source.start == pytest.approx(12 * SECOND, rel=0.02)
        drawn = {}
        stamp: int | None = player.source.start
        while stamp is not None:
            player.seek(stamp, whole=True)
            assert player.frame is not None
            assert player.drawer.cells is not None
            drawn[stamp] = player.drawer.cells.checksum
            stamp = player.source.frame_after(stamp)
        assert len(drawn) == (player.source.end - player.source.start) // PERIOD_NS + 1
        assert len(set(drawn.values())) > 20
        (robot,) = player.frame.state.robots.values()
        assert robot.navigation is not None
        assert robot.navigation.age(player.frame.state.now) < 0.2
        for stamp in random.Random(3).sample(list(drawn), 30):
            player.seek(stamp, whole=True)
            assert player.drawer.cells.checksum == drawn[stamp]


def test_files_of_several_robots_are_on_one_time_line(session: Path, tmp_path: Path) -> None:
    other, now = tmp_path / "other.mcap", 1003.0
    recording = ConsoleRecording(other, {}, clock=lambda: now)
    for tick in range(100):
        now = 1003.0 + tick / 10
        recording.add("diver", ROBOT_STATE, robot_state(x=float(tick)), now)
    recording.close()
    layout = open_layout("two-robots")
    with closing(open_source([session, other], layout)) as source:
        frames = list(source.frames(source.start - 1, source.end))
        assert source.title == "session.mcap and 1 more"
    (last,) = {len(frame.state.robots) for frame in frames}
    assert last == 2
    one, two = frames[-1].state.robots.values()
    assert one.navigation is not None
    assert two.navigation is not None
    assert two.navigation.value.x == 99.0


def test_robots_are_paired_by_name_then_in_order() -> None:
    assert paired(["left", "right"], {"a": "right", "b": ""}) == {"right": "a", "left": "b"}
    assert paired(["robot"], {"magellan": "magellan"}) == {"robot": "magellan"}
    assert paired(["a", "b"], {"b": ""}) == {"b": "b"}


def test_a_smaller_terminal_gets_a_view_of_its_own_size(session: Path) -> None:
    with closing(Player(lambda: open_source([session], None))) as player:
        player.seek(player.source.start)
        desk = Desk(player, lambda: 0.0)
        for columns, rows, shown in (
            (COLUMNS + 2, ROWS + 3, (COLUMNS, ROWS)),
            (40, 15, (38, 12)),
            (COLUMNS + 20, ROWS + 20, (COLUMNS, ROWS)),
        ):
            desk.fit(columns, rows)
            cells = player.drawer.cells
            assert cells is not None
            assert (cells.columns, cells.rows) == shown
            whole = desk.cells(columns, rows)
            assert (whole.columns, whole.rows) == (columns, rows)


def test_keys_that_drive_do_nothing_and_say_so(session: Path) -> None:
    with closing(Player(lambda: open_source([session], None))) as player:
        player.seek(player.source.start)
        desk = Desk(player, lambda: 0.0)
        before = player.position
        desk.key("w", "w")
        head = "".join(map(chr, desk.cells(120, 30).glyphs[0])).replace("\0", " ")
        assert "RECORDING 20" in head
        assert "w does nothing: this is a recording" in head
        assert player.position == before


@pytest.mark.parametrize("seed", range(6))
def test_damaged_files_are_shown_as_far_as_they_go(
    session: Path, tmp_path: Path, seed: int
) -> None:
    """Cut or with flipped bits: either a sentence, or frames and sentences; nothing else."""
    chance = random.Random(seed)
    content = bytearray(session.read_bytes())
    if seed % 2:
        del content[chance.randrange(len(content)) :]
    else:
        for _ in range(20):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(content)
    with (
        contextlib.suppress(RecordingError, LogError),
        closing(Player(lambda: open_source([broken], None))) as player,
    ):
        player.seek(player.source.end, whole=True)
        player.seek(player.source.start)
        player.survey()


def test_what_is_no_recording_gets_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"hello")
    (tmp_path / "empty.mcap").touch()
    for name in ("a.mcap", "empty.mcap", "missing.mcap"):
        with pytest.raises((RecordingError, LogError)):
            open_source([tmp_path / name], None)


def test_a_recording_without_its_layout_names_the_remedy(session: Path, tmp_path: Path) -> None:
    copy = tmp_path / "a.mcap"
    shutil.copy(session, copy)
    copy.write_bytes(copy.read_bytes().replace(b"layout.xml", b"layout.py\0"))
    with pytest.raises((LogError, RecordingError)), closing(open_source([copy], None)) as source:
        list(source.frames(source.start - 1, source.end))


def test_times_of_day_are_those_of_the_console(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for offset, hour in ((7200, 2), (-12600, 20), (0, 0)):
        path = tmp_path / f"{offset}.mcap"
        recording = ConsoleRecording(path, {})
        recording.add("console", RUNE_TERMINAL, TerminalRecord(utc_offset_s=offset), 0.0)
        recording.close()
        monkeypatch.setenv("TZ", "UTC")
        try:
            follow_time_zone([path])
            assert time.localtime(0.0).tm_hour == hour
        finally:
            monkeypatch.undo()
            time.tzset()


def test_a_picture_before_the_description_becomes_the_main_one(tmp_path: Path) -> None:
    """Else it would stay as a second camera's, and its age would be an alarm for ever."""
    path, now = tmp_path / "hub.mcap", 1000.0
    body = RobotBody(
        name="rover", kind="a", radius=0.2, cameras=(CameraBody(name="front", horizontal_fov=1.0),)
    )
    image = Image(
        camera=camera_state(name="front"),
        coding=ImageCoding.RAW,
        width_px=2,
        height_px=2,
        channels=3,
        data=np.zeros(12, np.uint8),
    )
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    for tick in range(30):
        now = 1000.0 + tick / 10
        recording.add("rover", IMAGE, image, now)
        recording.add("rover", ROBOT_STATE, robot_state(x=float(tick)), now)
        if tick == 3:
            recording.add("rover", ROBOT_DESCRIPTION, body, now)
    recording.close()
    with closing(open_source([path], open_layout("search"))) as source:
        for frame in source.frames(source.start + SECOND, source.end):
            (robot,) = frame.state.robots.values()
            assert robot.picture is not None
            assert robot.picture.age(frame.state.now) < 0.3
            assert robot.pictures == {}


def test_a_recording_that_is_still_written_is_named(tmp_path: Path) -> None:
    session = logged_session(tmp_path, 1)
    changed = session.stat().st_mtime
    assert still_written([session], changed) == ""
    session.write_bytes(session.read_bytes()[:-20])
    changed = session.stat().st_mtime
    assert "session.mcap is still written" in still_written([tmp_path, session], changed + 1.0)
    assert still_written([session, tmp_path / "none.mcap"], changed + 60.0) == ""
