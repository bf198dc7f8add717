"""The numbers of a study's metrics."""

from __future__ import annotations

from rune_study.metrics.trial import MeasureSpec
from rune_study.plan.study_spec import StudySpec


def measures(study: StudySpec) -> MeasureSpec:
    """The numbers that a study fixed for its metrics."""
    chosen = study.metrics
    return MeasureSpec(
        gap=chosen.gap_s,
        fraction=chosen.threshold,
        hold=chosen.hold_s,
        tau=chosen.tau_s,
        radius=chosen.victim_radius_m,
    )
