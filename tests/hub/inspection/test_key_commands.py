"""`rune-hub keys`, as a person types it."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring, default_folder
from tests.support.command_line import run, rune_hub


def keys(*arguments: str) -> subprocess.CompletedProcess[str]:
    return rune_hub("keys", *arguments)


def said(*arguments: str) -> str:
    done = keys(*arguments)
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    return done.stdout


def test_made_key_is_listed_until_it_is_removed() -> None:
    path = Path(said("make", "alice", "--role", "operate").splitlines()[-1])
    made = read_client_keys(path)
    assert made.role is Role.OPERATE
    head, row = said("list").splitlines()
    assert head.split() == ["ROLE", "PUBLIC", "KEY", "NAME"]
    assert row.split() == ["operate", made.pair.public, "alice"]
    assert [head.index(word) for word in ("PUBLIC", "NAME")] == [
        row.index(made.pair.public),
        row.index("alice"),
    ]
    shown = {"name": "alice", "role": "operate", "public": made.pair.public}
    assert json.loads(said("list", "--json")) == shown
    said("remove", "alice")
    assert "no keys in" in said("list")
    assert said("list", "--json") == ""


def test_folder_can_be_named(tmp_path: Path) -> None:
    folder = tmp_path / "elsewhere"
    said("make", "alice", "--role", "module", "--folder", str(folder))
    assert [holder.name for holder in Keyring(folder).holders()] == ["alice"]
    assert not default_folder().exists()


def test_what_the_terminal_cannot_show_is_spelt_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    done = run("hub", "keys", "list", "--folder", str(tmp_path / "größe"))
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    assert "gr\\xf6\\xdfe" in done.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["make", "a b", "--role", "observe"],
        ["make", "alice", "--role", "observe", "--folder", "/dev/null"],
        ["remove", "nobody"],
    ],
)
def test_mistake_is_one_sentence_and_a_usage_error(arguments: list[str]) -> None:
    done = keys(*arguments)
    assert (done.returncode, done.stdout) == (ExitCode.USAGE, "")
    assert done.stderr.startswith("rune-hub: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments", [["make", "alice"], ["make", "alice", "--role", "king"], []])
def test_role_and_task_have_to_be_known(arguments: list[str]) -> None:
    done = keys(*arguments)
    assert done.returncode == ExitCode.USAGE
    assert "rune-hub keys" in done.stderr
