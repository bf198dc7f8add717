"""What the doctor says of keys, folders and devices, with real ones that are wrong."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.inspection.doctor import hub_checks, robot_checks
from hub.inspection.doctor.finding import Finding, Level
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from tests.hub.inspection.robots import robot

UNWRITABLE = "/proc/self"  # even for root
NOBODY = 65534


@pytest.fixture
def not_root() -> Iterator[None]:
    """Everything is open to root, so root becomes somebody else for a while."""
    was = os.geteuid()
    if was == 0:
        os.seteuid(NOBODY)
    yield
    os.seteuid(was)


def with_gateway(folder: Path) -> str:
    return f'[hub]\ngateway = "tcp://127.0.0.1:1481"\nkeys = "{folder}"'


def keys(tmp_path: Path) -> Finding:
    (said,) = robot_checks.keys(robot(tmp_path, with_gateway(tmp_path / "keys")))
    return said


def test_keys_in_order_are_named_and_only_looked_at(tmp_path: Path) -> None:
    Keyring(tmp_path / "keys").make("alice", Role.OPERATE)
    before = sorted(tmp_path.rglob("*"))
    said = keys(tmp_path)
    assert (said.level, said.text) == (Level.OK, f"1 in {tmp_path / 'keys'}: alice")
    assert sorted(tmp_path.rglob("*")) == sorted({*before, tmp_path / "robot.toml"})


def test_without_a_gateway_no_keys_are_wanted(tmp_path: Path) -> None:
    (said,) = robot_checks.keys(robot(tmp_path))
    assert said.level is Level.OK


def test_no_folder_and_no_key_are_warnings_that_make_nothing(tmp_path: Path) -> None:
    said = keys(tmp_path)
    assert said.level is Level.WARNING
    assert "is not there, so nobody has a key" in said.text
    assert f"--folder {tmp_path / 'keys'}" in said.advice
    assert not (tmp_path / "keys").exists()
    (tmp_path / "keys").mkdir(mode=0o755)
    assert "chmod 700" in keys(tmp_path).text
    (tmp_path / "keys").chmod(0o700)
    said = keys(tmp_path)
    assert (said.level, list((tmp_path / "keys").iterdir())) == (Level.WARNING, [])
    assert "no keys are listed" in said.text


@pytest.mark.parametrize(
    ("name", "mode", "text"),
    [("hub.toml", 0o644, "chmod 600"), ("list.toml", 0o660, "chmod 600"), ("", 0o755, "chmod 700")],
)
def test_keys_that_others_can_read_are_a_problem(
    tmp_path: Path, name: str, mode: int, text: str
) -> None:
    Keyring(tmp_path / "keys").make("alice", Role.OPERATE)
    (tmp_path / "keys" / name).chmod(mode)
    said = keys(tmp_path)
    assert said.level is Level.PROBLEM
    assert text in said.text


def test_damaged_keys_and_a_folder_that_cannot_be_made_are_problems(tmp_path: Path) -> None:
    Keyring(tmp_path / "keys").make("alice", Role.OPERATE)
    (tmp_path / "keys" / "hub.toml").write_text("cut off")
    assert keys(tmp_path).level is Level.PROBLEM
    (said,) = robot_checks.keys(robot(tmp_path, with_gateway(Path(UNWRITABLE, "keys"))))
    assert said.level is Level.PROBLEM
    assert "cannot be made" in said.text


def test_sockets_can_be_made_and_nothing_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with tempfile.TemporaryDirectory() as short:
        monkeypatch.delenv("RUNE_RUNTIME_DIR")
        monkeypatch.setenv("XDG_RUNTIME_DIR", short)
        (said,) = hub_checks.sockets(robot(tmp_path))
        assert (said.level, said.text) == (Level.OK, f"they can be made in {short}")
        assert list(Path(short).iterdir()) == []


@pytest.mark.parametrize(
    ("folder", "levels"),
    [
        (UNWRITABLE, [Level.PROBLEM]),
        ("/no/such/folder", [Level.WARNING, Level.OK]),
    ],
)
def test_a_bad_runtime_folder_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str, levels: list[Level]
) -> None:
    monkeypatch.delenv("RUNE_RUNTIME_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
    assert [said.level for said in hub_checks.sockets(robot(tmp_path))] == levels


def test_a_runtime_folder_with_a_long_path_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / ("x" * 60)
    folder.mkdir()
    monkeypatch.delenv("RUNE_RUNTIME_DIR")
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    too_long, taken = hub_checks.sockets(robot(tmp_path))
    assert (too_long.level, taken.level) == (Level.WARNING, Level.OK)
    assert str(folder) not in taken.text


def test_folders_that_cannot_be_written_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tables = f'[mapping]\nfolder = "{tmp_path}/new/maps"'
    said = robot_checks.folders(robot(tmp_path, tables))
    assert [finding.level for finding in said] == [Level.OK] * 4
    assert not (tmp_path / "new").exists()
    monkeypatch.setenv("XDG_STATE_HOME", UNWRITABLE)
    tables = f'[mapping]\nfolder = "{UNWRITABLE}/x"\n[recording]\nalways = true'
    logs, maps, _, recordings = robot_checks.folders(robot(tmp_path, tables))
    assert (recordings.level, "recordings cannot be" in recordings.text) == (Level.PROBLEM, True)
    assert (logs.level, maps.level) == (Level.WARNING, Level.PROBLEM)
    assert "logs cannot be written" in logs.text
    assert f"mkdir -p {UNWRITABLE}/x" in maps.advice


def test_the_folder_that_systemd_gives_for_logs_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LOGS_DIRECTORY", f"{tmp_path}:/other")
    assert robot_checks.folders(robot(tmp_path))[0].text.endswith(f"to {tmp_path}")
    named = robot(tmp_path, '[hub]\nlogs = "/proc/self/logs"')
    assert robot_checks.folders(named)[0].level is Level.PROBLEM


def camera(source: str) -> str:
    return f'[camera]\nsource = "{source}"'


def test_a_device_that_is_missing_is_told_with_those_of_its_kind(tmp_path: Path) -> None:
    (said,) = robot_checks.devices(robot(tmp_path, camera("/dev/tty987654")))
    assert said.level is Level.PROBLEM
    assert "/dev/tty987654: No such file" in said.text
    assert "there are /dev/tty" in said.text


def test_devices_in_commands_of_modules_are_looked_at(tmp_path: Path) -> None:
    command = 'command = ["/bin/drive", "--port=/dev/ttyRUNE0", "/dev/zero", "/dev/tty"]'
    missing, there = robot_checks.devices(robot(tmp_path, driver=command))
    assert (missing.level, there.level) == (Level.PROBLEM, Level.OK)
    assert missing.text.startswith("/dev/ttyRUNE0: ")
    assert there.text.startswith("/dev/tty is there")


@pytest.mark.usefixtures("not_root")
@pytest.mark.parametrize(
    ("mode", "advice"), [(0o060, "usermod -aG "), (0o600, "udev rule"), (0o640, "udev rule")]
)
def test_a_device_of_others_names_the_way_in(mode: int, advice: str) -> None:
    # What counts are owner, group and mode; to make device files takes more rights than we have.
    if os.getuid() != 0:
        pytest.skip("only root can give a file away")
    os.seteuid(0)
    with tempfile.NamedTemporaryFile() as file:
        os.fchown(file.fileno(), 0, 44)
        os.fchmod(file.fileno(), mode)
        os.seteuid(NOBODY)
        said = robot_checks.device_finding(Path(file.name))
        os.seteuid(0)
    assert said.level is Level.PROBLEM
    assert "is not open to this user" in said.text
    assert advice in said.advice


@pytest.mark.usefixtures("not_root")
def test_a_device_nobody_may_read_is_a_problem() -> None:
    with tempfile.NamedTemporaryFile() as file:
        os.fchmod(file.fileno(), 0)
        assert robot_checks.device_finding(Path(file.name)).level is Level.PROBLEM
        os.fchmod(file.fileno(), 0o600)
        assert robot_checks.device_finding(Path(file.name)).level is Level.OK


def test_a_camera_can_be_a_file_or_an_address(tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    (said,) = robot_checks.devices(robot(tmp_path, camera(str(film))))
    assert said.level is Level.PROBLEM
    film.touch()
    (said,) = robot_checks.devices(robot(tmp_path, camera(str(film))))
    assert said.level is Level.OK
    (said,) = robot_checks.devices(robot(tmp_path, camera("rtsp://camera/1")))
    assert (said.level, "is not known" in said.text) == (Level.WARNING, True)


def test_a_robot_without_devices_is_well(tmp_path: Path) -> None:
    (said,) = robot_checks.devices(robot(tmp_path))
    assert said.level is Level.OK
