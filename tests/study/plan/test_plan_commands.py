"""`rune study new`, `check` and `plan`, as a person types them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from tests.study.studies import FOUR, study_of
from tests.support.command_line import rune


def test_a_new_study_is_checked(tmp_path: Path) -> None:
    assert rune("study", "new", str(tmp_path)).returncode == 0
    done = rune("study", "check", str(tmp_path))
    assert "8 participants, 2 conditions, 2 orders" in done.stdout
    report = json.loads(rune("study", "check", str(tmp_path), "--json").stdout)
    assert report["positions"] == [[4, 4], [4, 4]]
    assert report["carry_over"] == [[0, 4], [4, 0]]


def test_rules_that_no_order_keeps_are_counted(tmp_path: Path) -> None:
    study_of(
        tmp_path,
        """
        [factors]
        layout = ["hri-a", "hri-b", "search"]
        arena = ["yellow"]
        [design]
        order = "random"
        apart = ["arena"]
        """,
    )
    done = rune("study", "check", str(tmp_path))
    assert done.returncode == 2
    assert "none of 10000 orders keeps the rules" in done.stderr
    assert rune("study", "plan", str(tmp_path)).returncode == 2


def test_what_a_study_names_has_to_exist(tmp_path: Path) -> None:
    study_of(
        tmp_path,
        """
        [defaults]
        robot = "magelan"
        arena = "green"
        link = "lann"
        [factors]
        layout = ["hri-c", "two-robots"]
        [trial]
        before = ["nothing"]
        """,
    )
    done = rune("study", "check", str(tmp_path))
    assert done.returncode == 2
    for part in ("hri-c", "shows 2 robots", "'nothing'", "magelan"):
        assert part in done.stderr


def test_a_blind_plan_names_codes_only(tmp_path: Path) -> None:
    study_of(tmp_path, FOUR)
    for form in ([], ["--csv"], ["--json"]):
        blind = rune("study", "plan", str(tmp_path), *form)
        assert blind.returncode == 0
        assert "hri-a" not in blind.stdout
        assert "hri-a" in rune("study", "plan", str(tmp_path), "--unblind", *form).stdout
    lines = rune("study", "plan", str(tmp_path), "--csv").stdout.splitlines()
    rows = list(csv.DictReader(lines))
    assert len(rows) == 16 * 4
    assert {row["condition"] for row in rows} == set("ABCD")


def test_a_folder_without_a_study_gets_a_sentence(tmp_path: Path) -> None:
    done = rune("study", "plan", str(tmp_path / "none"))
    assert done.returncode == 2
    assert "study.toml: cannot be read" in done.stderr


def test_help_needs_no_study() -> None:
    done = rune("study", "--help")
    assert done.returncode == 0
    assert "docs/studies.md" in done.stdout
