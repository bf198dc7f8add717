"""Waiting for conditions, so that no test sleeps for luck."""

from __future__ import annotations

import time
from collections.abc import Callable

_BETWEEN_S = 0.005
"""A loop without a pause would keep the processor from what it waits for."""


def until(
    condition: Callable[[], object],
    timeout: float,
    why: str | Callable[[], str] = "it did not happen",
    *,
    meanwhile: Callable[[], object] = lambda: None,
) -> None:
    """Return as soon as `condition` holds; fail after `timeout` [s].

    Args:
        condition: What to wait for.
        timeout: Generous: only a failing test waits that long [s].
        why: What the failure says.
        meanwhile: What to do between two looks, which are some milliseconds apart.
    """
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(why if isinstance(why, str) else why())
        meanwhile()
        time.sleep(_BETWEEN_S)
