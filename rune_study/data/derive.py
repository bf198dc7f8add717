"""From a participant's journal, answers and recordings to the rows of the study's tables."""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hub.errors import ArenaError, RecordingError
from hub.values import dataclass
from rune_study.data.lacking import lacking_files, lacking_time
from rune_study.data.overlay import TrialOverlay, overlay_of
from rune_study.data.probes import probes_of, rows_of
from rune_study.data.rows import EventRow, MetricRow, ProbeRow, TrialRow, metric_rows
from rune_study.data.secondary import TaskScore, alone_of, score_of, secondary_of
from rune_study.errors import DataError
from rune_study.metrics.questionnaires import SUS_ITEMS, TLX_SCALES
from rune_study.metrics.registry import measure, scores
from rune_study.metrics.trial import Questionnaires, TrialData
from rune_study.metrics.trial_time import TrialTime, trial_time
from rune_study.plan.folder import arena_of, participant_folder
from rune_study.plan.measures import measures
from rune_study.plan.steps import TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.questionnaires.answers import GivenAnswer, read_answers
from rune_study.questionnaires.questionnaire import find
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.session.freezing import ANSWERS, PROBE
from rune_study.session.journal import (
    BEGIN,
    DONE,
    JOURNAL,
    Record,
    damaged_lines,
    head_of,
    pauses_of,
    read_journal,
)
from rune_study.session.secondary import ANSWERED
from rune_study.session.study_log import CONSOLE_FILE, STUDY_FILE
from rune_study.trial_data.measured import Surroundings, trial_data
from rune_study.trial_data.recorded import recorded_robots
from rune_study.trial_data.truth import truth_of

_OPEN = "it was not completed"
_NO_WORDS = {"n", "attempt", "moment_s", "trial", "asked", "answered"}
_TRIAL_BEGIN = "trial-begin"
_CLOCKS_S = 1.0
"""Larger differences of two clocks between steps show that the machine was started again [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantData:
    """What a participant's files say.

    Attributes:
        trials: All trials that were begun.
        metrics: Of the trials that count, and of the session as a whole.
        events: Of the whole session.
        overlays: What maps show of the trials that count.
        probes: Questions of freezes, of all attempts at trials.
    """

    trials: tuple[TrialRow, ...]
    metrics: tuple[MetricRow, ...]
    events: tuple[EventRow, ...]
    overlays: tuple[TrialOverlay, ...]
    probes: tuple[ProbeRow, ...] = ()


def derive(study: StudySpec, participant: int) -> ParticipantData:
    """Compute all data from a participant's files.

    Raises:
        StudyError: The journal or the answers cannot be read.
    """
    folder = participant_folder(study.folder, participant)
    records = read_journal(folder / JOURNAL)
    head = head_of(records)
    replaces = int(head.data["replaces"]) if head is not None else 0
    damaged = damaged_lines(folder / JOURNAL)
    steps = {step.number: step for step in plan(study, participant, replaces)}
    answers = read_answers(folder / ANSWERS) if (folder / ANSWERS).exists() else []
    asked = _Asked(answers=answers, alone=alone_of(records, steps))
    trials: list[TrialRow] = []
    metrics: list[MetricRow] = []
    overlays: list[TrialOverlay] = []
    probes: list[ProbeRow] = []
    for attempt in _attempts(records, steps):
        row, measured, overlay = _measured(study, participant, replaces, folder, attempt, asked)
        if row.excluded == _OPEN and damaged:
            why = f"{_OPEN}, or its end is in a damaged line of {JOURNAL}"
            row = dataclasses.replace(row, excluded=why)
        trials.append(row)
        metrics += measured
        overlays += overlay
        with contextlib.suppress(DataError):  # then the trial is excluded with the reason
            probes += list(_probes(participant, attempt, answers))
    of_session = {"participant": participant, "trial": 0, "code": ""}
    metrics += metric_rows(of_session, scores(questionnaires(0, answers)))
    return ParticipantData(
        trials=tuple(trials),
        metrics=tuple(metrics),
        events=tuple(_events(records, steps)),
        overlays=tuple(overlays),
        probes=tuple(probes),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Asked:
    """What a participant was asked: all answers, and the secondary task without a robot."""

    answers: Sequence[GivenAnswer]
    alone: TaskScore


@dataclass(frozen=True, slots=True, kw_only=True)
class _Attempt:
    """One attempt at a trial, and what the journal has of it."""

    step: Step
    number: int
    records: tuple[Record, ...]

    def first(self, what: str) -> Record | None:
        return next((each for each in self.records if each.what == what), None)


def _attempts(records: Sequence[Record], steps: Mapping[int, Step]) -> Iterator[_Attempt]:
    begins = [at for at, each in enumerate(records) if each.what == BEGIN]
    for at, end in itertools.pairwise([*begins, len(records)]):
        step = steps.get(int(records[at].data["n"]))
        if step is not None and step.kind == TRIAL:
            number = int(records[at].data["attempt"])
            # The begin of the next step may be damaged.
            own = (
                each for each in records[at:end] if each.data.get("n", step.number) == step.number
            )
            yield _Attempt(step=step, number=number, records=tuple(own))


def _measured(
    study: StudySpec,
    participant: int,
    replaces: int,
    folder: Path,
    attempt: _Attempt,
    asked: _Asked,
) -> tuple[TrialRow, list[MetricRow], list[TrialOverlay]]:
    step, done = attempt.step, attempt.first(DONE)
    begin, result = attempt.first(_TRIAL_BEGIN), done.data["result"] if done is not None else {}
    own: dict[str, Any] = {"participant": participant, "trial": step.trial, "code": step.code}
    own["attempt"] = attempt.number
    row = {
        **own,
        "replaces": replaces,
        "begin": begin.at if begin is not None else math.nan,
        "seconds": float(result.get("seconds", math.nan)),
        "ended": str(result.get("ended", "")),
    }
    if done is None or begin is None:
        return TrialRow(**row, excluded=_OPEN), [], []
    files = sorted(folder.glob(f"{step.name}-a{attempt.number}.*mcap"))
    try:
        data, lacks = _trial_data(study, attempt, files, asked)
        found = metric_rows(own, measure(data, measures(study)))
    except (RecordingError, ArenaError, DataError) as fault:
        return TrialRow(**row, excluded=str(fault)), [], []
    overlay = overlay_of(
        data,
        participant=participant,
        trial=step.trial,
        code=step.code,
        arena=arena_of(study, study.conditions[step.condition]),
        radius=study.metrics.victim_radius_m,
    )
    return TrialRow(**row, partial="; ".join(lacks)), found, [overlay]


def _probes(
    participant: int, attempt: _Attempt, answers: Sequence[GivenAnswer]
) -> Iterator[ProbeRow]:
    step, begin = attempt.step, attempt.first(_TRIAL_BEGIN)
    if begin is not None:
        own = {"participant": participant, "trial": step.trial, "code": step.code}
        found = probes_of(attempt.records, step.name, attempt.number, answers)
        yield from rows_of({**own, "attempt": attempt.number}, float(begin.data["moment_s"]), found)


def _trial_data(
    study: StudySpec, attempt: _Attempt, files: Sequence[Path], asked: _Asked
) -> tuple[TrialData, list[str]]:
    """The data of a trial, and what its recordings lack."""
    if not files:
        text = "its recordings are missing"
        raise DataError(text)
    spec = study.conditions[attempt.step.condition]
    arena = arena_of(study, spec)
    time = _time(attempt)
    around = Surroundings(
        time=trial_time(
            0.0,
            time.end - time.begin,
            [(first - time.begin, last - time.begin) for first, last in time.pauses],
        ),
        truth=truth_of(arena) if arena else None,
        effectiveness=study.metrics.effectiveness,
        queries=tuple(
            each.query
            for each in probes_of(attempt.records, attempt.step.name, attempt.number, asked.answers)
        ),
        secondary=secondary_of(score_of(attempt.records, time.length), asked.alone),
        answers=questionnaires(attempt.step.trial, asked.answers),
    )
    consoles = [file for file in files if file.name.endswith(CONSOLE_FILE)]
    hubs = [file for file in files if not file.name.endswith((CONSOLE_FILE, STUDY_FILE))]
    with recorded_robots(consoles, hubs, time.begin, time.end) as robots:
        data = trial_data({role: log for role, (log, _) in robots.items()}, around)
        lacks = [*lacking_files(consoles, hubs, spec.robots)]
        for log, recordings in robots.values():
            lacks += lacking_time(recordings, log.begin, log.end)
    return data, list(dict.fromkeys(lacks))


def _time(attempt: _Attempt) -> TrialTime:
    """Begin, end and pauses on the monotonic clock of the machine [s]."""
    begin, end = attempt.first(_TRIAL_BEGIN), attempt.first("trial-end")
    if begin is None or end is None:
        text = "the journal lacks its begin or end"
        raise DataError(text)
    return trial_time(float(begin.data["moment_s"]), end.moment, pauses_of(attempt.records))


def questionnaires(trial: int, answers: Sequence[GivenAnswer]) -> Questionnaires:
    """The answers that were given around a trial, or outside trials (0), as metrics take them."""
    prefix = f"t{trial}-" if trial else ""
    given: dict[str, dict[str, Any]] = {}
    for each in answers:
        if each.occasion == f"{prefix}{each.questionnaire}":
            given.setdefault(each.questionnaire, {})[each.item] = each.value
    load, usability, awareness = (given.get(name) for name in ("nasa-tlx", "sus", "sart"))
    return Questionnaires(
        tlx={scale: float(load[scale]) for scale in TLX_SCALES if scale in load}
        if load is not None
        else None,
        tlx_choices=tuple(str(load[name]) for name in load if "-" in name)
        if load is not None
        else None,
        sus=tuple(_marks(usability, [f"q{number}" for number in range(1, SUS_ITEMS + 1)]))
        if usability is not None
        else None,
        sart=tuple(_marks(awareness, [item.id for item in read_questionnaire(find("sart")).items]))
        if awareness is not None
        else None,
    )


def _marks(given: Mapping[str, Any], items: Sequence[str]) -> Iterator[int | None]:
    return (int(given[item]) if item in given else None for item in items)


def _events(records: Sequence[Record], steps: Mapping[int, Step]) -> list[EventRow]:
    """The journal as events by their onset, which counts from the begin of the session."""
    rows = []
    attempt = 0
    for each, written in zip(records, _since_begin(records), strict=True):
        attempt = int(each.data.get("attempt", attempt)) if each.what == BEGIN else attempt
        step = steps.get(int(each.data["n"])) if "n" in each.data else None
        words = {name: value for name, value in each.data.items() if name not in _NO_WORDS}
        before, length = _span(each)
        rows.append(
            EventRow(
                onset=round(written - before, 3),
                duration=round(length, 4),
                trial_type=each.what,
                trial=step.trial if step is not None else 0,
                attempt=attempt if step is not None else 0,
                value=json.dumps(words, ensure_ascii=False) if words else "",
            )
        )
    return sorted(rows, key=lambda row: row.onset)


def _since_begin(records: Sequence[Record]) -> Iterator[float]:
    """When each record was written, since the first one [s].

    The monotonic clock tells within a step. A session may go on after the machine was started
    again, with another such clock: then the date tells how long it rested.
    """
    time = 0.0
    for before, each in itertools.pairwise([*records[:1], *records]):
        passed, dated = each.moment - before.moment, each.at - before.at
        within = each.what != BEGIN and "n" in each.data and each.data["n"] == before.data.get("n")
        if passed < 0.0 or not (within or abs(passed - dated) <= _CLOCKS_S):
            passed = max(0.0, dated)
        time += passed
        yield time


def _span(record: Record) -> tuple[float, float]:
    """How long before its record something began, and how long it lasted [s].

    A question is written when it is over; all others are moments.
    """
    asked, seconds = record.data.get("asked"), record.data.get("seconds")
    if record.what == _TRIAL_BEGIN:
        return record.moment - float(record.data.get("moment_s", record.moment)), 0.0
    if record.what not in (PROBE, ANSWERED) or not isinstance(asked, int | float):
        return 0.0, 0.0
    before = record.moment - asked
    return before, float(seconds) if isinstance(seconds, int | float) else before
