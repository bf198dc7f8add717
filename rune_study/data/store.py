"""The derived data of a study: computed from journals, answers and recordings, and written."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from hub import files
from hub.plain_text import counted
from hub.table_text import csv_line
from hub.values import dataclass
from rune_study.data.derive import derive
from rune_study.data.overlay import TrialOverlay
from rune_study.data.rows import EventRow, MetricRow, ProbeRow, TrialRow
from rune_study.data.tables import dictionary, write
from rune_study.errors import DataError
from rune_study.metrics.registry import METRICS
from rune_study.plan.folder import participant_folder
from rune_study.plan.study_spec import StudySpec
from rune_study.session.journal import participants_of

DERIVED = "derived"
"""Folder of the tables within that of the study."""

_SHOWN = 3
"""Partial trials that are named in a sentence."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyData:
    """All rows of a study.

    Attributes:
        trials: All trials that were begun.
        metrics: Of those that count.
        overlays: What maps show of those; empty: there are no recordings.
        probes: Questions of freezes, of all attempts at trials.
        events: Events of each participant's session, by the number.
    """

    trials: tuple[TrialRow, ...]
    metrics: tuple[MetricRow, ...]
    overlays: tuple[TrialOverlay, ...] = ()
    probes: tuple[ProbeRow, ...] = ()
    events: Mapping[int, tuple[EventRow, ...]] = dataclasses.field(default_factory=dict)

    @property
    def partial(self) -> list[str]:
        """A sentence on the trials that count and whose recordings lack something, or none."""
        found = [each for each in self.trials if each.partial and not each.excluded]
        if not found:
            return []
        shown = "; ".join(
            f"participant {each.participant}, trial {each.trial}: {each.partial}"
            for each in found[:_SHOWN]
        )
        more = len(found) - _SHOWN
        rest = f"; and {more} more, which the column 'partial' of trials.csv names"
        trials = counted(len(found), "trial")
        return [f"the metrics of {trials} are partial: {shown}{rest if more > 0 else ''}"]


def compute(study: StudySpec, progress: Callable[[float], None]) -> StudyData:
    """Compute all data from the files of the participants, and write them.

    Args:
        study: The study.
        progress: Gets the share of participants that is done, 0 to 1.

    Raises:
        StudyError: No participant has begun, or files cannot be read or written.
    """
    begun = participants_of(study)
    if not begun:
        text = f"no participant of {study.folder} has begun; `rune study run` begins a session"
        raise DataError(text)
    trials: list[TrialRow] = []
    metrics: list[MetricRow] = []
    overlays: list[TrialOverlay] = []
    probes: list[ProbeRow] = []
    events: dict[int, tuple[EventRow, ...]] = {}
    for count, participant in enumerate(begun, 1):
        data = derive(study, participant)
        trials += data.trials
        metrics += data.metrics
        overlays += data.overlays
        probes += data.probes
        events[participant] = data.events
        write(participant_folder(study.folder, participant), "events.tsv", data.events)
        progress(count / len(begun))
    found = StudyData(
        trials=tuple(trials),
        metrics=tuple(metrics),
        overlays=tuple(overlays),
        probes=tuple(probes),
        events=events,
    )
    write_tables(study.folder / DERIVED, found)
    return found


def write_tables(folder: Path, data: StudyData) -> list[Path]:
    """Write trials, metrics, questions of freezes, and the dictionary; returns the files.

    Raises:
        DataError: They cannot be written.
    """
    paths = [
        write(folder, "trials.csv", data.trials),
        write(folder, "metrics.csv", data.metrics),
        folder / "wide.csv",
        folder / "dictionary.json",
    ]
    if data.probes:
        paths.append(write(folder, "probes.csv", data.probes))
    about: dict[str, dict[str, str | float]] = {
        name: {"Description": each.words, "Units": each.unit, "Better": each.better}
        | {
            word: end
            for word, end in (("Minimum", each.least), ("Maximum", each.most))
            if math.isfinite(end)
        }
        for name, each in METRICS.items()
    }
    try:
        files.replace(paths[2], wide(data).encode())
        files.replace(paths[3], dictionary(about).encode())
    except OSError as fault:
        text = f"{folder} cannot be written: {fault.strerror or fault}"
        raise DataError(text) from fault
    return paths


def checksums(study: StudySpec) -> dict[str, str]:
    """SHA-256 of the tables that `compute` wrote, by their files.

    Raises:
        DataError: One cannot be read.
    """
    found = {}
    for name in ("trials.csv", "metrics.csv"):
        path = study.folder / DERIVED / name
        try:
            found[f"{DERIVED}/{name}"] = f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"
        except OSError as fault:
            text = f"{path} cannot be read: {fault.strerror or fault}"
            raise DataError(text) from fault
    return found


def wide(data: StudyData) -> str:
    """The table of `wide_rows` as CSV."""
    return "".join(csv_line(row, "\n") for row in wide_rows(data))


def wide_rows(data: StudyData) -> Iterator[list[str | float | None]]:
    """A heading, and a line for each trial that counts, with a column for each metric."""
    names = [name for name in METRICS if any(row.metric == name for row in data.metrics)]
    values: dict[tuple[int, int, int], dict[str, float]] = {}
    for row in data.metrics:
        key = row.participant, row.trial, row.attempt
        if not row.why:
            values.setdefault(key, {})[row.metric] = row.value
    yield ["participant", "trial", "attempt", "code", *names]
    for trial in data.trials:
        if not trial.excluded:
            found = values.get((trial.participant, trial.trial, trial.attempt), {})
            cells = [found.get(name) for name in names]
            yield [trial.participant, trial.trial, trial.attempt, trial.code, *cells]


def recordings_of(study: StudySpec, participant: int, trial: int) -> Sequence[Path]:
    """The recordings of the last attempt at a trial.

    Raises:
        DataError: There are none.
    """
    folder = participant_folder(study.folder, participant)
    found = sorted(folder.glob(f"t{trial}-a*.mcap"))
    if not found:
        text = f"{folder} has no recording of trial {trial}"
        raise DataError(text)
    last = max(int(path.name.split("-a")[1].split(".")[0]) for path in found)
    return [path for path in found if path.name.startswith(f"t{trial}-a{last}.")]
