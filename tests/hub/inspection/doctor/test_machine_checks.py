"""What the doctor says of the machine; what cannot be made real is given as it would be read."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from hub.inspection.doctor import library_checks, machine_checks
from hub.inspection.doctor.finding import Level
from hub.ipc.transport import file_descriptors, shared_ring
from tests.hub.inspection.robots import robot
from tests.support.cases import for_each


def test_libraries_of_this_environment_are_well() -> None:
    said = library_checks.versions()
    assert {finding.level for finding in said} == {Level.OK}
    assert said[1].text.startswith("numpy ")


@for_each(
    ("name", "version", "level", "text"),
    [
        ("numpy", "2.1.0", Level.OK, "numpy 2.1.0"),
        ("numpy", "1.26.4", Level.PROBLEM, "numpy 1.26.4 is not >=2.0,<3"),
        ("numpy", "2.10.1", Level.OK, "numpy 2.10.1"),
        ("numpy", "2.4.0rc1", Level.OK, "numpy 2.4.0rc1"),
        ("numpy", "3.0.0", Level.PROBLEM, "numpy 3.0.0 is not >=2.0,<3"),
        ("numpy", "", Level.PROBLEM, "numpy is not installed"),
    ],
)
def test_a_wrong_version_is_a_problem(name: str, version: str, level: Level, text: str) -> None:
    said = library_checks.judged_version(name, version, ">=2.0,<3")
    assert (said.level, said.text) == (level, text)


def test_a_missing_extra_counts_as_much_as_the_robot_needs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = robot(tmp_path, '[camera]\nsource = "film.mp4"')
    wanted = [
        'no-such-library>=1; extra == "camera"',
        'numpy>=1; extra == "camera"',
        'no-such-either; extra == "other" or sys_platform == "none"',
        "nor-this>=1",
    ]
    monkeypatch.setattr("importlib.metadata.requires", lambda _: wanted)
    (said,) = library_checks.extras(film)
    assert said.level is Level.PROBLEM
    assert "extra 'camera' lacks no-such-library, which" in said.text
    (said,) = library_checks.extras(robot(tmp_path))
    assert said.level is Level.WARNING
    monkeypatch.setattr("importlib.metadata.requires", lambda _: wanted[1:])
    (said,) = library_checks.extras(film)
    assert said.level is Level.OK


def test_an_extra_in_a_wrong_version_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.metadata.requires", lambda _: ['numpy<1; extra == "camera"'])
    (said,) = library_checks.extras(robot(tmp_path))
    assert "numpy <1 (there is" in said.text


def test_shared_memory_works_here_and_is_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    (said,) = machine_checks.shared_memory()
    assert said.level is Level.OK
    monkeypatch.setattr(shared_ring, "available", False)
    (said,) = machine_checks.shared_memory()
    assert said.level is Level.WARNING


def test_shared_memory_that_cannot_be_had_is_a_warning() -> None:
    # A process that may not have more descriptors cannot make a ring.
    code = (
        "import resource; from hub.inspection.doctor import machine_checks as m\n"
        "resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))\n"
        "print(m.shared_memory()[0].level.value, m.open_files()[0].level.value)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["warning", "problem"]


def test_too_few_open_files_are_told() -> None:
    code = (
        "import resource; from hub.inspection.doctor import machine_checks as m\n"
        "resource.setrlimit(resource.RLIMIT_NOFILE, (1024, 1024))\n"
        "said = m.open_files()[0]\n"
        "print(said.level.value, said.text, said.advice, sep='|')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    level, text, advice = done.stdout.split("|")
    assert level == "warning"
    assert f"1024; central wants {file_descriptors.WANTED}" in text
    assert f"LimitNOFILE={file_descriptors.WANTED}" in advice
    if resource.getrlimit(resource.RLIMIT_NOFILE)[1] >= file_descriptors.WANTED:
        assert machine_checks.open_files()[0].level is Level.OK


def test_a_date_before_the_installation_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    (said,) = machine_checks.clock()
    assert said.level is Level.OK
    monkeypatch.setattr("time.time", lambda: 100.0)  # a machine without a battery wakes in 1970
    (said,) = machine_checks.clock()
    assert said.level is Level.WARNING
    assert "before this hub was installed" in said.text


@pytest.mark.parametrize(
    ("free", "level"),
    [(5 << 30, Level.OK), (500 << 20, Level.WARNING), (10 << 20, Level.PROBLEM)],
)
def test_room_is_judged(free: int, level: Level) -> None:
    assert machine_checks.judged_space(free, Path("/")).level is level


def test_room_is_looked_at_once_for_each_disk(tmp_path: Path) -> None:
    (said,) = machine_checks.space(robot(tmp_path, f'[mapping]\nfolder = "{tmp_path}/a/b"'))
    assert " free at " in said.text
    assert len(machine_checks.space(robot(tmp_path, '[mapping]\nfolder = "/dev/shm/a"'))) == 2


@for_each(
    ("table", "level"),
    [
        ("MemTotal: 100 kB\nMemAvailable:  8000000 kB\n", Level.OK),
        ("MemTotal: 100 kB\nMemAvailable:  300000 kB\n", Level.WARNING),
        ("MemTotal: 100 kB\nMemAvailable:  30000 kB\n", Level.PROBLEM),
        ("", Level.WARNING),
    ],
)
def test_memory_is_judged(table: str, level: Level) -> None:
    assert machine_checks.judged_memory(table).level is level


def test_memory_of_this_machine_can_be_read() -> None:
    (said,) = machine_checks.memory()
    assert said.text.endswith("available")


@pytest.mark.parametrize(
    ("load", "count", "level"),
    [(1.0, 2, Level.OK), (3.1, 2, Level.WARNING), (3.1, 4, Level.OK)],
)
def test_load_is_judged_by_processors(load: float, count: int, level: Level) -> None:
    assert machine_checks.judged_load(load, count).level is level


def test_a_users_own_service_has_to_outlive_the_login(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("SYSTEMD", "_UNITS", "_LINGERING"):
        (tmp_path / name).mkdir()
        monkeypatch.setattr(machine_checks, name, tmp_path / name)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert "rune-hub service robot.toml" in machine_checks.service("robot.toml")[0].text
    unit = tmp_path / ".config/systemd/user/rune-hub.service"
    unit.parent.mkdir(parents=True)
    unit.touch()
    (said,) = machine_checks.service("robot.toml")
    assert said.level is Level.WARNING
    assert "enable-linger" in said.advice
    (tmp_path / "_LINGERING" / machine_checks.user_name()).touch()
    assert machine_checks.service("robot.toml")[0].level is Level.OK
    unit.unlink()
    (tmp_path / "_UNITS" / "rune-hub.service").touch()
    assert "systemctl status" in machine_checks.service("robot.toml")[0].text


def test_without_systemd_other_means_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine_checks, "SYSTEMD", tmp_path / "none")
    assert "by other means" in machine_checks.service("robot.toml")[0].text


def test_root_is_told_that_others_may_do_less(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    (said,) = machine_checks.user("my robot.toml")
    assert said.level is Level.WARNING
    assert said.advice.endswith("rune-hub doctor 'my robot.toml'")
    monkeypatch.setattr(os, "geteuid", lambda: 4_000_000)  # somebody without a name
    (said,) = machine_checks.user("robot.toml")
    assert (said.level, said.text) == (Level.OK, "all this holds for 4000000")
