"""The keeper: what it says is kept is on the disk, and comes back."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from hub.errors import MissionError
from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions import journal_file
from hub.missions.folder import MissionFolder
from hub.missions.keeper import NOTES_AT_ONCE, MissionKeeper, MissionLimits
from hub.missions.log_odds import STEP, LogOdds
from hub.missions.mark_rates import (
    CHANGES_AT_ONCE,
    CHANGES_PER_S,
    COMMANDS_AT_ONCE,
    OWN_AT_ONCE,
    TOGETHER_AT_ONCE,
    TOGETHER_PER_S,
    MarkRates,
)
from hub.missions.pending import MAX_PENDING
from hub.missions.points import MAX_THUMBNAIL_BYTES, NO_THUMBNAIL
from tests.support.full_disk import files_no_longer_than

NOW = 1.7e9
GRID = LogOdds.of(np.diag([1.0, 0.0, -2.0]).astype(np.float32), 0.05, -1.0, 2.0)


def victim(x: float = 1.0, **fields: object) -> InterestPoint:
    values: dict[str, object] = {"kind": PointKind.VICTIM, "x": x, "y": 2.0, "by": "Ada"}
    return InterestPoint(**{"thumbnail": NO_THUMBNAIL, **values, **fields})  # type: ignore[arg-type]


def keeper_of(folder: Path, robot: str = "rover", least_free_mb: float = 0.0) -> MissionKeeper:
    limits = MissionLimits(least_free_mb=least_free_mb)
    return MissionKeeper(
        MissionFolder(folder, robot), limits, clock=lambda: 5.0, calendar=lambda: NOW
    )


@pytest.fixture
def keeper(tmp_path: Path) -> Iterator[MissionKeeper]:
    made = keeper_of(tmp_path)
    assert made.open() is None
    yield made
    made.close()


def reopened(keeper: MissionKeeper, folder: Path) -> MissionKeeper:
    """What a process finds after the one before was killed: nothing was said at its end."""
    os.close(keeper.lock or -1)
    keeper.lock = None
    return keeper_of(folder)


def test_a_mark_begins_a_mission_and_comes_back_with_its_number(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    picture = np.arange(200, dtype=np.uint8)
    keeper.mark(victim(note="waves", thumbnail=picture), "client 3")
    keeper.mark(victim(4.0), "client 3")
    keeper.remove(1, 0, "Ada")
    keeper.mark(victim(5.0, number=2, version=1, note="two"), "client 3")
    assert (keeper.state.running, keeper.unkept, keeper.fault) == (1, 0, "")
    assert [point.kept for point in keeper.points.points] == [1]
    again = reopened(keeper, tmp_path)
    again.open()
    (point,) = again.points.points
    assert (point.number, point.x, point.note, point.version) == (2, 5.0, "two", 2)
    assert again.mark(victim(), "").number == 3
    assert (again.id, again.book.name) == (keeper.id, keeper.book.name)
    again.close()


@pytest.mark.parametrize("damage", [b"", b"\0" * 15, b"x" * 4000, b"20260101-000000", b"../a"])
def test_a_damaged_pointer_drops_no_mission(
    keeper: MissionKeeper, tmp_path: Path, damage: bytes
) -> None:
    for x in range(8):
        keeper.mark(victim(3.0 * x), "Ada")
    pointer = keeper.folder.path / "running"
    pointer.write_bytes(damage)
    again = reopened(keeper, tmp_path)
    again.open()
    assert (len(again.points.points), again.id) == (8, keeper.id)
    assert again.fault == f"{pointer} is damaged; the newest mission, {keeper.id}, goes on"
    assert pointer.read_text() == keeper.id
    again.end("Ada")
    pointer.write_bytes(damage)
    again.open()
    assert "is damaged, and the newest mission is ended" in again.fault
    again.close()


def test_the_map_comes_back_to_a_step_of_its_log_odds(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    keeper.begin("search", "Ada")
    keeper.save_map(GRID)
    again = reopened(keeper, tmp_path)
    grid = again.open()
    assert grid is not None
    assert np.abs(grid.values - np.diag([1.0, 0.0, -2.0])).max() <= STEP / 2
    assert (grid.origin_x, grid.origin_y, grid.resolution) == (-1.0, 2.0, 0.05)
    assert again.state.map_age_s == 0.0
    again.close()


def test_a_mission_is_begun_named_and_ended(keeper: MissionKeeper, tmp_path: Path) -> None:
    with pytest.raises(MissionError, match="no mission runs"):
        keeper.end("Ada")
    keeper.begin("  first\nfloor ", "Ada")
    assert keeper.state.name == "first floor"
    with pytest.raises(MissionError, match="runs already"):
        keeper.begin("second", "Bob")
    keeper.name("cellar", "Bob")
    keeper.mark(victim(), "Ada")
    keeper.end("Ada")
    assert keeper.state.running == 0
    assert len(keeper.points.points) == 1
    folder = MissionFolder(tmp_path, "rover")
    assert folder.running() == ""
    (mission,) = folder.missions()
    book, damaged = folder.read(mission)
    assert (book.name, book.running, damaged) == ("cellar", False, 0)
    assert [event.text for event in book.events][-1] == "Ada ended the mission"
    keeper.mark(victim(9.0), "Bob")
    assert [point.number for point in keeper.points.points] == [1]
    assert len(folder.missions()) == 2


def test_on_a_full_disk_marks_are_shown_as_not_kept_until_they_are(
    keeper: MissionKeeper,
) -> None:
    keeper.mark(victim(), "Ada")
    size = keeper.folder.journal_of(keeper.id).stat().st_size
    with files_no_longer_than(size + 100):
        keeper.mark(victim(2.0, thumbnail=np.ones(4000, np.uint8)), "Ada")
        assert [point.kept for point in keeper.points.points] == [1, 0]
        assert keeper.unkept == 1
        assert "cannot be written" in keeper.state.fault
        torn = keeper.folder.read(keeper.id)
        assert ([point.number for point in torn[0].points.points], torn[1]) == ([1], 0)
    keeper.look()
    assert [point.kept for point in keeper.points.points] == [1, 1]
    assert (keeper.unkept, keeper.fault) == (0, "")
    assert len(keeper.folder.read(keeper.id)[0].points.points) == 2


def test_a_folder_that_cannot_be_written_is_a_fault_and_tried_again(tmp_path: Path) -> None:
    (tmp_path / "missions").write_text("a file where a folder should be")
    keeper = keeper_of(tmp_path / "missions")
    keeper.open()
    keeper.mark(victim(), "Ada")
    assert [point.kept for point in keeper.points.points] == [0]
    assert "cannot be written" in keeper.state.fault
    (tmp_path / "missions").unlink()
    keeper.look()
    assert [point.kept for point in keeper.points.points] == [1]
    keeper.close()


def test_two_hubs_of_one_name_do_not_write_into_one_mission(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    keeper.mark(victim(), "Ada")
    other = keeper_of(tmp_path)
    other.open()
    other.mark(victim(8.0), "Bob")
    assert "in use by another hub" in other.state.fault
    assert [point.kept for point in other.points.points] == [0]
    assert len(keeper.folder.read(keeper.id)[0].points.points) == 1
    other.close()


def test_missions_of_other_robots_are_never_taken_up(keeper: MissionKeeper, tmp_path: Path) -> None:
    keeper.mark(victim(), "Ada")
    for name in ("rover 2", "../rover", ".."):
        other = keeper_of(tmp_path, name)
        other.open()
        assert not other.points.points
        assert other.folder.path.parent == tmp_path
        other.close()
    # Somebody copies the folder of one robot to another.
    keeper.folder.path.rename(tmp_path / "copy")
    other = keeper_of(tmp_path, "copy")
    os.close(keeper.lock or -1)
    keeper.lock = None
    other.open()
    assert not other.points.points
    assert "is of rover, not copy" in other.state.fault
    other.close()


def test_a_journal_whose_beginning_is_damaged_keeps_its_marks(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    keeper.mark(victim(), "Ada")
    path = keeper.folder.journal_of(keeper.id)
    raw = bytearray(path.read_bytes())
    raw[3] ^= 1
    path.write_bytes(bytes(raw))
    again = reopened(keeper, tmp_path)
    again.open()
    assert [point.number for point in again.points.points] == [1]
    assert again.state.running == 1
    assert "damaged" in again.state.fault
    again.close()


@pytest.mark.parametrize(("frame", "new"), [(0, False), (7, False), (8, True)])
def test_a_new_sheet_begins_when_the_robot_has_lost_its_place(
    keeper: MissionKeeper, tmp_path: Path, frame: int, *, new: bool
) -> None:
    keeper.begin("", "Ada")
    assert not keeper.in_frame(7, lambda: GRID)
    keeper.mark(victim(), "Ada")
    assert keeper.in_frame(frame, lambda: GRID) is new
    state = keeper.state
    assert (state.sheet, state.marks, state.earlier) == ((2, 0, 1) if new else (1, 1, 0))
    assert keeper.mark(victim(3.0), "Ada").number == 2
    folder = MissionFolder(tmp_path, "rover")
    book, _ = folder.read(keeper.id)
    assert book.frame == (frame or 7)
    if new:
        assert book.points.earlier[1][0] == 1
        assert folder.grid(keeper.id, 1) is not None
        assert folder.grid(keeper.id, 2) is None


def test_marks_go_along_to_a_sheet_of_the_same_frame(keeper: MissionKeeper) -> None:
    keeper.mark(victim(), "Ada")
    keeper.begin_sheet("the map was cleared", carries=True)
    assert [point.number for point in keeper.points.points] == [1]
    assert keeper.state.earlier == 0


def test_with_little_room_marks_are_kept_and_the_map_is_not(tmp_path: Path) -> None:
    keeper = keeper_of(tmp_path, least_free_mb=1e6)
    keeper.open()
    keeper.mark(victim(), "Ada")
    keeper.look()
    keeper.save_map(GRID)
    assert [point.kept for point in keeper.points.points] == [1]
    assert "the map is not" in keeper.state.fault
    assert math.isnan(keeper.state.map_age_s)
    keeper.close()


def test_whatever_is_taken_as_a_mark_can_be_read_again(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    odd = victim(
        -1e5, note="\x1b[2J\0„“" + "n" * 900, by="\0" * 100, stamp=1e300,
        thumbnail=np.full(MAX_THUMBNAIL_BYTES, 255, np.uint8),
        uncertainty=math.inf,
    )  # fmt: skip
    kept = keeper.mark(odd, "x" * 500)
    again = reopened(keeper, tmp_path)
    again.open()
    (read,) = again.points.points
    assert str(dataclasses.replace(kept, kept=1)) == str(read)
    again.close()


def test_a_mark_that_is_sent_again_is_one_mark(keeper: MissionKeeper) -> None:
    keeper.mark(victim(note="waves"), "Ada")
    assert keeper.mark(victim(note="waves"), "Ada").number == 1
    assert keeper.mark(victim(by="Bob"), "Bob").number == 2
    assert len(keeper.points.points) == 2


def test_an_end_is_permitted_while_the_disk_refuses_and_says_what_is_lost(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    keeper.mark(victim(), "Ada")
    size = keeper.folder.journal_of(keeper.id).stat().st_size
    with files_no_longer_than(size + 10):
        keeper.mark(victim(2.0), "Ada")
        lost = keeper.end("Ada")
    assert "1 changes (marks 2) are not on the disk and lost" in lost
    assert keeper.state.running == 0
    assert [point.kept for point in keeper.points.points] == [1, 0]
    assert MissionFolder(tmp_path, "rover").running() == ""
    keeper.begin("next", "Ada")
    assert (keeper.state.running, keeper.unkept, keeper.fault) == (1, 0, "")


def until_refused(call: Callable[[int], None]) -> str:
    """Call it with 0, 1, 2 and so on until it is refused; returns why."""
    for count in range(10_000):
        try:
            call(count)
        except MissionError as error:
            return str(error)
    return ""


@pytest.fixture
def small_journal(monkeypatch: pytest.MonkeyPatch) -> int:
    size = (1 << 20) + 200_000
    monkeypatch.setattr(journal_file, "MAX_BYTES", size)
    return size


def test_changes_leave_room_for_new_marks_removals_and_the_end(
    keeper: MissionKeeper, small_journal: int
) -> None:
    keeper.mark(victim(), "Eve")

    def change(count: int) -> None:
        (known,) = keeper.points.points
        changed = dataclasses.replace(known, note="\u1234" * 490 + str(count))
        keeper.mark(changed, "Eve")

    assert "no room for it: end the mission" in until_refused(change)
    assert "no room" in until_refused(lambda count: keeper.name(f"x{count}", "Eve"))
    assert keeper.unkept == 0
    for number in range(50):
        keeper.mark(victim(10.0 + number), "Ada")
    keeper.remove(1, 0, "Ada")
    keeper.begin_sheet("the robot has lost its place", frame=7)
    keeper.look()
    assert "no room" in keeper.state.fault
    assert keeper.unkept == 0
    assert keeper.folder.journal_of(keeper.id).stat().st_size < small_journal
    mission = keeper.id
    assert keeper.end("Ada") == ""
    book, damaged = keeper.folder.read(mission)
    assert (len(book.points.earlier), book.running, damaged) == (50, False, 0)
    keeper.begin("next", "Ada")
    assert keeper.fault == ""


def test_many_small_records_leave_places_for_the_end(
    keeper: MissionKeeper, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_file, "MAX_RECORDS", 4096 + 20)
    keeper.begin("search", "Ada")
    refusal = until_refused(lambda count: keeper.name(f"x{count}", "Eve"))
    assert "no room" in refusal
    keeper.mark(victim(), "Ada")
    mission = keeper.id
    assert keeper.end("Ada") == ""
    assert len(keeper.folder.read(mission)[0].points.points) == 1


def test_a_change_writes_its_picture_only_if_it_is_another(
    keeper: MissionKeeper, tmp_path: Path
) -> None:
    pictures = [np.full(4000, value, np.uint8) for value in (1, 2)]
    point = keeper.mark(victim(thumbnail=pictures[0]), "Ada")
    path = keeper.folder.journal_of(keeper.id)
    before = path.stat().st_size
    point = keeper.mark(dataclasses.replace(point, note="waves"), "Ada")
    assert path.stat().st_size - before < 1000
    for picture, note in ((pictures[0], "waves"), (pictures[1], "other")):
        if note == "other":
            point = keeper.mark(dataclasses.replace(point, note=note, thumbnail=picture), "Ada")
        book, _ = keeper.folder.read(keeper.id)
        assert book.points.points[0].note == note
        assert np.array_equal(book.points.points[0].thumbnail, picture)
        assert np.array_equal(keeper.points.points[0].thumbnail, picture)
    del tmp_path


def test_one_client_and_one_point_have_a_rate(tmp_path: Path) -> None:
    now = [0.0]
    keeper = MissionKeeper(
        MissionFolder(tmp_path, "rover"),
        MissionLimits(),
        clock=lambda: now[0],
        calendar=lambda: NOW,
    )
    point = keeper.mark(victim(), "Eve", 7)
    taken = 0
    for count in range(300):
        now[0] += 0.01
        try:
            changed = dataclasses.replace(point, note=str(count))
            # Several clients change one point.
            point = keeper.mark(changed, "Eve", count)
            taken += 1
        except MissionError as error:
            assert "point 1 may be changed 3 times a second" in str(error)  # noqa: PT017
    assert taken <= CHANGES_AT_ONCE + 3.0 * CHANGES_PER_S
    taken = 0

    def mark_and_remove(count: int) -> None:
        nonlocal taken
        number = keeper.mark(victim(10.0 + count), "Eve", 900).number
        keeper.remove(number, 0, "Eve", 900)
        taken += 2

    assert "one client may mark 3 times a second" in until_refused(mark_and_remove)
    assert taken <= COMMANDS_AT_ONCE
    # Another client, and the same one later, are not kept from marking.
    keeper.mark(victim(200.0), "Ada", 901)
    now[0] += 1.0
    keeper.mark(victim(201.0), "Eve", 900)
    keeper.close()


def test_who_connects_anew_again_and_again_keeps_nobody_from_marking() -> None:
    rates, taken, seconds = MarkRates(), 0, 1000
    for second in range(seconds):
        for _ in range(int(COMMANDS_AT_ONCE)):
            with contextlib.suppress(MissionError):
                rates.check(0, second + 1, float(second))
                taken += 1
    together = TOGETHER_AT_ONCE + TOGETHER_PER_S * seconds
    assert taken <= together + OWN_AT_ONCE * seconds
    rates.check(0, seconds + 1, float(seconds))


def test_notes_of_hand_overs_do_not_fill_the_journal(keeper: MissionKeeper) -> None:
    keeper.begin("search", "Ada")
    before = len(keeper.book.events)
    for _ in range(1000):
        keeper.note("Eve has control")
    assert len(keeper.book.events) - before == NOTES_AT_ONCE


def test_a_mark_that_is_refused_begins_no_mission(keeper: MissionKeeper) -> None:
    with pytest.raises(MissionError, match="nowhere"):
        keeper.mark(victim(5e5), "Eve")
    assert not keeper.book.running
    kept = keeper.mark(victim(), "Ada")
    keeper.end("Ada")
    with pytest.raises(MissionError, match="nowhere"):
        keeper.mark(victim(5e5), "Eve")
    assert [point.number for point in keeper.points.points] == [kept.number]
    # Sent again, as the answer was lost: it is on the disk already.
    assert keeper.mark(victim(), "Ada") == kept
    assert not keeper.book.running


def test_marks_of_a_mission_that_was_ended_stay_as_they_are_on_the_disk(
    keeper: MissionKeeper,
) -> None:
    kept = keeper.mark(victim(), "Ada")
    keeper.end("Ada")
    with pytest.raises(MissionError, match="is ended"):
        keeper.mark(dataclasses.replace(kept, note="waves"), "Ada")
    with pytest.raises(MissionError, match="is ended"):
        keeper.remove(kept.number, 0, "Ada")
    assert [point.note for point in keeper.points.points] == [""]


def test_what_waits_for_the_disk_is_bounded_and_the_disk_is_asked_by_look_alone(
    tmp_path: Path,
) -> None:
    (tmp_path / "missions").write_text("a file where a folder should be")
    keeper = keeper_of(tmp_path / "missions")
    keeper.begin("search", "Ada")
    (tmp_path / "missions").unlink()
    keeper.name("still", "Ada")
    assert keeper.unkept == 3
    refusal = until_refused(lambda count: keeper.name(f"x{count}", "Eve"))
    assert "too much waits for the disk" in refusal
    assert keeper.unkept == MAX_PENDING
    assert keeper.book.name == f"x{MAX_PENDING - 4}"
    # A robot that has lost its place may say so as often as it likes.
    for frame in range(1, 100):
        keeper.begin_sheet("the robot has lost its place", frame=frame)
    keeper.look()
    assert (keeper.unkept, keeper.fault) == (0, "")
    book, _ = keeper.folder.read(keeper.id)
    assert (book.sheet, book.frame) == (keeper.book.sheet, 99)
    keeper.close()


def test_another_robots_journal_is_not_mended_and_leaves_no_file_open(tmp_path: Path) -> None:
    keeper = keeper_of(tmp_path, "other")
    keeper.open()
    keeper.begin("search", "Ada")
    mission = keeper.id
    keeper.close()
    (tmp_path / "other").rename(tmp_path / "mine")
    mine = keeper_of(tmp_path, "mine")
    path = mine.folder.journal_of(mission)
    torn = path.read_bytes() + b"0123"
    path.write_bytes(torn)
    mine.open()
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(5):
        mine.open()
    assert len(list(Path("/proc/self/fd").iterdir())) == before
    assert "is of other, not mine" in mine.state.fault
    assert path.read_bytes() == torn
    mine.close()
