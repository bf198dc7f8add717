"""Makes the page of a study from its tables."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence

from rune_study.data.rows import MetricRow, TrialRow
from rune_study.metrics.registry import METRICS
from rune_study.plan.checking import design_report
from rune_study.plan.steps import codes
from rune_study.plan.study_spec import StudySpec
from rune_study.report.comparison import Conditions, asked_once, compare
from rune_study.report.page import MetricWords, StudyReport, html_page
from rune_study.session.journal import Journal

UNBLINDED = "unblinded.log"
"""Journal in the folder of a blind study: when its conditions were named."""
_BETTER = {"higher": "more", "lower": "less"}


def conditions_of(study: StudySpec, *, unblind: bool) -> Conditions:
    """Codes of the conditions in their order, with their levels unless the study is blind."""
    by_code = sorted(zip(codes(study), study.levels, strict=True), key=lambda each: each[0])
    made = Conditions(
        codes=tuple(code for code, _ in by_code), levels=tuple(levels for _, levels in by_code)
    )
    return made.blinded() if study.design.blind and not unblind else made


def make_page(
    study: StudySpec,
    trials: Sequence[TrialRow],
    metrics: Sequence[MetricRow],
    *,
    made: str,
    source: str,
    unblind: bool = False,
    warnings: Sequence[str] = (),
) -> str:
    """The page.

    Args:
        study: The study.
        trials: All trials that were begun.
        metrics: Of the trials that count.
        made: When it is made, in words.
        source: How the figures can be computed again, in a sentence.
        unblind: Whether to name the conditions of a blind study.
        warnings: What is wrong with the data, a sentence each.
    """
    conditions = conditions_of(study, unblind=unblind)
    chosen = study.metrics
    others = chosen.secondary or tuple(name for name in METRICS if name not in chosen.primary)
    of_trials = [row for row in metrics if row.trial]
    once = asked_once(metrics)
    with_data = {row.metric for row in of_trials if not row.why}
    shown = [*chosen.primary, *(name for name in others if name in with_data or chosen.secondary)]
    return html_page(
        StudyReport(
            title=study.title,
            digest=study.digest,
            made=made,
            design=design_report(study),
            conditions=conditions,
            trials=trials,
            primary=chosen.primary,
            results=compare(of_trials, conditions, shown),
            words={name: _words(name) for name in (*shown, *once) if name in METRICS},
            once=once,
            maps={},
            source=source,
            warnings=warnings,
        )
    )


def _words(name: str) -> MetricWords:
    metric = METRICS[name]
    unit = f" [{metric.unit}]" if metric.unit else ""
    return MetricWords(
        label=f"{name}{unit}", meaning=metric.words, better=_BETTER.get(metric.better, "")
    )


def unblinded(study: StudySpec) -> None:
    """Write into a blind study's folder that its conditions were named, and when.

    Raises:
        StudyError: The disk refuses.
    """
    if study.design.blind:
        with contextlib.closing(Journal(study.folder / UNBLINDED)) as journal:
            journal.put("unblinded", study=study.digest)
