"""The secondary task, from the key to the metric, beside the robot and alone."""

from __future__ import annotations

import asyncio
import contextlib
import time
from pathlib import Path

import pytest

from hub.recording.reader import Recording
from hub.recording.recording_set import RecordingSet
from rune_study.data.secondary import TaskScore, alone_of, score_of, secondary_of
from rune_study.metrics.registry import measure
from rune_study.metrics.trial import TrialData
from rune_study.plan.steps import SECONDARY, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.session.freezing import FROZEN, PROBE
from rune_study.session.journal import BEGIN, DONE, Journal, Record
from rune_study.session.schedule import QUESTION, Due
from rune_study.session.secondary import ANSWERED, AloneScreen, SecondaryTask
from rune_study.session.study_log import study_log
from rune_tui.replay.source import EventKind
from rune_tui.replay.survey import survey
from tests.study.studies import study_of

TASK = """
    [session]
    steps = ["secondary", "trials", "secondary"]
    [factors]
    layout = ["minimal"]
    [trial]
    seconds = 60
    [secondary]
    every_s = [2.0, 4.0]
    longest_s = 3
    alone_s = 30
    """


def asked(number: int) -> Due:
    return Due(at=0.0, what=QUESTION, number=number)


@pytest.fixture
def study(tmp_path: Path) -> StudySpec:
    return study_of(tmp_path, TASK)


def alone(study: StudySpec) -> Step:
    return next(step for step in plan(study, 1) if step.kind == SECONDARY)


def test_the_task_alone_asks_as_often_as_beside_the_robot(study: StudySpec) -> None:
    first, trial, last = plan(study, 1)
    assert first.seconds == last.seconds == 30.0
    assert first.questions != last.questions
    for step in (first, trial, last):
        gaps = [b - a for a, b in zip((0.0, *step.questions), step.questions, strict=False)]
        assert all(2.0 <= gap <= 4.001 for gap in gaps)
        assert step.questions[-1] < step.seconds


def test_right_wrong_missed_and_withdrawn_questions_are_told_apart(study: StudySpec) -> None:
    step = alone(study)
    with contextlib.closing(Journal.of(study, 1)) as journal:
        task = SecondaryTask(study, step, journal)
        assert study.task is not None
        for number, at in enumerate((10.0, 20.0, 30.0, 40.0, 50.0, 60.0), 1):
            text = task.ask(asked(number), at)
            right = study.task.right[study.task.ask.index(text)]
            wrong = next(each for each in study.task.keys if each != right)
            match number:
                case 1 | 2:
                    assert task.end(right, at + 0.5 * number)
                    assert not task.end(right, at + 1.0)
                case 3:
                    assert task.end(wrong, at + 1.0)
                case 4:
                    assert not task.look(at + 3.0)
                    assert task.look(at + 3.1)
                case 5:
                    assert task.end(None, at + 1.0, counts=False)
        assert task.ask(asked(7), 62.0)  # the sixth one is missed
        score = score_of(journal.records, 100.0)
    assert (score.asked, score.correct, score.missed) == (5, 2, 2)
    assert score.times == pytest.approx((0.5, 1.0))


def records(*parts: tuple[str, dict[str, object]]) -> list[Record]:
    return [Record(what=what, at=0.0, moment=0.0, data=data) for what, data in parts]


def test_only_complete_steps_alone_count(study: StudySpec) -> None:
    steps = {step.number: step for step in plan(study, 1)}
    right = (ANSWERED, {"n": 0, "correct": True, "key": "f6", "seconds": 1.0, "counts": True})
    begin, done = (BEGIN, {"n": 0, "attempt": 1}), (DONE, {"n": 0, "result": {"seconds": 30.0}})
    beside = (ANSWERED, {"n": 1, "correct": True, "key": "f6", "seconds": 1.0})
    found = alone_of(records(begin, right, right, begin, right, beside, done, beside), steps)
    assert (found.correct, found.seconds) == (1, 30.0)
    assert alone_of(records(begin, right), steps).seconds == 0.0
    wrong: tuple[str, dict[str, object]] = (DONE, {"n": 0, "result": {"seconds": "long"}})
    assert alone_of(records(begin, right, wrong), steps).seconds == 0.0


def test_free_time_is_the_rate_beside_the_robot_over_the_rate_alone() -> None:
    beside = TaskScore(seconds=100.0, asked=10, correct=4, missed=5, times=(1.0, 2.0, 4.0, 3.0))
    both = secondary_of(beside, TaskScore(seconds=50.0, asked=5, correct=5))
    found = measure(TrialData(length=100.0, secondary=both))
    assert found["ft_secondary"].value == pytest.approx(0.4)
    assert found["secondary_right"].value == pytest.approx(0.4)
    assert found["secondary_missed"].value == 5
    assert found["secondary_time"].value == 2.5
    slow = secondary_of(beside, TaskScore(seconds=50.0, asked=5, correct=1))
    faster = measure(TrialData(length=100.0, secondary=slow))["ft_secondary"]
    assert faster.value == pytest.approx(2.0)
    assert "above 1" in faster.note
    never = measure(TrialData(length=100.0, secondary=secondary_of(beside, TaskScore())))
    assert "not done both" in never["ft_secondary"].why
    assert never["secondary_right"].known
    assert secondary_of(TaskScore(), TaskScore()) is None


def test_keys_on_the_screen_alone_are_answers(tmp_path: Path) -> None:
    study = study_of(tmp_path, TASK.replace("[2.0, 4.0]", "[0.5, 0.5]").replace("= 30", "= 10"))
    step = alone(study)
    short = type(step)(kind=SECONDARY, seconds=1.6, questions=(0.1, 0.6, 1.5), seed=step.seed)

    async def run(journal: Journal) -> bool | None:
        app = AloneScreen(SecondaryTask(study, short, journal), short)
        async with app.run_test(size=(80, 24)) as pilot:
            end = time.monotonic() + 10.0
            while len(journal.records) < 3 and time.monotonic() < end:
                if str(app.query_one("#text").render()):
                    await pilot.press("x", "f6")
                await pilot.pause()
            return app.return_value

    with contextlib.closing(Journal.of(study, 1)) as journal:
        asyncio.run(run(journal))
        answers = [each.data for each in journal.records if each.what == ANSWERED]
    assert [each["key"] for each in answers[:2]] == ["f6", "f6"]
    assert all(each["seconds"] >= 0.0 for each in answers[:2])


def test_what_happens_is_on_the_time_line_of_the_recordings(study: StudySpec) -> None:
    step = next(each for each in plan(study, 1) if each.trial)
    with contextlib.closing(Journal.of(study, 1)) as journal:
        journal.put(BEGIN, n=1, attempt=1, step="t1")
        with study_log(journal, study.digest, "p01", step, 1, {"autonomy": "goals"}) as path:
            journal.put("trial-begin", n=1, moment_s=journal.records[-1].moment)
            task = SecondaryTask(study, step, journal)
            task.ask(asked(1), time.monotonic())
            task.end("f6", time.monotonic())
            task.ask(asked(2), time.monotonic())
            task.end(None, time.monotonic(), counts=False)
            journal.put(FROZEN, n=1, number=1)
            now = time.monotonic()
            journal.put(
                PROBE, n=1, number=1, id="where", about="position", level=1, robot=1,
                asked=now - 2.0, answered=now, answer=[1.0, 2.0], truth=[1.0, 2.5],
                tolerance=1.0, correct=True, seconds=2.0,
            )  # fmt: skip
            journal.put("unfrozen", n=1, number=1, complete=True)
            journal.put("trial-end", n=1, why="time")
        journal.put(DONE, n=1, attempt=1, result={})
    assert path.name == "t1-a1.study.mcap"
    with Recording.open(path) as recording:
        counts = {
            recording.channels[number].name: count for number, count in recording.counts.items()
        }
    assert counts == {"/study/RuneStudy": 7, "/study/RuneSecondary": 2, "/study/RuneProbe": 1}
    with RecordingSet.open([path]) as recordings:
        events = survey(recordings).events
    kinds = [(each.kind, each.text) for each in events if each.kind is not EventKind.NOTE]
    assert kinds == [
        (EventKind.TRIAL, "t1 trial begin"),
        (EventKind.FREEZE, "t1 frozen"),
        (EventKind.FREEZE, "t1 unfrozen"),
        (EventKind.TRIAL, "t1 trial end"),
    ]
    notes = [each.text for each in events if each.kind is EventKind.NOTE]
    assert len(notes) == 2
    assert notes[1] == "where: right"


def test_a_disk_that_refuses_costs_the_recording_alone(study: StudySpec) -> None:
    step = next(each for each in plan(study, 1) if each.trial)
    with contextlib.closing(Journal.of(study, 1)) as journal:
        (journal.path.parent / "t1-a1.study.mcap").mkdir()
        with study_log(journal, study.digest, "p01", step, 1, {"autonomy": "goals"}):
            journal.put("trial-begin", n=1, moment_s=0.0)
        what = [each.what for each in journal.records]
    assert what == ["session", "unrecorded", "trial-begin"]
