"""`rune study new`, `check` and `plan`, as a person types them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from tests.study.studies import FOUR, HEAD, study_of
from tests.support.command_line import rune


def test_a_new_study_is_checked(tmp_path: Path) -> None:
    assert rune("study", "new", str(tmp_path)).returncode == 0
    done = rune("study", "check", str(tmp_path))
    assert "8 participants, 2 conditions, 2 orders" in done.stdout
    orders = {
        line.strip() for line in done.stdout.splitlines() if line.startswith((" A B", " B A"))
    }
    people = sorted(int(word) for line in orders for word in line.split()[2:])
    assert (len(orders), people) == (2, list(range(1, 9)))
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
        longest_run = 2
        """,
    )
    done = rune("study", "check", str(tmp_path))
    assert done.returncode == 2
    assert "none of 10000 orders keeps the rules" in done.stderr
    assert "apart arena, by itself: 0" in done.stdout
    assert "longest_run 2, by itself: 10000" in done.stdout
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
    for part in ("hri-c", "shows 2 robots", "'nothing'", "magelan", "green", "lann"):
        assert part in done.stderr


def test_mistakes_of_all_kinds_come_at_once_with_lines_and_near_names(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(
        HEAD
        + """[session]
steps = ["consnt", "trials"]
[design]
order = "wiliams"
[defaults]
robot = "magelan"
arena = "yelow"
[factors]
layout = ["serch", "hri-a"]
speed = [0.1, 99]
[practice]
arena = "orang"
[freeze]
questions = "sagatt"
count = 3
not_before_s = 500
apart_s = 200
[metrics]
primary = ["tlx_rw"]
effectiveness = "new_are"
[[level]]
factor = "layout"
level = "hri-b"
"""
    )
    done = rune("study", "check", str(tmp_path))
    assert done.returncode == 2
    lines = [line.split("study.toml:")[-1].split(":")[0] for line in done.stderr.splitlines()]
    assert lines == ["5", "7", "9", "10", "12", "13", "15", "17", "18", "22", "23", "26"]
    for near in ("consent", "williams", "magellan", "yellow", "search", "orange", "sagat"):
        assert f"did you mean '{near}'?" in done.stderr
    found = json.loads(rune("study", "check", str(tmp_path), "--json").stdout)
    assert len(found["problems"]) == len(lines)


def test_what_a_table_with_a_mistake_would_say_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(
        HEAD + '[trial]\nseconds = "long"\n[freeze]\nnot_before_s = 900\n[defaults]\nrobots = 0\n'
    )
    lines = rune("study", "check", str(tmp_path)).stderr.splitlines()
    assert [line.rpartition(", ")[2][:12] for line in lines] == ["key 'seconds", "key 'robots'"]


def test_metrics_that_the_study_cannot_measure_are_named(tmp_path: Path) -> None:
    study_of(
        tmp_path,
        """
        [session]
        steps = ["trials", "sus"]
        [metrics]
        primary = ["tlx_raw", "sus", "sagat_1", "first_victim"]
        secondary = ["ft_secondary", "driven"]
        """,
    )
    done = rune("study", "check", str(tmp_path))
    assert done.returncode == 0
    notes = [line for line in done.stderr.splitlines() if " needs " in line or "once" in line]
    assert [line.split()[1] for line in notes] == [
        "tlx_raw",
        "sus",
        "sagat_1",
        "first_victim",
        "ft_secondary",
        "the",
    ]


def test_questions_with_a_truth_belong_to_a_freeze(tmp_path: Path) -> None:
    (tmp_path / "questionnaires").mkdir()
    path = tmp_path / "questionnaires" / "late.toml"
    path.write_text(
        'name = "late"\ntitle = "Late"\n[[item]]\nid = "a"\nkind = "place"\ntext = "?"\n'
        '[[item]]\nid = "b"\nkind = "number"\ntext = "?"\ntruth = "battery"\nrobot = 2\n'
    )
    two = '[factors]\nlayout = ["minimal"]\n[defaults]\narena = "empty"\n'
    (tmp_path / "study.toml").write_text(HEAD + two + '[trial]\nafter = ["late"]\n')
    said = rune("study", "check", str(tmp_path)).stderr
    assert "a asks for a place, which only the questions of [freeze] can" in said
    assert "b names a truth, which only the questions of [freeze] can" in said
    assert "b asks about robot 2, and a condition has 1" in said
    (tmp_path / "study.toml").write_text(HEAD + two + '[freeze]\nquestions = "late"\n')
    (wrong,) = [
        line for line in rune("study", "check", str(tmp_path)).stderr.splitlines() if "late" in line
    ]
    assert wrong.endswith("late: b asks about robot 2, and a condition has 1")
    path.write_text(path.read_text().replace("battery", "batery"))
    said = rune("study", "check", str(tmp_path)).stderr
    assert "'batery' is no truth; did you mean 'battery'?" in said


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
