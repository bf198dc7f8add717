"""`rune-hub doctor`, as a person types it."""

from __future__ import annotations

import json
import socket
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.inspection.doctor import doctor
from hub.inspection.doctor.finding import Finding, Level, ok
from hub.robomon.module_table import load_robot_table
from tests.hub.inspection.robots import robot_file
from tests.support.command_line import rune_hub
from tests.support.ports import free_port

MACHINE = {*doctor.MACHINE, *doctor.WITH_COMMANDS}


def test_a_healthy_machine_has_a_line_for_each_check_and_no_problem(tmp_path: Path) -> None:
    path = robot_file(tmp_path, f'[hub]\nlisten = "127.0.0.1:{free_port()}"')
    done = rune_hub("doctor", str(path), "--json")
    said = [json.loads(line) for line in done.stdout.splitlines()]
    assert {line["check"] for line in said} == {"robot file", *doctor.ROBOT, *MACHINE}
    assert all(set(line) == {"check", "level", "text", "advice"} for line in said)
    assert [line for line in said if line["level"] == "problem"] == []
    assert all(line["advice"] for line in said if line["level"] != "ok")
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")


def test_an_occupied_port_is_a_problem_in_one_line(tmp_path: Path) -> None:
    port = free_port()
    with socket.socket() as other:
        other.bind(("127.0.0.1", port + 1))
        other.listen()
        done = rune_hub("doctor", str(robot_file(tmp_path, f'[hub]\nlisten = "127.0.0.1:{port}"')))
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("problem ")]
    assert f"port {port + 1} of 127.0.0.1 is used by another program" in line
    assert " -> " in line
    assert done.stdout.splitlines()[-1].startswith("problems: 1, warnings: ")
    assert (done.returncode, done.stderr) == (ExitCode.FAULT, "")


def test_all_mistakes_of_a_robot_file_are_told_and_the_rest_is_looked_at(tmp_path: Path) -> None:
    path = robot_file(tmp_path, "[hub]\nlisten = 5\n[body]\nradius = 99", driver="runs = 1")
    done = rune_hub("doctor", str(path), "--json")
    said = [json.loads(line) for line in done.stdout.splitlines()]
    wrong = [line["text"] for line in said if line["check"] == "robot file"]
    assert len(wrong) == 4
    assert {line["check"] for line in said} == {"robot file", *doctor.ROBOT, *MACHINE}
    assert (done.returncode, done.stderr) == (ExitCode.USAGE, "")


@pytest.mark.parametrize("content", [None, "not = [toml", "\0"])
def test_without_a_readable_robot_file_the_machine_is_looked_at(
    tmp_path: Path, content: str | None
) -> None:
    path = tmp_path / "robot.toml"
    if content is not None:
        path.write_text(content)
    done = rune_hub("doctor", str(path), "--json")
    checks = [json.loads(line)["check"] for line in done.stdout.splitlines()]
    assert checks[0] == "robot file"
    assert set(checks[1:]) == MACHINE
    assert (done.returncode, done.stderr) == (ExitCode.USAGE, "")


def test_a_check_that_fails_itself_does_not_end_the_doctor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(*_: object) -> list[Finding]:
        text = "no\nsuch\x1b[31m"
        raise LookupError(text)

    monkeypatch.setattr(doctor, "ROBOT", {"wheels": fails})
    monkeypatch.setattr(doctor, "MACHINE", {"moon": fails, "sun": lambda: [ok("it shines")]})
    monkeypatch.setattr(doctor, "WITH_COMMANDS", {})
    path = robot_file(tmp_path)
    assert doctor.examine(str(path), load_robot_table, as_json=False) == 1
    _, wheels, moon, sun, last = capsys.readouterr().out.splitlines()
    assert wheels.startswith(
        "unknown wheels: could not be looked at (LookupError: no\\nsuch\\x1b[31m)"
    )
    assert moon.startswith("unknown moon: ")
    assert sun == "ok      sun: it shines"
    assert last == "problems: 0, warnings: 0, not known: 2"


def test_a_reader_that_fails_does_not_end_the_doctor_either(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails(_: str) -> None:
        raise RecursionError

    monkeypatch.setattr(doctor, "ROBOT", {})
    monkeypatch.setattr(doctor, "MACHINE", {})
    monkeypatch.setattr(doctor, "WITH_COMMANDS", {})
    assert doctor.examine(str(robot_file(tmp_path)), fails, as_json=True) == 1
    assert json.loads(capsys.readouterr().out)["level"] == Level.UNKNOWN.value
