"""Waiting for conditions, so that no test sleeps for luck."""

from __future__ import annotations

import time
from collections.abc import Callable


def until(
    condition: Callable[[], object],
    timeout: float,
    why: str | Callable[[], str] = "it did not happen",
    *,
    meanwhile: Callable[[], object] = lambda: time.sleep(0.01),
) -> None:
    """Return as soon as `condition` holds; fail after `timeout` [s].

    Args:
        condition: What to wait for.
        timeout: Generous: only a failing test waits that long [s].
        why: What the failure says.
        meanwhile: What to do between two looks.
    """
    end = time.monotonic() + timeout
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(why if isinstance(why, str) else why())
        meanwhile()
