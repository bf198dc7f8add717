"""Examples of property tests: the same in each run of `make test`, new ones in each `make soak`."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings


def choose() -> None:
    """Load the profile that HYPOTHESIS_PROFILE names; by default `patient`.

    A busy machine is no failure in either. `thorough` tries twenty times as many examples and
    keeps those that fail for its next run. What it finds becomes an example of its test.
    """
    settings.register_profile(
        "patient",
        settings.get_profile("default"),  # also where CI is set
        deadline=None,
        max_examples=20,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.too_slow],
    )
    settings.register_profile(
        "thorough",
        settings.get_profile("default"),
        deadline=None,
        max_examples=400,
        suppress_health_check=[HealthCheck.too_slow],
    )
    chosen = os.environ.get("HYPOTHESIS_PROFILE", "patient")
    settings.load_profile(chosen)
    if chosen == "patient":
        # Hypothesis also tries constants of all modules that are loaded: other tests load them.
        pytest.MonkeyPatch().setattr(
            "hypothesis.internal.conjecture.providers.is_local_module_file", lambda _: False
        )
