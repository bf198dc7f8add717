"""`rune-hub mission`: what was kept is listed, shown and exported without a hub."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hub.cli import command_parser, run_command
from hub.errors import ArenaError, MissionError
from hub.gcm.mapping import InterestPoint, PointKind
from hub.missions.export import export
from hub.missions.folder import MissionFolder
from hub.missions.journal import encode
from hub.missions.keeper import MissionKeeper, MissionLimits
from hub.missions.log_odds import LogOdds
from hub.missions.points import MAX_NUMBER
from hub.missions.records import SheetBegun, to_json


def main(arguments: list[str]) -> int:
    return run_command(command_parser().parse_args(arguments))


GRID = LogOdds.of(np.diag([1.0, 0.0, -2.0]).astype(np.float32), 0.05, -1.0, 2.0)
PICTURE = np.frombuffer(b"\xff\xd8 a picture", np.uint8)


def mission(root: Path, robot: str, stamp: float, *, ended: bool) -> str:
    keeper = MissionKeeper(
        MissionFolder(root, robot), MissionLimits(least_free_mb=0.0), calendar=lambda: stamp
    )
    keeper.open()
    keeper.begin(f"search of {robot}", "Ada")
    for note in ("=cmd()", "\x1b[2Jbehind the door"):
        point = InterestPoint(
            kind=PointKind.VICTIM, x=1.5, y=len(note), by="Ada", note=note,
            thumbnail=PICTURE,
        )  # fmt: skip
        keeper.mark(point, "Ada")
    keeper.trace(1.0, 2.0, 0.5)
    keeper.save_map(GRID)
    keeper.in_frame(1, lambda: GRID)
    keeper.in_frame(2, lambda: GRID)
    if ended:
        keeper.end("Ada")
    name = keeper.book.begun and (keeper.id or MissionFolder(root, robot).missions()[-1])
    keeper.close()
    assert name
    return name


@pytest.fixture
def root(tmp_path: Path) -> Path:
    mission(tmp_path / "kept", "rover", 1.6e9, ended=True)
    mission(tmp_path / "kept", "my robot", 1.7e9, ended=False)
    return tmp_path / "kept"


def test_all_missions_of_all_robots_are_listed(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mission", "list", "--folder", str(root), "--json"]) == 0
    facts = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    known = {(each["robot"], each["state"], each["marks"], each["sheets"]) for each in facts}
    assert known == {("rover", "ended", 2, 2), ("my robot", "interrupted", 2, 2)}
    assert main(["mission", "list", "--folder", str(root)]) == 0
    said = capsys.readouterr().out
    assert said.index("search of rover") < said.index("search of my robot"), "the oldest first"
    assert "interrupted" in said


@pytest.mark.parametrize("name", ["rover", "my robot"])
def test_missions_are_found_by_the_name_in_the_list(
    root: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    assert main(["mission", "show", "--robot", name, "--folder", str(root)]) == 0
    assert f"search of {name}" in capsys.readouterr().out


def test_an_unknown_robot_is_answered_with_what_is_wanted(root: Path) -> None:
    with pytest.raises(MissionError, match="a name of column 'robot'"):
        main(["mission", "show", "--robot", "omni", "--folder", str(root)])


def test_a_mission_runs_only_while_a_hub_keeps_it(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def state() -> tuple[str, bool]:
        assert main(["mission", "show", "--folder", str(root), "--json"]) == 0
        facts = json.loads(capsys.readouterr().out)
        return facts["state"], facts["running"]

    assert state() == ("interrupted", False)
    folder = MissionFolder(root, "my robot")
    keeper = MissionKeeper(folder, MissionLimits(least_free_mb=0.0))
    keeper.open()
    assert state() == ("runs", True)
    assert main(["mission", "show", "--folder", str(root)]) == 0
    assert capsys.readouterr().out.splitlines()[0].endswith(" runs")
    keeper.close()
    assert state() == ("interrupted", False)
    folder.set_running("")
    assert state() == ("not ended", False)


def test_one_mission_is_shown_with_marks_and_events(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mission", "show", "--folder", str(root)]) == 0
    said = capsys.readouterr().out
    assert "mission search of my robot of my robot" in said
    assert "victim 1 at 1.50, 6.00 m on sheet 1, Ada" in said
    assert "sheet 2 begins" in said
    assert "\x1b" not in said
    with pytest.raises(MissionError, match="no mission 'nowhere'"):
        main(["mission", "show", "nowhere", "--folder", str(root)])


def test_a_mission_is_exported_as_files_that_others_read(root: Path, tmp_path: Path) -> None:
    target = tmp_path / "out"
    assert main(["mission", "export", "--folder", str(root), "-o", str(target)]) == 0
    names = {path.name for path in target.iterdir()}
    assert names == {
        "marks.csv", "events.csv", "track.csv", "mark-1.jpg", "mark-2.jpg",
        "sheet-1.geojson", "sheet-1.pgm", "sheet-1.yaml", "sheet-2.geojson",
    }  # fmt: skip
    with (target / "marks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["number"], row["sheet"], row["kind"]) for row in rows] == [
        ("1", "1", "victim"), ("2", "1", "victim"),
    ]  # fmt: skip
    assert rows[0]["note"] == "'=cmd()"
    assert (target / "mark-1.jpg").read_bytes() == PICTURE.tobytes()
    assert np.asarray(Image.open(target / "sheet-1.pgm")).tolist() == [
        [205, 205, 254], [205, 205, 205], [0, 205, 205],
    ]  # fmt: skip
    # What is there is not overwritten.
    with pytest.raises(MissionError, match="not empty"):
        main(["mission", "export", "--folder", str(root), "-o", str(target)])


def test_a_journal_with_any_number_of_a_sheet_is_exported(tmp_path: Path) -> None:
    root = tmp_path / "kept"
    name = mission(root, "rover", 1.6e9, ended=False)
    folder = MissionFolder(root, "rover")
    begun = SheetBegun(number=MAX_NUMBER, frame=1, carries=True, why="?", stamp=1.6e9)
    with folder.journal_of(name).open("ab") as file:
        file.write(encode(to_json(begun)))
    written = export(folder, name, tmp_path / "out")
    assert f"sheet-{MAX_NUMBER}.geojson" in {path.name for path in written}
    assert len(written) < 20


def test_half_of_a_letter_in_a_journal_is_a_record_that_cannot_be_read(tmp_path: Path) -> None:
    name = mission(tmp_path, "rover", 1.6e9, ended=False)
    folder = MissionFolder(tmp_path, "rover")
    with folder.journal_of(name).open("ab") as file:
        file.write(encode({"is": "named", "name": "\ud800", "by": "Eve", "stamp": 1.6e9}))
    book, _ = folder.read(name)
    assert (book.name, book.unreadable) == ("search of rover", 1)


def test_a_mission_is_scored_against_an_arena(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The robot starts in the arena at (1, 2) and looks north."""
    arena = tmp_path / "arena.toml"
    arena.write_text(
        'name = "hut"\n[start]\nat = [1.0, 2.0]\nheading_deg = 90\n[scoring]\nweight = 0.5\n'
        '[[victim]]\nname = "near"\nat = [-1.0, 3.5]\nfacing = "west"\n'
        '[[victim]]\nname = "far"\nat = [8.0, 8.0]\nfacing = "west"\n'
    )
    keeper = MissionKeeper(MissionFolder(tmp_path, "rover"), MissionLimits(least_free_mb=0.0))
    keeper.open()
    keeper.begin("search", "Ada")
    for x, y in ((1.5, 2.2), (-6.0, 0.0)):
        keeper.mark(
            InterestPoint(kind=PointKind.VICTIM, x=x, y=y, by="Ada", thumbnail=PICTURE), "Ada"
        )
    keeper.close()
    command = ["mission", "score", "--folder", str(tmp_path), "--arena", str(arena)]
    assert main([*command, "--json"]) == 0
    made = json.loads(capsys.readouterr().out)
    assert made["victims"] == [
        {"name": "near", "mark": 1, "error": 0.2, "points": 30.0},
        {"name": "far", "mark": None, "error": None, "points": 0.0},
    ]
    assert (made["found"], made["missed"], made["false"]) == (1, 1, [2])
    assert made["score"] == 0.5 * 20.0 / 4.0
    assert main(command) == 0
    shown = capsys.readouterr().out
    assert "mission search of rover, compared with arena hut" in shown
    assert "1 of 2 found" in shown
    assert "score 2.5, with weight 0.5 and 1 operator" in shown


def test_a_berth_that_an_arena_lacks_is_named(root: Path) -> None:
    command = ["mission", "score", "--folder", str(root), "--arena", "pool", "--berth", "rof"]
    with pytest.raises(ArenaError, match="did you mean 'rov'"):
        main(command)


def test_what_cannot_be_read_is_not_said_to_be_absent(
    root: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    journal = root / "rover" / MissionFolder(root, "rover").missions()[0] / "journal"
    whole = journal.read_bytes()
    journal.write_bytes(whole.replace(b"Ada", b"Bob", 1))
    for lines in (["show"], ["export", "-o", str(tmp_path / "out")]):
        assert main(["mission", *lines, "--robot", "rover", "--folder", str(root)]) == 1
        said = capsys.readouterr()
        assert "damaged and left out" in said.out + said.err
    journal.write_bytes(whole)
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for named, why in (
        ("none", "No such file"),
        ("file", "Not a directory"),
        ("loop", "Too many levels"),
    ):
        with pytest.raises(MissionError, match=f"cannot be read: {why}"):
            main(["mission", "list", "--folder", str(tmp_path / named)])
    # Where no robot has kept a mission yet, the usual folder is not there.
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    assert main(["mission", "list"]) == 0
    assert "there are no missions here" in capsys.readouterr().out
