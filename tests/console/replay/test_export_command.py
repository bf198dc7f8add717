"""`rune replay --export` as a person types it: times, names of files, damaged recordings."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.command_line import ExitCode
from tests.console.replay.logged_session import logged_session
from tests.support.command_line import rune
from tests.support.recorded_drive import chunks_of, damage_chunks, write_drive


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return logged_session(tmp_path_factory.mktemp("session"), 5.0)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--start=nan", "'nan' is no time"),
        ("--start=-nan", "'-nan' is no time"),
        ("--start=inf", "'inf' is no time"),
        ("--start=1:99", "'1:99' is no time"),
        ("--start=99:99:99", "'99:99:99' is no time"),
        ("--start=-5", "'-5' is no time"),
        ("--start=50", "50 is after the end: session.mcap lasts"),
        ("--end=nan", "'nan' is no time"),
        ("--end=1:00", "1:00 is after the end"),
    ],
)
def test_a_time_that_the_recording_lacks_is_refused(
    session: Path, tmp_path: Path, option: str, said: str
) -> None:
    done = rune("replay", str(session), option, "--export", str(tmp_path / "a.txt"))
    assert done.returncode == ExitCode.USAGE
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_another_suffix_is_refused_with_all_that_there_are(session: Path, tmp_path: Path) -> None:
    done = rune("replay", str(session), "--export", str(tmp_path / "a.jpg"))
    assert done.returncode == ExitCode.USAGE
    for suffix in (".png", ".svg", ".txt", ".mp4", ".gif", ".html"):
        assert suffix in done.stderr


@pytest.mark.parametrize("name", ["a.txt", "a.html", "a.gif"])
def test_a_file_is_replaced_only_by_force(session: Path, tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text("mine")
    done = rune("replay", str(session), "--export", str(path))
    assert (done.returncode, path.read_text()) == (ExitCode.USAGE, "mine")
    assert "--force" in done.stderr
    options = ("--start", "3", "--export", str(path), "--force")
    assert rune("replay", str(session), *options).returncode == ExitCode.OK
    assert path.read_bytes() != b"mine"


def test_a_file_of_which_nothing_can_be_read_is_a_fault(session: Path, tmp_path: Path) -> None:
    write_drive(tmp_path / "drive.mcap")
    for name, whole in (("a", session), ("b", tmp_path / "drive.mcap")):
        path = tmp_path / f"{name}.mcap"
        path.write_bytes(damage_chunks(whole.read_bytes()))
        done = rune("replay", str(path), "--export", str(tmp_path / "a.html"))
        assert done.returncode == ExitCode.FAULT
        assert "a part of it is damaged" in done.stderr
        assert not (tmp_path / "a.html").exists()


def test_a_page_of_a_damaged_recording_says_that_parts_are_missing(
    session: Path, tmp_path: Path
) -> None:
    whole, damaged = session.read_bytes(), tmp_path / "damaged.mcap"
    start, end = chunks_of(whole)[-1]
    damaged.write_bytes(whole[:end] + damage_chunks(whole)[start:end])
    for path, words in (
        (session, "No alarm and no bump is recorded."),
        (damaged, "cannot be read."),
    ):
        page = tmp_path / f"{path.stem}.html"
        done = rune("replay", str(path), "--export", str(page))
        assert done.returncode == ExitCode.OK
        assert words in page.read_text()
        assert bool(done.stderr) == (path == damaged)
        assert "0 events" in page.read_text()


def test_a_variable_without_a_layout_that_has_it_is_refused(session: Path, tmp_path: Path) -> None:
    options = ["--set", "unknown=1", "--export", str(tmp_path / "a.txt")]
    done = rune("replay", str(session), *options)
    assert done.returncode == ExitCode.USAGE
    assert "--set needs --layout" in done.stderr
    assert not (tmp_path / "a.txt").exists()
