"""How every benchmark reports: one JSON line a figure on standard output, the rest elsewhere."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping


def report(
    name: str,
    value: float | None,
    unit: str,
    *,
    bar: float | None = None,
    better: str = "lower",
    peers: Mapping[str, float] | None = None,
    note: str = "",
) -> None:
    """Print one figure; value None and a note where it could not be measured."""
    line = {
        "name": name,
        "value": value if value is None else round(value, 4),
        "unit": unit,
        "better": better,
        "bar": bar,
        "peers": dict(peers or {}),
        "note": note,
    }
    print(json.dumps(line), flush=True)


def say(text: str) -> None:
    """Progress for the person who waits."""
    print(text, file=sys.stderr, flush=True)


def median_ms(
    work: Callable[[int], object],
    runs: int,
    warmup: int = 3,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Median time of one call of `work`, which gets the number of the call [ms].

    `time.thread_time` as the clock leaves out what other processes of the machine take.
    """
    for index in range(warmup):
        work(index)
    times = []
    for index in range(runs):
        start = clock()
        work(index)
        times.append(clock() - start)
    return sorted(times)[len(times) // 2] * 1e3
