"""Writes what happens in a trial's session into a recording, beside those of hub and console.

A session goes on from its journal. The recording has the same on the time line of the robots, for
`rune replay` and other tools.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from hub.errors import CodecError
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter
from rune_study.plan.steps import Step
from rune_study.session.freezing import PROBE
from rune_study.session.journal import Journal, Record
from rune_study.session.secondary import ANSWERED
from rune_tui.model.study_records import (
    RUNE_PROBE,
    RUNE_SECONDARY,
    RUNE_STUDY,
    STUDY,
    ProbeRecord,
    SecondaryRecord,
    StudyRecord,
)

CONSOLE_FILE, STUDY_FILE = ".console.mcap", ".study.mcap"
"""Ends of the names of recordings that are none of a hub."""
_MOST_NUMBER = 0xFFFF


@contextlib.contextmanager
def study_log(
    journal: Journal,
    study: str,
    participant: str,
    step: Step,
    attempt: int,
    limits: Mapping[str, str],
) -> Iterator[Path]:
    """Write the journal's records into a recording until the end of the context; gives its file.

    A disk that refuses costs the recording, never the session; the journal says so.

    Args:
        journal: The participant's.
        study: Checksum of the study.
        participant: The participant's code.
        step: The trial or practice.
        attempt: Its number.
        limits: Levels of autonomy and assistance, by their keys; none in a blind study.
    """
    path = journal.path.parent / f"{step.name}-a{attempt}{STUDY_FILE}"
    try:
        writer = RecordingWriter(path, TimeAnchor.now(), {"participant": participant, **limits})
    except OSError as fault:
        journal.put("unrecorded", n=step.number, why=f"{path}: {fault.strerror or fault}")
        yield path
        return

    def take(record: Record) -> None:
        whole = StudyRecord(
            study=study,
            participant=participant,
            step=step.name,
            trial=step.trial,
            condition=step.code,
            attempt=min(attempt, _MOST_NUMBER),
            what=record.what,
            detail=json.dumps(record.data),
        )
        _add(writer, RUNE_STUDY, whole, record.moment)
        if record.what == PROBE:
            _add(writer, RUNE_PROBE, _probe(record.data), record.moment)
        elif record.what == ANSWERED:
            _add(writer, RUNE_SECONDARY, _secondary(record.data), record.moment)

    try:
        with journal.heard_by(take):
            yield path
    finally:
        writer.close()
        if writer.state.fault:
            journal.put("unrecorded", n=step.number, why=writer.state.fault)


def _add(
    writer: RecordingWriter,
    definition: MessageDefinition[Any],
    value: object,
    moment: float,
) -> None:
    with contextlib.suppress(CodecError):  # the journal has what does not fit
        writer.add(topic_of(STUDY, definition), definition.encode(value), moment, moment)


def _probe(data: dict[str, Any]) -> ProbeRecord:
    return ProbeRecord(
        id=data["id"],
        about=data["about"],
        freeze=data["number"],
        robot=data["robot"],
        level=data["level"],
        asked=data["asked"],
        answered=data["answered"],
        answer=json.dumps(data["answer"]),
        truth=json.dumps(data["truth"]),
        tolerance=data["tolerance"],
        correct=data["correct"],
        rt=data["seconds"],
    )


def _secondary(data: dict[str, Any]) -> SecondaryRecord:
    seconds = data["seconds"]
    waited = math.nan if seconds is None else float(seconds)
    return SecondaryRecord(
        id=data["number"],
        text=data["text"],
        asked=data["asked"],
        answered=data["asked"] + waited,
        answer=data["key"] or "",
        truth=data["right"],
        counts=data["counts"],
        correct=data["correct"],
        rt=waited,
    )
