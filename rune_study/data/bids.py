"""The data of a study in the folders and tables of BIDS, the Brain Imaging Data Structure.

Each trial that counts is a run of one task: `beh/*_events.tsv` has its events, `beh/*_beh.tsv` its
metrics. What describes people, such as demographics, is private and stays out.
"""

from __future__ import annotations

import dataclasses
import datetime
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from hub import files
from hub.command_line import DISTRIBUTION
from rune_study.data.rows import EventRow, MetricRow, TrialRow
from rune_study.data.store import StudyData
from rune_study.data.tables import described, tsv
from rune_study.errors import DataError
from rune_study.metrics.registry import METRICS
from rune_study.plan.steps import TRIAL, codes, plan
from rune_study.plan.study_spec import StudySpec

BIDS_VERSION = "1.10.0"
_BEGIN, _END = "trial-begin", "trial-end"
_METRIC_COLUMNS = ("metric", "robot", "value", "low", "high", "n", "censored", "why", "note")
_EVENT_COLUMNS = ("onset", "duration", "trial_type", "robot", "value")
_PARTICIPANTS = {
    "participant_id": "number of the participant",
    "order": "codes of the conditions, trial by trial",
    "replaces": "the participant whose order this one took over",
    "trials": "number of trials that count",
}
_SCANS = {
    "filename": "the metrics of a run",
    "acq_time": "begin of the trial, in universal time",
    "condition": "code of the condition",
    "seconds": "length of the trial without freezes and pauses [s]",
    "ended": "what ended it",
}
_README = """# {title}

A study with Rune. Each run of the task is a trial that counts; its number is that of the trial in
the session. Events are in seconds since the begin of the trial. `*_beh.tsv` has the metrics of a
trial, a line each. Trials that do not count, and why, are in `trials.csv` of Rune's own tables.
Recordings are MCAP files, which BIDS does not know; they stay with the study.
"""


def write_bids(study: StudySpec, data: StudyData, folder: Path, *, named: bool) -> list[Path]:
    """Write a dataset.

    Args:
        study: The study.
        data: Its data.
        folder: Gets the dataset; it must be empty or absent.
        named: Whether to name the levels of conditions: no in a blind study.

    Returns:
        The files.

    Raises:
        DataError: The folder has files, or they cannot be written.
    """
    if folder.exists() and any(folder.iterdir()):
        text = f"{folder} is not empty; name another folder with -o"
        raise DataError(text)
    written = []
    try:
        for name, content in _files(study, data, named=named):
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            files.replace(path, content.encode())
            written.append(path)
    except OSError as fault:
        text = f"{folder} cannot be written: {fault.strerror or fault}"
        raise DataError(text) from fault
    return written


def _files(study: StudySpec, data: StudyData, *, named: bool) -> Iterator[tuple[str, str]]:
    task = re.sub(r"[^A-Za-z0-9]", "", study.folder.resolve().name) or "study"
    factors = list(dict.fromkeys(name for levels in study.levels for name in levels))
    factors = factors if named else []
    yield "dataset_description.json", _json(_description(study))
    yield "README.md", _README.format(title=study.title)
    yield "participants.tsv", tsv(list(_PARTICIPANTS), _participants(study, data.trials))
    yield "participants.json", _json(_columns(_PARTICIPANTS))
    yield "scans.json", _json(_columns({**_SCANS, **dict.fromkeys(factors, "a factor")}))
    events_words = described(EventRow, _EVENT_COLUMNS)
    events_words["onset"]["Description"] = "begin since the begin of the trial"
    yield f"task-{task}_events.json", _json(events_words)
    metrics = described(MetricRow, _METRIC_COLUMNS)
    metrics["metric"]["Levels"] = {
        name: f"{each.words}{f' [{each.unit}]' if each.unit else ''}"
        for name, each in METRICS.items()
    }
    about = {"TaskName": task, "TaskDescription": study.title}
    yield f"task-{task}_beh.json", _json({**about, **metrics})
    for participant in sorted({trial.participant for trial in data.trials}):
        counted = [each for each in data.trials if each.participant == participant]
        counted = [each for each in counted if each.trial and not each.excluded]
        sub = f"sub-{participant:02}"
        scans = []
        for trial in counted:
            run = f"beh/{sub}_task-{task}_run-{trial.trial:02}"
            own = [row for row in data.metrics if _same(row, trial)]
            yield f"{sub}/{run}_beh.tsv", tsv(_METRIC_COLUMNS, _cells(own, _METRIC_COLUMNS))
            events = _events(data.events.get(participant, ()), trial)
            yield f"{sub}/{run}_events.tsv", tsv(_EVENT_COLUMNS, _cells(events, _EVENT_COLUMNS))
            levels = dict(study.levels[codes(study).index(trial.code)])
            begin = datetime.datetime.fromtimestamp(trial.begin, datetime.UTC)
            scans.append(
                [
                    f"{run}_beh.tsv",
                    f"{begin:%Y-%m-%dT%H:%M:%S}Z",
                    trial.code,
                    trial.seconds,
                    trial.ended,
                    *(levels.get(name, "") for name in factors),
                ]
            )
        if scans:
            yield f"{sub}/{sub}_scans.tsv", tsv([*_SCANS, *factors], scans)


def _description(study: StudySpec) -> dict[str, Any]:
    generated = {"Name": "Rune", "Version": version(DISTRIBUTION)}
    return {
        "Name": study.title,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [generated],
        "SourceDatasets": [{"Version": f"sha256 {study.digest} of the study's files"}],
    }


def _columns(words: Mapping[str, str]) -> dict[str, dict[str, str]]:
    return {name: {"Description": text} for name, text in words.items()}


def _participants(study: StudySpec, trials: Sequence[TrialRow]) -> Iterator[list[object]]:
    for participant in sorted({trial.participant for trial in trials}):
        own = [trial for trial in trials if trial.participant == participant]
        replaces = max((trial.replaces for trial in own), default=0)
        steps = plan(study, participant, replaces)
        order = "".join(step.code for step in steps if step.kind == TRIAL)
        counted = sum(bool(trial.trial) and not trial.excluded for trial in own)
        name = f"sub-{replaces:02}" if replaces else "n/a"
        yield [f"sub-{participant:02}", order, name, counted]


def _same(row: MetricRow, trial: TrialRow) -> bool:
    which = trial.participant, trial.trial, trial.attempt
    return (row.participant, row.trial, row.attempt) == which


def _events(events: Iterable[EventRow], trial: TrialRow) -> list[EventRow]:
    """Events from the begin to the end of a trial's attempt; onsets count from its begin."""
    found: list[EventRow] = []
    origin = math.nan
    for each in events:
        if each.trial == trial.trial and each.attempt == trial.attempt:
            if each.trial_type == _BEGIN:
                origin = each.onset
            if not math.isnan(origin):
                found.append(dataclasses.replace(each, onset=round(each.onset - origin, 3)))
            if each.trial_type == _END:
                break
    return found


def _cells(rows: Iterable[object], columns: Sequence[str]) -> Iterator[list[object]]:
    return ([getattr(row, name) for name in columns] for row in rows)


def _json(data: object) -> str:
    return json.dumps(data, indent=2, ensure_ascii=False) + "\n"
