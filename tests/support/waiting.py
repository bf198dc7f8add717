"""Waiting for conditions, so that no test sleeps for luck."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

_BETWEEN_S = 0.005
"""A loop without a pause would keep the processor from what it waits for."""
_ROUNDS = 500_000
_ROUNDS_S = 0.015
"""Time for so many rounds on the idle machine for which limits are chosen [s]."""
_MOST = 10.0


def slowness() -> float:
    """How many times as long work takes here now as on an idle, usual machine; 1 to 10."""
    begin, total = time.monotonic(), 0
    for number in range(_ROUNDS):
        total += number & 7
    return min(_MOST, max(1.0, (time.monotonic() - begin) / _ROUNDS_S))


def within(seconds: float, most: float) -> bool:
    """Whether something took no longer than `most` [s], or in proportion on a slow machine."""
    return seconds <= most or seconds <= most * slowness()


class Limit:
    """A limit of time, longer in proportion while the machine is slow or busy."""

    def __init__(self, seconds: float) -> None:
        self._seconds = self._allowed = seconds
        self._begin = time.monotonic()

    @property
    def over(self) -> bool:
        """Whether it has passed."""
        waited = time.monotonic() - self._begin
        if waited > self._allowed:
            self._allowed = max(self._allowed, self._seconds * slowness())
        return waited > self._allowed


def until(
    condition: Callable[[], object],
    timeout: float,
    why: str | Callable[[], str] = "it did not happen",
    *,
    meanwhile: Callable[[], object] = lambda: None,
) -> None:
    """Return as soon as `condition` holds; fail after the `Limit` of `timeout` [s].

    Args:
        condition: What to wait for.
        timeout: Generous: only a failing test waits that long [s].
        why: What the failure says.
        meanwhile: What to do between two looks, which are some milliseconds apart.
    """
    limit = Limit(timeout)
    while not condition():
        if limit.over:
            if condition():  # this process was held up as well
                return
            raise AssertionError(why if isinstance(why, str) else why())
        meanwhile()
        time.sleep(_BETWEEN_S)


class Ending(Protocol):
    """A process that ends, as `subprocess` and `warm_start` have it."""

    def poll(self) -> int | None: ...


def exit_code(process: Ending, timeout: float) -> int:
    """How a process ends, which it does within the `Limit` of `timeout` [s]."""
    until(lambda: process.poll() is not None, timeout, "the process does not end")
    code = process.poll()
    assert code is not None
    return code
