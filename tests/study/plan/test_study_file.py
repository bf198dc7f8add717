"""The file of a study: what is read, what is refused, and where."""

from __future__ import annotations

import dataclasses
import json
import textwrap
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.errors import StudyError, StudyFileError
from rune_study.plan.checking import check_study
from rune_study.plan.conditions import not_kept
from rune_study.plan.design_report import design_lines, design_report
from rune_study.plan.practice import Criterion
from rune_study.plan.steps import TRIAL, plan
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.plan.tables import as_lines, json_lines
from rune_study.plan.template import write_study
from rune_study.session.status import status_lines
from tests.study.studies import FOUR, HEAD, study_of


def test_a_new_study_can_be_read(tmp_path: Path) -> None:
    write_study(tmp_path)
    study = read_study(tmp_path)
    assert [spec.layout for spec in study.conditions] == ["hri-a", "hri-b"]
    with pytest.raises(StudyError, match="already"):
        write_study(tmp_path)


def test_factors_are_crossed_and_levels_change_settings(tmp_path: Path) -> None:
    study = study_of(
        tmp_path,
        """
        [factors]
        layout = ["hri-a", "hri-b"]
        help = ["off", "on"]
        [[level]]
        factor = "help"
        level = "off"
        settings = ["body.margin=0"]
        """,
    )
    assert [dict(each) for each in study.levels] == [
        {"layout": layout, "help": level}
        for layout in ("hri-a", "hri-b")
        for level in ("off", "on")
    ]
    settings = [spec.settings for spec in study.conditions]
    assert settings == [("body.margin=0",), (), ("body.margin=0",), ()]


def test_all_mistakes_are_listed_with_their_lines(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(
        """title = "x"
seed = "s"
participants = 0
[desing]
[design]
order = "wiliams"
apart = ["link"]
[factors]
layout = ["hri-a", "hri-a"]
colour = ["red"]
speed = [9]
[trial]
seconds = "long"
ends = ["noon"]
[practice]
criterion = "happy >= 3"
[session]
steps = ["consent"]
"""
    )
    with pytest.raises(StudyFileError) as caught:
        read_study(tmp_path)
    lines = [int(line.split(":")[1]) for line in str(caught.value).splitlines()]
    assert lines == sorted(lines)
    assert {3, 4, 6, 9, 10, 11, 13, 14} <= set(lines)
    assert "did you mean" in str(caught.value)


def test_keys_of_the_secondary_task_are_no_keys_of_a_layout(tmp_path: Path) -> None:
    text = """
        [factors]
        layout = ["hri-a", "hri-b"]
        [secondary]
        keys = ["w", "q", "ctrl+c", "W+", "f6"]
        right = ["f6", "f6"]
        [trial]
        seconds = 50
        [freeze]
        not_before_s = 10
        not_after_s = 80
        """
    (tmp_path / "study.toml").write_text(HEAD + textwrap.dedent(text))
    problems = check_study(tmp_path).problems
    said = "\n".join(problems)
    for part in (
        "'w' is a key of the layout 'hri-a'; choose",
        "'w' is a key of the layout 'hri-b'",
        "'ctrl+c' ends the console always",
        "'W+' is no key: ",
        "[freeze], key 'not_after_s': 80 s is after the end of a trial, which is at 50 s",
    ):
        assert part in said
    assert "'f6'" not in said
    assert len(problems) == len(set(problems))


def test_what_fits_nowhere_is_refused(tmp_path: Path) -> None:
    text = """
        [factors]
        layout = ["hri-a", "hri-b"]
        [trial]
        seconds = 60
        [freeze]
        count = 3
        not_before_s = 20
        apart_s = 30
        [session]
        steps = ["trials", "trials", "practice"]
        [practice]
        criterion = "happy >= 3"
        [design]
        order = "latin"
        longest_run = 1
        [secondary]
        right = ["f8"]
        """
    with pytest.raises(StudyFileError) as caught:
        study_of(tmp_path, text)
    said = str(caught.value)
    for part in ("do not fit", "`trials` once", "'happy'", "need the order", "1 keys of", "'f8'"):
        assert part in said


@given(st.binary(max_size=300))
def test_any_file_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, raw: bytes) -> None:
    folder = tmp_path_factory.mktemp("any")
    (folder / "study.toml").write_bytes(raw)
    with pytest.raises(StudyFileError):
        read_study(folder)


def test_a_changed_layout_changes_the_study(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    (tmp_path / "layouts").mkdir()
    (tmp_path / "layouts" / "x.xml").write_text("<rune/>")
    assert read_study(tmp_path).digest != study.digest


def test_a_plan_follows_from_study_and_participant_alone(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    for participant in (1, 7, 1000):
        assert plan(study, participant) == plan(read_study(tmp_path), participant)
    one = plan(study, 3)
    assert [step.number for step in one] == list(range(len(one)))
    assert one != plan(dataclasses.replace(study, seed="another"), 3)


def test_who_replaces_gets_the_same_order_with_other_seeds(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    left, instead = trials(study, 7), trials(study, 17, replaces=7)
    assert [step.code for step in left] == [step.code for step in instead]
    assert all(a.seed != b.seed for a, b in zip(left, instead, strict=True))


def trials(study: StudySpec, participant: int, replaces: int = 0):
    return [step for step in plan(study, participant, replaces) if step.kind == TRIAL]


def test_moments_of_a_trial_keep_the_rules(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    for participant in range(1, 201):
        for step in trials(study, participant):
            first, *_, last = step.freezes
            assert 180 <= first <= last <= 570
            assert all(b - a >= 59.99 for a, b in pairwise(step.freezes))
            pauses = [b - a for a, b in pairwise((0.0, *step.questions))]
            assert all(14.99 <= pause <= 30.01 for pause in pauses)
            assert 0 < step.questions[-1] < 600


def test_a_criterion_compares_what_is_measured() -> None:
    assert Criterion.read("photon_p50 < 1 and distance > 2").metrics == {"photon_p50"}
    with pytest.raises(StudyError, match=r"'bump' is not measured .* did you mean 'bumps'"):
        Criterion.read("bump <= 1")
    with pytest.raises(StudyError, match="'sus' is not measured during practice"):
        Criterion.read("sus >= 70")
    criterion = Criterion.read("distance >= 3.5 and collisions <= 1")
    assert criterion.holds({"distance": 3.5, "collisions": 1})
    assert not criterion.holds({"distance": 3.4, "collisions": 0})
    assert not criterion.holds({"distance": 9.0})
    for wrong in ("", "distance", "distance >= far", "distance >= 1 or collisions <= 1"):
        with pytest.raises(StudyError):
            Criterion.read(wrong)


@pytest.mark.parametrize(("level", "times"), [("", 1), ("variables = {a = 'b'}", 0)])
def test_levels_that_change_nothing_are_named(tmp_path: Path, level: str, times: int) -> None:
    change = f"[[level]]\nfactor = 'help'\nlevel = 'b'\n{level}\n"
    study_of(tmp_path, f"[factors]\nhelp = ['a', 'b']\n{change}")
    text = "help 'a' and 'b' do not differ"
    assert sum(text in each for each in check_study(tmp_path).problems) == times


def found_in(folder: Path, text: str) -> list[str]:
    (folder / "study.toml").write_text(HEAD + text)
    return [each.partition(": ")[2] for each in check_study(folder).problems]


def test_unknown_levels_of_autonomy_and_assistance_get_near_names(tmp_path: Path) -> None:
    levels = "autonomy = ['goal', 'exploration']\nassistance = ['on', 'of']"
    assert found_in(tmp_path, f"[factors]\n{levels}\n") == [
        "[factors], key 'autonomy': 'goal' is none of teleoperation, goals, exploration; did you "
        "mean 'goals'?",
        "[factors], key 'assistance': 'of' is none of switched, on, off; did you mean 'off'?",
    ]


def test_levels_without_an_input_of_the_layout_are_named(tmp_path: Path) -> None:
    table = "[defaults]\nlayout = 'minimal'\nautonomy = '{}'\nassistance = '{}'\n"
    assert found_in(tmp_path, table.format("teleoperation", "off")) == []
    assert found_in(tmp_path, table.format("goals", "on")) == [
        "autonomy 'goals': layout 'minimal' has no input for goals or turns; bind one, "
        "or write 'teleoperation'"
    ]
    assistance, autonomy = found_in(tmp_path, table.format("exploration", "switched"))
    assert "has no input for exploration; bind one, or write 'teleoperation'" in autonomy
    assert "assistance 'switched': layout 'minimal' has no input that switches it" in assistance
    assert (
        found_in(tmp_path, table.format("exploration", "switched").replace("minimal", "search"))
        == []
    )


def test_a_level_that_is_the_usual_one_makes_no_other_condition(tmp_path: Path) -> None:
    (problem,) = found_in(tmp_path, "[[condition]]\n[[condition]]\nautonomy = 'exploration'\n")
    assert "do not differ" in problem


def test_a_plan_names_what_robots_may_do_by_themselves(tmp_path: Path) -> None:
    study = study_of(
        tmp_path,
        """
        [defaults]
        assistance = "on"
        [factors]
        autonomy = ["teleoperation", "goals"]
        """,
    )
    assert list(as_lines(study, [], named=True)) == [
        "A  autonomy teleoperation, assistance on",
        "B  autonomy goals, assistance on",
    ]
    assert list(design_lines(design_report(study)))[1] == "all conditions: assistance on"
    levels = [json.loads(line).get("levels") for line in json_lines(study, [1], named=True)]
    assert {"autonomy": "goals", "assistance": "on"} in levels
    assert list(status_lines(study))[:2] == list(as_lines(study, [], named=True))


def test_limits_of_real_robots_are_noted(tmp_path: Path) -> None:
    study = study_of(tmp_path, "[defaults]\nhubs = ['10.0.0.7']\nautonomy = 'goals'\n")
    (note,) = not_kept(study)
    assert note.startswith("condition A limits real robots (autonomy) at the participant's console")
    assert not list(not_kept(study_of(tmp_path, "[defaults]\nautonomy = 'goals'\n")))
