"""Makes the page of a study from its data."""

from __future__ import annotations

import contextlib
import platform
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version

import numpy as np

from hub.command_line import DISTRIBUTION
from hub.errors import ArenaError
from hub.sim.arena import Footprints, load_arena
from hub.toml_reader import keys_of, shown
from rune_study.data.overlay import TrialOverlay
from rune_study.data.store import StudyData
from rune_study.metrics.registry import METRICS
from rune_study.plan.design_report import design_report
from rune_study.plan.steps import codes
from rune_study.plan.study_spec import StudySpec
from rune_study.report.comparison import Conditions, asked_once, compare
from rune_study.report.maps import ConditionMap, colours_of, condition_map, longest_stay
from rune_study.report.page import StudyReport, html_page
from rune_study.report.results import MetricWords, Results
from rune_study.session.journal import Journal

UNBLINDED = "unblinded.log"
"""Journal in the folder of a blind study: when its conditions were named."""
_BETTER = {"higher": "more", "lower": "less"}
_OF_TAU = ("nt_restricted_mean", "rad", "ft", "fo")
"""Metrics that stand on the restricted mean of neglect tolerance."""


def conditions_of(study: StudySpec, *, unblind: bool) -> Conditions:
    """Codes of the conditions in their order, with their levels unless the study is blind."""
    by_code = sorted(zip(codes(study), study.levels, strict=True), key=lambda each: each[0])
    made = Conditions(
        codes=tuple(code for code, _ in by_code), levels=tuple(levels for _, levels in by_code)
    )
    return made.blinded() if study.design.blind and not unblind else made


def make_page(
    study: StudySpec,
    data: StudyData,
    *,
    made: str,
    source: str,
    unblind: bool = False,
    warnings: Sequence[str] = (),
    sessions: Mapping[int, str] | None = None,
    checksums: Mapping[str, str] | None = None,
) -> str:
    """The page.

    Args:
        study: The study.
        data: Trials, metrics and overlays.
        made: When it is made, in words.
        source: How the figures can be computed again, in a sentence.
        unblind: Whether to name the conditions of a blind study.
        warnings: What is wrong with the data, a sentence each.
        sessions: How far each participant came, by number.
        checksums: SHA-256 of files that the page stands on, by their names.
    """
    conditions = conditions_of(study, unblind=unblind)
    chosen = study.metrics
    others = chosen.secondary or tuple(name for name in METRICS if name not in chosen.primary)
    of_trials = [row for row in data.metrics if row.trial]
    once = asked_once(data.metrics)
    with_data = {row.metric for row in of_trials if not row.why}
    wanted = (name for name in others if name in with_data or chosen.secondary)
    only_once = {name for name in once if name not in with_data}
    shown = [*chosen.primary, *(name for name in wanted if name not in only_once)]
    return html_page(
        StudyReport(
            title=study.title,
            digest=study.digest,
            made=made,
            design=design_report(study),
            results=Results(
                conditions=conditions,
                trials=data.trials,
                primary=chosen.primary,
                results=compare(of_trials, conditions, shown),
                words={name: _words(study, name) for name in (*shown, *once) if name in METRICS},
                once=once,
            ),
            fixed=dict(_fixed(study)),
            maps=maps_of(data.overlays, conditions),
            colours=colours_of(each.participant for each in data.overlays),
            source=source,
            software={**_software(study), **(checksums or {})},
            sessions=sessions or {},
            warnings=warnings,
        )
    )


def maps_of(overlays: Sequence[TrialOverlay], conditions: Conditions) -> dict[str, ConditionMap]:
    """A map of each condition in which robots drove, by its title."""
    groups: dict[str, list[TrialOverlay]] = {}
    for each in overlays:
        groups.setdefault(each.code, []).append(each)
    colours = colours_of(each.participant for each in overlays)
    most = longest_stay(groups.values())
    maps: dict[str, ConditionMap] = {}
    for number, (code, levels) in enumerate(
        zip(conditions.codes, conditions.levels, strict=True), 1
    ):
        group = groups.get(code)
        if group is not None:
            what = ", ".join(f"{name} {level}" for name, level in levels.items())
            title = f"{code}: {what}" if what else f"Condition {code}"
            walls = _walls(group[0].arena)
            maps[title] = condition_map(title, group, walls, colours, number=number, most=most)
    return maps


def _walls(arena: str) -> Footprints | None:
    if not arena:
        return None
    try:
        return load_arena(arena).footprints
    except ArenaError:
        return None


def _words(study: StudySpec, name: str) -> MetricWords:
    metric = METRICS[name]
    unit = f" [{metric.unit}]" if metric.unit else ""
    caution = ""
    if name in _OF_TAU and not study.metrics.tau_s:
        caution = (
            "the bound of the restricted mean is that of each trial, so trials are not quite "
            "comparable; 'tau_s' in [metrics] gives all of them the same one."
        )
    return MetricWords(
        label=f"{name.replace('_', ' ')}{unit}",
        meaning=metric.words,
        better=_BETTER.get(metric.better, ""),
        caution=caution,
    )


def _fixed(study: StudySpec) -> Iterator[tuple[str, tuple[str, str]]]:
    """The table [metrics] of a study: value and meaning, by its keys."""
    for name, key in keys_of(type(study.metrics)).items():
        value = getattr(study.metrics, key.field)
        text = ", ".join(value) if isinstance(value, tuple) else str(value)
        yield name, (shown(key) if value == key.default else text, key.meaning)


def _software(study: StudySpec) -> dict[str, str]:
    return {
        DISTRIBUTION: version(DISTRIBUTION),
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "study.toml and its folders": f"SHA-256 {study.digest}",
    }


def unblinded(study: StudySpec) -> None:
    """Write into a blind study's folder that its conditions were named, and when.

    Raises:
        StudyError: The disk refuses.
    """
    if study.design.blind:
        with contextlib.closing(Journal(study.folder / UNBLINDED)) as journal:
            journal.put("unblinded", study=study.digest)
