"""How often tests repeat what chance decides: `make soak` repeats it most."""

from __future__ import annotations

import os


def repetitions(quick: int, thorough: int) -> int:
    """The number of repetitions: `quick` in `make test`, `thorough` in `make soak`."""
    return thorough if os.environ.get("HYPOTHESIS_PROFILE") == "thorough" else quick
