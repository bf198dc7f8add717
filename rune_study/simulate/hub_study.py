"""Trials on real hubs with simulated robots, driven by a scripted operator without a console."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from hub.gcm.geometry import TwistStamped
from hub.gcm.ground_truth import GROUND_TRUTH
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.client import Client
from hub.plain_text import counted
from hub.recording.recording_set import RecordingSet
from hub.shaper.shaped_link import ShapedLink
from hub.values import dataclass
from rune_study.data.overlay import TrialOverlay, overlay_of
from rune_study.data.rows import MetricRow, TrialRow, metric_rows
from rune_study.data.store import StudyData
from rune_study.errors import DataError, StudyError
from rune_study.metrics.registry import measure
from rune_study.metrics.trial_time import trial_time
from rune_study.plan.folder import arena_of, hub_settings, link_of, participant_folder, robot_of
from rune_study.plan.measures import measures
from rune_study.plan.steps import TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.session.robots import Recorders, simulated
from rune_study.session.stage import LOG, names_of_files
from rune_study.simulate.agreement import findings, middle, stops_after
from rune_study.simulate.console_study import TRUTH, Played
from rune_study.simulate.operator_model import OperatorModel
from rune_study.simulate.script import (
    Service,
    TrueEpisode,
    check_playable,
    script,
    true_episode,
    write_truth,
)
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
MOST_ROBOTS: Final = 16
"""As many as a condition has."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Driven:
    """What the operator did in a trial.

    Attributes:
        begin: Begin of the trial on the monotonic clock [s].
        end: Its end.
        services: The episodes as they were [s of the trial].
    """

    begin: float
    end: float
    services: tuple[Service, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Measured:
    """Metrics of a trial, what a map shows of it, and the true neglect tolerance [s]."""

    metrics: list[MetricRow]
    overlay: TrialOverlay
    tolerance: float


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
    check_playable(study, MOST_ROBOTS)
    if folder.exists() and any(folder.glob("sub-*")):
        text = f"{folder} has sessions; name another folder with -o, or remove it"
        raise StudyError(text)
    episodes: list[TrueEpisode] = []
    trials: list[TrialRow] = []
    metrics: list[MetricRow] = []
    overlays: list[TrialOverlay] = []
    tolerances: dict[tuple[int, int], float] = {}
    for participant in range(1, operators + 1):
        of = participant_folder(folder, participant)
        of.mkdir(parents=True, exist_ok=True)
        for step in plan(study, participant):
            if step.kind != TRIAL:
                continue
            robots = study.conditions[step.condition].robots
            recordings = names_of_files(of, step.name, 1, robots)[:-1]
            driven = _drive(study, step, recordings, model)
            own: dict[str, Any] = {"participant": participant, "trial": step.trial, "attempt": 1}
            episodes += [true_episode(own, each) for each in driven.services]
            own_metrics = {**own, "code": step.code}
            measured = _measured(study, step, recordings, driven, own_metrics)
            metrics += measured.metrics
            overlays.append(measured.overlay)
            tolerances[participant, step.trial] = measured.tolerance
            seconds = driven.end - driven.begin
            trials.append(TrialRow(**own, code=step.code, seconds=seconds, ended="time"))
        write_truth(folder / TRUTH, episodes)
        tell(f"participant {participant}: {counted(len(trials), 'trial')} so far")
    lengths = {(row.participant, row.trial): row.seconds for row in trials}
    found = findings(episodes, metrics, tolerances, lengths)
    data = StudyData(trials=tuple(trials), metrics=tuple(metrics), overlays=tuple(overlays))
    return Played(study=study, data=data, found=tuple(found), wrong=())


def _drive(
    study: StudySpec, step: Step, recordings: Sequence[Path], model: OperatorModel
) -> _Driven:
    """A trial on hubs of its own; their recordings go into files."""
    spec = study.conditions[step.condition]
    log = recordings[0].parent / LOG
    with contextlib.ExitStack() as stack:
        settings = hub_settings(study, spec, step.seed)
        hubs = stack.enter_context(simulated([robot_of(study, spec)] * spec.robots, settings, log))
        stack.enter_context(Recorders(hubs, recordings, log))
        if spec.link:
            profile, seed = link_of(study, spec), step.link_seed
            links = [stack.enter_context(ShapedLink(hub, profile, seed)) for hub in hubs]
            hubs = [link.endpoint for link in links]
        clients = [stack.enter_context(contextlib.closing(_client(hub, log))) for hub in hubs]
        return _play(clients, step, script(model, step, study.metrics.gap_s, spec.robots))


def _client(hub: str, log: Path) -> Client:
    """A connection to a hub whose simulated robot reports."""
    client = Client("scripted-operator", hub)
    try:
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
    except BaseException:
        client.close()
        raise
    return client


def _play(clients: Sequence[Client], step: Step, services: Sequence[Service]) -> _Driven:
    """Drive robots during their episodes, and further until their work ends."""
    zero = time.monotonic()
    began: dict[Service, float] = {}
    while (now := time.monotonic() - zero) < step.seconds:
        for each in services:
            if each.begin <= now < each.until:
                began.setdefault(each, now)
                clients[each.robot].publish(VELOCITY_COMMAND, TwistStamped.planar(_SPEED, _TURN))
            elif each.begin - _NEUTRAL_S <= now < each.begin:
                clients[each.robot].publish(VELOCITY_COMMAND, TwistStamped.planar(0.0, 0.0))
        begins = (each.begin for each in services if each.begin > now)
        until = min(now + _PERIOD_S, min(begins, default=step.seconds), step.seconds)
        _listen(clients, zero + until)
    end = time.monotonic()
    done = (
        dataclasses.replace(each, begin=at, until=min(each.until, end - zero))
        for each, at in began.items()
    )
    return _Driven(begin=zero, end=end, services=tuple(done))


def _listen(clients: Sequence[Client], until: float) -> None:
    for left, client in zip(range(len(clients), 0, -1), clients, strict=True):
        client.listen(max(0.0, until - time.monotonic()) / left)


def _measured(
    study: StudySpec,
    step: Step,
    recordings: Sequence[Path],
    driven: _Driven,
    own: dict[str, Any],
) -> _Measured:
    """What hubs' recordings and the operator's own inputs give."""
    arena = arena_of(study, study.conditions[step.condition])
    around = Surroundings(
        time=trial_time(0.0, driven.end - driven.begin),
        truth=truth_of(arena) if arena else None,
        effectiveness=study.metrics.effectiveness,
    )
    held = [
        np.array([(each.begin, each.end) for each in driven.services if each.robot == robot])
        for robot in range(len(recordings))
    ]
    with contextlib.ExitStack() as stack:
        logs = {
            f"robot {number}": _log(stack.enter_context(RecordingSet.open([file])), driven)
            for number, file in enumerate(recordings, 1)
        }
        data = trial_data(logs, around)
        stops = [
            stop
            for log, spans in zip(logs.values(), held, strict=True)
            for stop in stops_after(track_of(log, log.robots[0]), [end for _, end in spans])
        ]
    robots = tuple(
        dataclasses.replace(each, inputs=np.sort(spans.ravel()), held=spans.reshape(-1, 2))
        for each, spans in zip(data.robots, held, strict=True)
    )
    data = dataclasses.replace(data, robots=robots, inputs_known=True)
    return _Measured(
        metrics=metric_rows(own, measure(data, measures(study))),
        overlay=overlay_of(
            data,
            participant=own["participant"],
            trial=own["trial"],
            code=own["code"],
            arena=arena,
            radius=study.metrics.victim_radius_m,
        ),
        tolerance=middle(stops),
    )


def _log(recordings: RecordingSet, driven: _Driven) -> TrialLog:
    anchor = recordings.anchor
    if anchor is None:
        text = f"{recordings.path.name} does not say its clock"
        raise DataError(text)
    return TrialLog(recordings, anchor.stamp(driven.begin), anchor.stamp(driven.end))
