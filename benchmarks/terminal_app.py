"""What video costs inside Textual: processor time of the real console on a real pseudo-terminal.

The camera pans over a detailed scene, so nearly every cell changes with every picture, and the
terminal reads as fast as the console writes. What the console takes without pictures is measured
in the same run and taken off.
"""

from __future__ import annotations

import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from benchmarks.panning_robot import COLUMNS, LAYOUT, ROWS, panning_robots
from benchmarks.stand_in_robot import fleet
from tests.system.harness import ConsoleProcess

WARM_S, MEASURED_S = 4.0, 10.0
ROUNDS = 3
RATES = {"app_cpu_15fps": (15.0, 0.06), "app_cpu_30fps": (30.0, 0.12)}
IDLE_MS = 3_600_000
"""Between two pictures where none is wanted after the first [ms]."""


def cost(interval_ms: int) -> tuple[float, float, float]:
    """Share of a core, pictures a second, bytes a second."""
    with fleet(panning_robots) as robots, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT.format(hub=robots.hubs[0], interval=interval_ms))
        environment = {"COLORTERM": "truecolor"}
        with closing(
            ConsoleProcess(["run", str(path)], columns=COLUMNS, rows=ROWS, environment=environment)
        ) as console:
            console.drain(WARM_S)
            process = psutil.Process(console.process.pid)
            (pictures,) = robots.count()
            before, written, began = process.cpu_times(), console.output_bytes, time.monotonic()
            console.drain(MEASURED_S)
            took, after = time.monotonic() - began, process.cpu_times()
            pictures = robots.count()[0] - pictures
    spent = after.user + after.system - before.user - before.system
    return spent / took, pictures / took, (console.output_bytes - written) / took


def median(interval_ms: int) -> tuple[float, float, float]:
    """The round of median cost."""
    return sorted(cost(interval_ms) for _ in range(ROUNDS))[ROUNDS // 2]


def main() -> None:
    wanted = sys.argv[1:] or RATES
    idle, *_ = median(IDLE_MS)
    say(f"without pictures: {idle:.3f} of a core")
    for name in wanted:
        rate, bar = RATES[name]
        cpu, shown, written = median(round(1000 / rate))
        note = f"{shown:.1f} pictures/s, {written / 1e3:.0f} kB/s; {idle:.3f} without pictures"
        report(f"terminal.{name}", cpu - idle, "of a core", bar=bar, note=note)
        if name == "app_cpu_30fps":
            report("terminal.app_ms_per_frame", 1e3 * (cpu - idle) / shown, "ms", bar=3.0)


if __name__ == "__main__":
    main()
