"""Answers at freezes are scored from journal and answers; a known share right is found again."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.missions.journal_file import JournalFile
from hub.pose import Pose
from rune_study.data.derive import derive
from rune_study.data.probes import probes_of
from rune_study.data.rows import ProbeRow
from rune_study.data.store import compute
from rune_study.data.tables import read
from rune_study.plan.steps import TRIAL, plan
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.questionnaires.answers import Answers, read_answers
from rune_study.questionnaires.ground import Ground
from rune_study.questionnaires.questionnaire import Questionnaire, find
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.questionnaires.truths import Moment
from rune_study.session.freezing import ANSWERS, FROZEN, choose, occasion_of
from rune_study.session.journal import BEGIN, DONE, JOURNAL, Journal, read_journal
from tests.study.data.test_derive import STUDY, nothing, record
from tests.support.aware_operator import answer_of

SAGAT = read_questionnaire(find("sagat"))
FREEZES = 3


@pytest.fixture
def study(tmp_path: Path) -> StudySpec:
    (tmp_path / "study.toml").write_text(
        STUDY + "[freeze]\ncount = 3\nnot_before_s = 1\napart_s = 1\n"
    )
    return read_study(tmp_path)


def moment(random: np.random.Generator) -> Moment:
    """Any state of a robot."""
    walls = np.zeros((60, 60), bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    x, y, theta = random.uniform((1.0, 1.0, -math.pi), (5.0, 5.0, math.pi)).tolist()
    linear, angular, *commanded = random.uniform(-0.5, 0.5, 4).tolist()
    return Moment(
        pose=Pose(x=x, y=y, theta=theta),
        linear=linear,
        angular=angular,
        commanded_linear=commanded[0],
        commanded_angular=commanded[1],
        battery=float(random.uniform(0.2, 1.0)),
        collisions=int(random.integers(5)),
        marks=((3.0, 4.0), (1.0, 1.0)),
        ground=Ground(walls=walls, resolution=0.1),
    )


def play(study: StudySpec, share: float, *, left: int | None = None) -> dict[int, list[int]]:
    """Write sessions of two trials whose operator knows this share; returns what was known.

    Args:
        study: The study.
        share: Of the answers that are right.
        left: Answers after which the last freeze was left; None: none was.
    """
    random = np.random.default_rng(7)
    right: dict[int, list[int]] = {1: [], 2: [], 3: []}
    folder = study.folder / "sub-01"
    with contextlib.closing(Journal.of(study, 1)) as journal:
        for step in (each for each in plan(study, 1) if each.kind == TRIAL):
            journal.put(BEGIN, n=step.number, attempt=1, step=step.name, trial=step.trial)
            journal.put("trial-begin", n=step.number, moment_s=journal.records[-1].moment)
            record(folder / f"{step.name}-a1.mcap", journal.records[-1].moment)
            for number in range(1, FREEZES + 1):
                now = moment(random)
                ground = now.ground
                assert ground is not None
                items, queries, _ = choose(SAGAT.items, [now], {("arena", 1): ground}, 99)
                asked: dict[str, Any] = {"queries": [dataclasses.asdict(each) for each in queries]}
                journal.put(FROZEN, n=step.number, number=number, **asked)
                own = dataclasses.replace(SAGAT, items=tuple(items))
                occasion = occasion_of(step.name, 1, number)
                with Answers(folder / ANSWERS) as answers:
                    for count, query in enumerate(queries):
                        if left is not None and number == FREEZES and count == left:
                            break
                        item = next(each for each in own.items if each.id == query.id)
                        knows = bool(random.random() < share)
                        answers.give(
                            own, occasion, item, answer_of(item, query, random, knows=knows), 2.0
                        )
                        right[query.level].append(int(knows))
                journal.put("unfrozen", n=step.number, number=number)
            journal.put("trial-end", n=step.number, why="time", seconds=10.0)
            result = {"ended": "time", "seconds": 10.0}
            journal.put(DONE, n=step.number, attempt=1, result=result)
    return right


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_the_share_that_the_operator_knows_is_found_again(study: StudySpec, share: float) -> None:
    known = play(study, share)
    data = compute(study, nothing)
    assert [row.excluded for row in data.trials] == ["", ""]
    for level in (1, 2, 3):
        rows = [row for row in data.metrics if row.metric == f"sagat_{level}"]
        found = sum(row.value * row.n for row in rows) / sum(row.n for row in rows)
        assert found == pytest.approx(sum(known[level]) / len(known[level]))
    assert {row.value for row in data.metrics if row.metric == "sagat_unanswered"} == {0.0}


def test_questions_are_rows_with_times_and_truths(study: StudySpec) -> None:
    play(study, 1.0)
    data = compute(study, nothing)
    written = read(study.folder / "derived" / "probes.csv", ProbeRow)
    assert tuple(written) == data.probes
    assert len(written) == 2 * FREEZES * len(SAGAT.items)
    for row in written:
        assert row.correct == 1
        assert row.seconds == 2.0
        assert row.answered - row.asked == pytest.approx(2.0, abs=0.002)
    place = next(row for row in written if row.id == "position")
    assert len(place.truth.split()) == len(place.answer.split()) == 2


def test_a_freeze_that_was_left_counts_as_wrong_and_apart(study: StudySpec) -> None:
    play(study, 1.0, left=4)
    data = compute(study, nothing)
    silent = len(SAGAT.items) - 4
    unanswered = [row.value for row in data.metrics if row.metric == "sagat_unanswered"]
    assert unanswered == [silent, silent]
    rows = [row for row in data.probes if not row.answer]
    assert len(rows) == 2 * silent
    assert not any(row.correct for row in rows)


@pytest.mark.parametrize(
    "queries",
    [
        5,
        [5],
        [{"id": "a"}],
        [{"right": 1.0}],
        ["a"],
        [{"id": "a", "kind": "soup"}],
        [
            {
                "id": [1],
                "truth": "t",
                "kind": "number",
                "level": 1,
                "robot": 1,
                "right": 1.0,
                "tolerance": 1.0,
            }
        ],
    ],
)
def test_truths_that_were_changed_exclude_the_trial(study: StudySpec, queries: object) -> None:
    play(study, 1.0)
    with contextlib.closing(Journal.of(study, 1)) as journal:
        journal.put(BEGIN, n=0, attempt=2, step="t1", trial=1)
        journal.put("trial-begin", n=0, moment_s=journal.records[-1].moment)
        record(journal.path.parent / "t1-a2.mcap", journal.records[-1].moment)
        journal.put(FROZEN, n=0, number=1, queries=queries)
        journal.put("trial-end", n=0, why="time", seconds=10.0)
        journal.put(DONE, n=0, attempt=2, result={"ended": "time", "seconds": 10.0})
    last = derive(study, 1).trials[-1]
    assert "the truths of a freeze have another form" in last.excluded


@pytest.mark.parametrize("value", [[1], ["a", "b"], [None, None], {"a": 1}, "x", 1e308])
def test_an_answer_of_another_form_costs_its_level_alone(study: StudySpec, value: object) -> None:
    play(study, 1.0)
    with contextlib.closing(JournalFile(study.folder / "sub-01" / ANSWERS)) as file:
        given = {"questionnaire": "sagat", "occasion": "t1-a1-f1", "item": "position"}
        file.append([{**given, "value": value, "at": 1.0, "seconds": 1.0}])
    data = compute(study, nothing)
    assert [row.excluded for row in data.trials] == ["", ""]
    found = {row.metric: row for row in data.metrics if row.trial == 1}
    assert "is no place" in found["sagat_1"].why
    assert found["sagat_2"].value == 1.0


def test_answers_that_were_cut_anywhere_are_never_read_twice(study: StudySpec) -> None:
    play(study, 1.0)
    folder = study.folder / "sub-01"
    records = [each for each in read_journal(folder / JOURNAL) if each.data.get("n") == 0]
    path = folder / ANSWERS
    whole = path.read_bytes()
    number = -1
    for cut in range(0, len(whole) + 1, 7):
        path.write_bytes(whole[:cut])
        answers = read_answers(path)
        assert len(answers) >= number
        number = len(answers)
        assert number in (whole[:cut].count(b"\n"), whole[:cut].count(b"\n") + 1)
        probes = probes_of(records, "t1", 1, answers)
        ids = [(each.freeze, each.asked.id) for each in probes if each.given is not None]
        assert len(ids) == len(set(ids)) == min(number, FREEZES * len(SAGAT.items))


def test_questionnaires_without_truths_leave_no_rows() -> None:
    plain = Questionnaire(name="p", title="p")
    assert choose(plain.items, [None], {}, 9) == ([], [], {})
