"""Whole sessions with real consoles and simulated robots, played by a scripted operator."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

from hub.errors import HubError
from hub.recording.recording_set import RecordingSet
from hub.values import dataclass
from rune_study.data.store import StudyData, compute, recordings_of
from rune_study.errors import StudyError
from rune_study.plan.folder import participant_folder
from rune_study.plan.steps import plan
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from rune_study.session.journal import JOURNAL, read_journal
from rune_study.session.study_log import CONSOLE_FILE, STUDY_FILE
from rune_study.simulate.agreement import Finding, findings, middle, stops_after
from rune_study.simulate.operator_model import OperatorModel
from rune_study.simulate.script import TrueEpisode, check_playable, write_truth
from rune_study.simulate.study_terminal import StudyTerminal
from rune_study.simulate.typing_operator import DRIVING_KEYS, TypingOperator
from rune_study.trial_data.track import track_of
from rune_study.trial_data.trial_log import TrialLog

TRUTH: Final = "truth.csv"
"""What the operator did, in the folder of the simulation."""
_RESULTS: Final = ("sub-*", "derived", "simulated*", "*.html", ".blind")


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """What became of simulated sessions.

    Attributes:
        study: The study, a copy where it was played on consoles.
        data: Its derived data.
        found: Metrics beside the truth.
        wrong: What went wrong, in words.
        answers: Number of answers that were typed.
    """

    study: StudySpec
    data: StudyData
    found: tuple[Finding, ...]
    wrong: tuple[str, ...]
    answers: int = 0


def play_on_consoles(
    study: StudySpec,
    folder: Path,
    operators: int,
    model: OperatorModel,
    tell: Callable[[str], None],
) -> Played:
    """Play sessions in a copy of a study.

    Args:
        study: The study.
        folder: Gets the copy.
        operators: Number of participants.
        model: Draws episodes and pauses.
        tell: Gets a line when a session ends.

    Raises:
        StudyError: The study cannot be played, or a session does not do what it should.
    """
    check_playable(study, len(DRIVING_KEYS))
    copy = _copied(study, folder)
    episodes: list[TrueEpisode] = []
    wrong: list[str] = []
    answers = 0
    for participant in range(1, operators + 1):
        command = [sys.executable, "-m", "rune_tui", "study", "run", str(copy.folder)]
        with StudyTerminal([*command, "--participant", str(participant)]) as terminal:
            operator = TypingOperator(copy, participant, terminal, model)
            try:
                complete = operator.play()
            finally:
                episodes += operator.episodes
                write_truth(copy.folder / TRUTH, episodes)
        wrong += operator.wrong
        answers += operator.answers
        if not complete:
            wrong.append(f"the session of participant {participant} is not complete")
        tell(f"participant {participant}: {len(operator.episodes)} episodes")
    data = compute(copy, lambda _: None)
    wrong += [
        f"p{row.participant} t{row.trial}: {row.excluded}" for row in data.trials if row.excluded
    ]
    tolerances = {
        (row.participant, row.trial): _tolerance(copy, row.participant, row.trial, episodes)
        for row in data.trials
        if not row.excluded
    }
    lengths = {(row.participant, row.trial): row.seconds for row in data.trials}
    found = findings(episodes, data.metrics, tolerances, lengths)
    return Played(study=copy, data=data, found=tuple(found), wrong=tuple(wrong), answers=answers)


def _copied(study: StudySpec, folder: Path) -> StudySpec:
    """The study in a folder of its own, where people's data are not touched."""
    if folder.exists() and any(folder.glob("sub-*")):
        text = f"{folder} has sessions; name another folder with -o, or remove it"
        raise StudyError(text)
    try:
        ignored = shutil.ignore_patterns(*_RESULTS, folder.resolve().name)
        shutil.copytree(study.folder, folder, ignore=ignored, dirs_exist_ok=True)
    except (OSError, shutil.Error) as fault:
        text = f"{study.folder} cannot be copied to {folder}: {fault}"
        raise StudyError(text) from fault
    return read_study(folder)


def _tolerance(
    study: StudySpec, participant: int, trial: int, episodes: list[TrueEpisode]
) -> float:
    """How long robots went on after the last input, by their true speed [s]."""
    own = [each for each in episodes if (each.participant, each.trial) == (participant, trial)]
    files = [
        file
        for file in recordings_of(study, participant, trial)
        if not file.name.endswith((CONSOLE_FILE, STUDY_FILE))
    ]
    stops: list[float] = []
    try:
        begin = _begin_of(study, participant, trial)
        for robot, file in enumerate(files, 1):
            with RecordingSet.open([file]) as recordings:
                if recordings.anchor is None:
                    return math.nan
                log = TrialLog(recordings, recordings.anchor.stamp(begin))
                ends = [each.end for each in own if each.robot == robot]
                stops += stops_after(track_of(log, log.robots[0]), ends)
    except HubError:
        return math.nan
    return middle(stops)


def _begin_of(study: StudySpec, participant: int, trial: int) -> float:
    """Begin of the last attempt at a trial on the monotonic clock [s]."""
    records = read_journal(participant_folder(study.folder, participant) / JOURNAL)
    steps = {step.number: step for step in plan(study, participant)}
    return max(
        float(each.data["moment_s"])
        for each in records
        if each.what == "trial-begin" and steps[int(each.data["n"])].trial == trial
    )
