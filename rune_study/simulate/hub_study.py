"""Trials on real hubs with simulated robots, driven by a scripted operator without a console."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from hub.gcm.geometry import TwistStamped
from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.client import Client
from hub.recording.recording_set import RecordingSet
from hub.shaper.shaped_link import ShapedLink
from hub.values import dataclass
from rune_study.data.derive import measures
from rune_study.data.rows import MetricRow, TrialRow, metric_rows
from rune_study.data.store import StudyData
from rune_study.errors import DataError, StudyError
from rune_study.metrics.registry import measure
from rune_study.metrics.trial_time import trial_time
from rune_study.plan.folder import arena_of, hub_settings, link_of, participant_folder, robot_of
from rune_study.plan.steps import TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.session.robots import recorded, simulated
from rune_study.session.stage import LOG, names_of_files
from rune_study.simulate.agreement import findings, stopped_after
from rune_study.simulate.console_study import TRUTH, Played
from rune_study.simulate.operator_model import OperatorModel
from rune_study.simulate.script import TrueEpisode, check_playable, script, write_truth
from rune_study.trial_data.measured import Surroundings, trial_data
from rune_study.trial_data.track import track_of
from rune_study.trial_data.trial_log import TrialLog
from rune_study.trial_data.truth import truth_of

_SPEED: Final = 0.4
_TURN: Final = 0.9
_PERIOD_S: Final = 0.05
"""Time between two commands, as a console repeats them [s]."""
_NEUTRAL_S: Final = 0.1
"""A robot whose commands fell silent wants neutral for this time first [s]."""
_START_S: Final = 20.0
_ROBOT: Final = "robot"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Driven:
    """What the operator did in a trial, on the monotonic clock [s].

    Attributes:
        begin: Begin of the trial.
        end: Its end.
        episodes: Begin and end of each episode.
    """

    begin: float
    end: float
    episodes: tuple[tuple[float, float], ...]


def play_on_hubs(
    study: StudySpec,
    folder: Path,
    operators: int,
    model: OperatorModel,
    tell: Callable[[str], None],
) -> Played:
    """Play all trials of a study's plan in real time, and measure them.

    Args:
        study: The study.
        folder: Gets recordings and the operator's truth.
        operators: Number of participants.
        model: Draws episodes and pauses.
        tell: Gets a line when a session ends.

    Raises:
        HubError: The study cannot be played, or a part does not start.
    """
    check_playable(study)
    if folder.exists() and any(folder.glob("sub-*")):
        text = f"{folder} has sessions; name another folder with -o, or remove it"
        raise StudyError(text)
    episodes: list[TrueEpisode] = []
    trials: list[TrialRow] = []
    metrics: list[MetricRow] = []
    tolerances: dict[tuple[int, int], float] = {}
    for participant in range(1, operators + 1):
        of = participant_folder(folder, participant)
        of.mkdir(parents=True, exist_ok=True)
        for step in plan(study, participant):
            if step.kind != TRIAL:
                continue
            file = names_of_files(of, step.name, 1, 1)[0]
            driven = _drive(study, step, file, model)
            own: dict[str, Any] = {"participant": participant, "trial": step.trial, "attempt": 1}
            for begin, end in driven.episodes:
                at = begin - driven.begin, end - driven.begin
                episodes.append(TrueEpisode(**own, begin=at[0], end=at[1]))
            rows, tolerance = _measured(study, step, file, driven, {**own, "code": step.code})
            metrics += rows
            tolerances[participant, step.trial] = tolerance
            seconds = driven.end - driven.begin
            trials.append(TrialRow(**own, code=step.code, seconds=seconds, ended="time"))
        write_truth(folder / TRUTH, episodes)
        tell(f"participant {participant}: {len(trials)} trials so far")
    found = findings(episodes, metrics, tolerances)
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics))
    return Played(study=study, data=data, found=tuple(found), wrong=())


def _drive(study: StudySpec, step: Step, file: Path, model: OperatorModel) -> _Driven:
    """A trial on a hub of its own; the hub's recording goes into a file."""
    spec = study.conditions[step.condition]
    log = file.parent / LOG
    with contextlib.ExitStack() as stack:
        settings = hub_settings(study, spec, step.seed)
        (hub,) = stack.enter_context(simulated([robot_of(study, spec)], settings, log))
        stack.enter_context(recorded([hub], [file], log))
        if spec.link:
            hub = stack.enter_context(
                ShapedLink(hub, link_of(study, spec), step.link_seed)
            ).endpoint
        client = stack.enter_context(contextlib.closing(Client("scripted-operator", hub)))
        seen: list[float] = []
        client.define(VELOCITY_COMMAND)
        client.subscribe(GROUND_TRUTH, lambda _, info: seen.append(info.measured))
        client.wait_connected(_START_S)
        late = time.monotonic() + _START_S
        while not seen:
            client.listen(_PERIOD_S)
            if time.monotonic() > late:
                text = f"the simulated robot does not report; {log} says why"
                raise StudyError(text)
        return _play(client, step, script(model, step, study.metrics.gap_s))


def _play(client: Client, step: Step, spans: tuple[tuple[float, float], ...]) -> _Driven:
    zero = time.monotonic()
    done = []
    for begin, end in spans:
        _listen(client, zero + begin - _NEUTRAL_S)
        client.publish(VELOCITY_COMMAND, TwistStamped.planar(0.0, 0.0))
        _listen(client, zero + begin)
        began = time.monotonic()
        while time.monotonic() < zero + end:
            client.publish(VELOCITY_COMMAND, TwistStamped.planar(_SPEED, _TURN))
            last = time.monotonic()
            _listen(client, min(last + _PERIOD_S, zero + end))
        done.append((began, time.monotonic()))
    _listen(client, zero + step.seconds)
    return _Driven(begin=zero, end=time.monotonic(), episodes=tuple(done))


def _listen(client: Client, until: float) -> None:
    while (left := until - time.monotonic()) > 0.0:
        client.listen(left)


def _measured(
    study: StudySpec, step: Step, file: Path, driven: _Driven, own: dict[str, object]
) -> tuple[list[MetricRow], float]:
    """Metrics of a trial, from the hub's recording and the operator's own inputs."""
    arena = arena_of(study, study.conditions[step.condition])
    around = Surroundings(
        time=trial_time(0.0, driven.end - driven.begin),
        truth=truth_of(arena) if arena else None,
        effectiveness=study.metrics.effectiveness,
    )
    held = np.array(driven.episodes).reshape(-1, 2) - driven.begin
    with RecordingSet.open([file]) as recordings:
        anchor = recordings.anchor
        if anchor is None:
            text = f"{file} does not say its clock"
            raise DataError(text)
        log = TrialLog(recordings, anchor.stamp(driven.begin), anchor.stamp(driven.end))
        data = trial_data({_ROBOT: log}, around)
        tolerance = stopped_after(track_of(log, log.robots[0]), held[:, 1].tolist())
    robots = tuple(
        dataclasses.replace(each, inputs=np.sort(held.ravel()), held=held) for each in data.robots
    )
    found = measure(dataclasses.replace(data, robots=robots), measures(study))
    return metric_rows(own, found), tolerance
