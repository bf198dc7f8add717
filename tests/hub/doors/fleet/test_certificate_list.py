"""`rune-hub fleet keys list`: how long each certificate counts."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest

from hub.doors.fleet.certificates import Certificates
from hub.errors import KeyFileError
from tests.support.command_line import rune_hub


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("keys") / "fleet"
    made = Certificates(path)
    for name, role, days in (
        ("localhost", "router", 90),
        ("there.example", "router", 20),
        ("rover", "robot", 3),
        ("alice", "operate", 90),
        ("wall", "observe", 0),
        ("lost", "observe", 90),
    ):
        made.make(name, role, days=days)
    (path / "operate-alice.key").unlink()  # it was moved to the machine of alice
    (path / "observe-lost.pem").unlink()
    return path


def day(folder: Path, name: str, days: int) -> str:
    """The day that is some days after a certificate was made."""
    made = (folder / f"{name}.pem").stat().st_mtime
    return time.strftime("%Y-%m-%d", time.gmtime(made + 86400.0 * days))


def test_list_shows_until_when_each_certificate_counts(folder: Path) -> None:
    done = rune_hub("fleet", "keys", "list", "--folder", str(folder))
    assert (done.returncode, done.stderr) == (0, "")
    shown = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert list(shown) == [
        "observe:lost",
        "observe:wall",
        "operate:alice",
        "robot:rover",
        "router",
        "router-there.example",
    ]
    soon = "ends within 30 days"
    other = "router-there.example"
    assert shown["operate:alice"] == f"until {day(folder, 'operate-alice', 90)}"
    assert shown["router"] == f"until {day(folder, 'router', 90)}"
    assert shown["robot:rover"] == f"until {day(folder, 'robot-rover', 3)}: {soon}"
    assert shown[other] == f"until {day(folder, other, 20)}: {soon}"
    assert shown["observe:wall"] == f"ended on {day(folder, 'observe-wall', 0)}"
    assert shown["observe:lost"].startswith("last day not known: ")


def test_list_as_json_has_the_same(folder: Path) -> None:
    done = rune_hub("fleet", "keys", "list", "--json", "--folder", str(folder))
    found: dict[str, dict[str, Any]] = {
        each.pop("name"): each for each in map(json.loads, done.stdout.splitlines())
    }
    last = day(folder, "robot-rover", 3)
    assert found["robot:rover"] == {"last_day": last, "ended": False, "ends_soon": True}
    last = day(folder, "operate-alice", 90)
    assert found["operate:alice"] == {"last_day": last, "ended": False, "ends_soon": False}
    last = day(folder, "observe-wall", 0)
    assert found["observe:wall"] == {"last_day": last, "ended": True, "ends_soon": False}
    lost = found["observe:lost"]
    assert (lost["last_day"], lost["ended"], lost["ends_soon"]) == (None, None, None)
    assert "observe-lost.pem" in lost["fault"]


def test_certificate_that_cannot_be_read_hides_no_other(tmp_path: Path) -> None:
    empty = rune_hub("fleet", "keys", "list", "--folder", str(tmp_path / "none"))
    assert (empty.returncode, empty.stdout) == (0, "")
    assert "`rune-hub fleet keys make` makes one" in empty.stderr
    made = Certificates(tmp_path)
    for name in ("ann", "bob"):
        made.make(name, "operate", days=1)
    (tmp_path / "operate-ann.pem").write_text("no certificate")
    with pytest.raises(KeyFileError, match=r"operate-ann\.pem .* openssl refused"):
        made.facts("operate:ann")
    shown = rune_hub("fleet", "keys", "list", "--folder", str(tmp_path)).stdout.splitlines()
    assert [line.split()[0] for line in shown] == ["operate:ann", "operate:bob"]
    assert "last day not known" in shown[0]
    assert shown[1].endswith("ends within 30 days")
