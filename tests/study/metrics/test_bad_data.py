"""Data that cannot be: stamps that jump, ends that are none, bits that are no bits."""

from __future__ import annotations

import math

import pytest

from rune_study.errors import DataError
from rune_study.metrics.bumps import bumps
from rune_study.metrics.driving import camera_off_centre, success_by_path_length
from rune_study.metrics.effectiveness import rate_of_progress, signal
from rune_study.metrics.episodes import episodes
from rune_study.metrics.latency import motion_to_photon
from rune_study.metrics.registry import measure
from rune_study.metrics.steering import held
from rune_study.metrics.trial import TrialData
from tests.support.cases import for_each


@for_each(
    ("call", "what"),
    [
        (lambda: bumps([0, 5, 3], [0, 1, 2], [0, 0, 0], [0, 0, 0]), "finite, ascending"),
        (lambda: bumps([0, math.inf], [0, 1], [0, 0], [0, 0]), "finite, ascending"),
        (lambda: bumps([0, 1], [0, math.nan], [0, 0], [0, 0]), "finite counts"),
        (lambda: bumps([0, 1], [0, 1], [0, -1], [0, 0]), "from 0 on"),
        (lambda: bumps([0, 1], [0, 1], ["left", 0], [0, 0]), "from 0 on"),
        (lambda: camera_off_centre([5, 3], [0, 0], [1, 1], [0, 0], 9), "ascending"),
        (lambda: episodes([1, 2], held=[(1, math.nan)]), "not finite"),
        (lambda: held([0, 1], [0, 1], math.nan, 50.0), "finite end"),
        (lambda: rate_of_progress(signal([0, 1], [0, 1]), math.inf), "finite"),
        (lambda: motion_to_photon([1], [1, 2], [], []), "the time of its answer"),
        (lambda: success_by_path_length(3.0, -1.0, arrived=True), "not shorter than 0 m"),
        (lambda: measure(TrialData(length=math.nan)), "lasts from 0 s to 1e"),
        (lambda: measure(TrialData(length=1e12)), "lasts from 0 s to 1e"),
    ],
)
def test_it_is_refused_in_a_sentence(call, what: str) -> None:
    with pytest.raises(DataError, match=what):
        call()
