"""The data of a participant follow from the journal, the answers and the recordings alone."""

from __future__ import annotations

import contextlib
import dataclasses
from pathlib import Path

import pytest

from hub.gcm.ground_truth import GROUND_TRUTH
from hub.recording.anchor import TimeAnchor
from hub.recording.recording_set import RecordingSet
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from rune_study.data.derive import derive
from rune_study.data.lacking import lacking_time
from rune_study.data.rows import MetricRow
from rune_study.data.store import StudyData, compute, recordings_of
from rune_study.data.tables import read
from rune_study.errors import DataError
from rune_study.plan.folder import participant_folder
from rune_study.plan.steps import TRIAL, plan
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.questionnaires.answers import Answers
from rune_study.questionnaires.questionnaire import find
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.report.making import make_page
from rune_study.session.freezing import ANSWERS, PROBE
from rune_study.session.journal import BEGIN, DONE, Journal
from rune_study.session.secondary import ANSWERED
from tests.study.trial_data.test_trial_data import truth

STUDY = """
title = "Layouts"
seed = "layouts"
participants = 2

[defaults]
arena = "yellow"

[factors]
layout = ["hri-a", "hri-b"]

[trial]
seconds = 10
after = ["sus"]

[metrics]
primary = ["driven"]
effectiveness = "driven"
"""


@pytest.fixture
def study(tmp_path: Path) -> StudySpec:
    (tmp_path / "study.toml").write_text(STUDY)
    return read_study(tmp_path)


def play(study: StudySpec, *, lost: int = 0) -> None:
    """Write what a session of two trials leaves; the recording of one trial may be lost."""
    folder = participant_folder(study.folder, 1)
    sus = read_questionnaire(find("sus"))
    with contextlib.closing(Journal.of(study, 1)) as journal:
        for step in (each for each in plan(study, 1) if each.kind == TRIAL):
            journal.put(BEGIN, n=step.number, attempt=1, step=step.name, trial=step.trial)
            journal.put("trial-begin", n=step.number, moment_s=journal.records[-1].moment)
            begin = journal.records[-1].moment
            if step.trial != lost:
                record(folder / f"t{step.trial}-a1.mcap", begin)
            journal.put("trial-end", n=step.number, why="time", seconds=10.0)
            result = {"ended": "time", "seconds": 10.0}
            journal.put(DONE, n=step.number, attempt=1, result=result)
            with Answers(folder / ANSWERS) as answers:
                for item in sus.items:
                    answers.give(sus, f"t{step.trial}-sus", item, 3.0, 1.0)


def record(path: Path, begin: float) -> None:
    """A robot that drives two metres within the first milliseconds of the trial."""
    writer = RecordingWriter(path, TimeAnchor.now(), {}, WriterLimits(least_free=0))
    for number in range(5):
        moment = begin + number * 1e-6
        payload = GROUND_TRUTH.encode(truth(0.5 * number))
        writer.add(topic_of("magellan", GROUND_TRUTH), payload, moment, moment)
    writer.close()


def of_metric(rows: tuple[MetricRow, ...], name: str) -> list[float]:
    return [row.value for row in rows if row.metric == name]


def nothing(share: float) -> None:
    del share


def test_metrics_follow_from_the_files_and_are_written(study: StudySpec) -> None:
    play(study)
    data = compute(study, nothing)
    assert [row.excluded for row in data.trials] == ["", ""]
    assert of_metric(data.metrics, "driven") == pytest.approx([2.0, 2.0])
    assert of_metric(data.metrics, "sus") == [50.0, 50.0]
    written = read(study.folder / "derived" / "metrics.csv", MetricRow)
    assert repr(tuple(written)) == repr(data.metrics) == repr(compute(study, nothing).metrics)
    events = (participant_folder(study.folder, 1) / "events.tsv").read_text()
    assert "trial-begin" in events


def test_events_begin_at_their_onset_on_one_axis_for_all_trials(study: StudySpec) -> None:
    """Questions are written when they are over; the machine begins anew after the first trial."""
    with contextlib.closing(Journal.of(study, 1)) as journal:
        first, second = (each for each in plan(study, 1) if each.kind == TRIAL)
        journal.put(BEGIN, n=first.number, attempt=1, step=first.name, trial=1)
        begin = journal.records[-1].moment
        journal.put("trial-begin", n=first.number, moment_s=begin)
        for what, given in ((ANSWERED, {"key": "f6"}), (PROBE, {"id": "where"})):
            asked = {"asked": begin - 7.0, "seconds": 0.65, **given}
            journal.put(what, n=first.number, number=1, **asked)
        journal.put(ANSWERED, n=first.number, number=2, asked=begin - 9.0, seconds=None)
        journal.put("trial-end", n=first.number, why="time", seconds=10.0)
        clocks = {"at": journal.records[-1].at + 300.0, "moment": begin + 1e6}
        journal.put(BEGIN, n=second.number, attempt=1, step=second.name, trial=2, **clocks)
        later = {name: value + 5.0 for name, value in clocks.items()}
        journal.put("trial-begin", n=second.number, moment_s=later["moment"], **later)
    rows = derive(study, 1).events
    assert [row.onset for row in rows] == sorted(row.onset for row in rows)
    found = {(row.trial_type, row.trial): row for row in rows}
    start = found["trial-begin", 1].onset
    missed, answered = (row for row in rows if row.trial_type == ANSWERED)
    assert (answered.onset - start, answered.duration) == (pytest.approx(-7.0, abs=1e-2), 0.65)
    assert (missed.onset - start, missed.duration) == (
        pytest.approx(-9.0, abs=1e-2),
        pytest.approx(9.0, abs=1.0),
    )
    assert found[PROBE, 1].duration == 0.65
    assert "asked" not in found[PROBE, 1].value
    assert found["trial-end", 1].duration == 0.0
    assert found["trial-begin", 2].onset == pytest.approx(305.0, abs=2.0)


def test_a_questionnaire_at_the_end_has_a_score_of_the_session(study: StudySpec) -> None:
    play(study)
    sus = read_questionnaire(find("sus"))
    with Answers(participant_folder(study.folder, 1) / ANSWERS) as answers:
        for item in sus.items:
            answers.give(sus, "sus", item, 5.0 if item.id == "q1" else 3.0, 1.0)
    metrics = compute(study, nothing).metrics
    rows = [row for row in metrics if row.trial == 0]
    assert [(row.metric, row.value, row.code) for row in rows] == [("sus", 55.0, "")]
    page = make_page(study, StudyData(trials=(), metrics=metrics), made="today", source="again")
    assert "Asked once per session" in page
    assert '<td class="number">55</td>' in page


def test_a_trial_without_its_recording_is_excluded_with_the_reason(study: StudySpec) -> None:
    play(study, lost=2)
    data = compute(study, nothing)
    assert [row.excluded for row in data.trials] == ["", "its recordings are missing"]
    assert len(of_metric(data.metrics, "driven")) == 1


def test_what_recordings_lack_is_said_of_their_trial(study: StudySpec) -> None:
    play(study)
    cut = participant_folder(study.folder, 1) / "t2-a1.mcap"
    content = cut.read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    data = compute(study, nothing)
    whole, part = (row.partial for row in data.trials)
    assert "the console's recording is missing" in whole
    assert "cut" not in whole
    assert "t2-a1.mcap: " in part
    (note,) = data.partial
    assert note.startswith("the metrics of 2 trials are partial: participant 1, trial 1: the con")
    assert "; participant 1, trial 2: the con" in note
    # Without a console's recording the operator did not do nothing: it is not known.
    rows = [row for row in data.metrics if row.metric in ("episodes", "ie_mean", "command_rate")]
    assert {row.why for row in rows} == {"the operator's inputs were not recorded"}


def test_many_partial_trials_are_counted_in_one_sentence(study: StudySpec) -> None:
    play(study)
    data = compute(study, nothing)
    (row, *_) = (each for each in data.trials if each.partial)
    many = dataclasses.replace(data, trials=(row,) * 64)
    (note,) = many.partial
    assert note.startswith("the metrics of 64 trials are partial: participant 1, trial 1: ")
    assert note.count("participant") == 3
    assert note.endswith("; and 61 more, which the column 'partial' of trials.csv names")
    assert dataclasses.replace(data, trials=()).partial == []


def test_a_recording_that_ends_early_is_said(study: StudySpec) -> None:
    play(study)
    with RecordingSet.open([participant_folder(study.folder, 1) / "t1-a1.mcap"]) as recordings:
        begin, end = recordings.start, recordings.end
        at = 3_000_000_000
        assert list(lacking_time(recordings, begin, end)) == []
        assert list(lacking_time(recordings, begin - at, end + at)) == [
            "t1-a1.mcap begins 3.0 s after the trial",
            "t1-a1.mcap ends 3.0 s before the trial",
        ]


def test_the_last_attempt_is_replayed(study: StudySpec) -> None:
    folder = participant_folder(study.folder, 1)
    folder.mkdir(parents=True)
    for name in ("t1-a1.mcap", "t1-a1.console.mcap", "t1-a10.mcap", "t1-a10.console.mcap"):
        (folder / name).touch()
    found = [path.name for path in recordings_of(study, 1, 1)]
    assert found == ["t1-a10.console.mcap", "t1-a10.mcap"]
    with pytest.raises(DataError, match="has no recording of trial 3"):
        recordings_of(study, 1, 3)


def test_a_study_without_sessions_says_so(study: StudySpec) -> None:
    with pytest.raises(DataError, match=r"no participant of .* has begun"):
        compute(study, nothing)


@pytest.mark.parametrize("kept", [0, 1])
def test_a_session_that_only_began_has_no_trials(study: StudySpec, kept: int) -> None:
    with contextlib.closing(Journal.of(study, 1)) as journal:
        path = journal.path
    path.write_bytes(path.read_bytes() * kept)
    data = compute(study, nothing)
    assert data.trials == data.metrics == ()
    page = make_page(study, data, made="", source="", warnings=["a <b>"])
    assert "<p>Note: a &lt;b&gt;.</p>" in page


def test_a_trial_whose_end_is_damaged_says_so(study: StudySpec) -> None:
    play(study)
    path = participant_folder(study.folder, 1) / "journal.log"
    lines = path.read_bytes().splitlines(keepends=True)
    last = next(at for at, line in enumerate(lines) if b'"what":"done"' in line)
    lines[last] = lines[last].replace(b"done", b"d0ne")
    path.write_bytes(b"".join(lines))
    found = [row.excluded for row in compute(study, nothing).trials]
    why = "it was not completed, or its end is in a damaged line of journal.log"
    assert found == [why, ""]


def test_a_damaged_begin_does_not_mix_trials(study: StudySpec) -> None:
    """The end of the second trial is not taken for that of the first."""
    play(study)
    path = participant_folder(study.folder, 1) / "journal.log"
    lines = path.read_bytes().splitlines(keepends=True)
    begins = [at for at, line in enumerate(lines) if b'"what":"begin"' in line]
    ends = [at for at, line in enumerate(lines) if b'"what":"done"' in line]
    lost = {ends[0], begins[1]}
    path.write_bytes(b"".join(line for at, line in enumerate(lines) if at not in lost))
    assert [row.excluded for row in compute(study, nothing).trials] == ["it was not completed"]
