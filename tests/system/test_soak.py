"""Ten minutes of `rune demo` driven by a script: memory flat, nobody dead, nothing logged."""

from __future__ import annotations

import os
import random
import sys
import time
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from tests.system.harness import ConsoleProcess, family

MINUTES = 10.0
WARM_UP_S = 60.0
GROWTH = 1.05
HOLDS = ["w", "w", "w", "a", "d", "s", "\x1b[A", "\x1b[C"]
TAPS = ["j", "l", "i", "k", "+", "-", "h", " "]


def _memory(processes: list[psutil.Process]) -> dict[int, int]:
    return {process.pid: process.memory_info().rss for process in processes}


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_ten_minutes_of_driving_change_nothing(own_folders: None) -> None:
    del own_folders
    chance = random.Random(5)
    with closing(ConsoleProcess(["demo"], columns=160, rows=48)) as console:
        console.wait_for_picture()
        processes = family(console.process.pid)
        assert len(processes) == 6
        names = {process.pid: " ".join(process.cmdline()[1:4]) for process in processes}
        started = time.monotonic()
        after_warm_up: dict[int, int] = {}
        while time.monotonic() - started < MINUTES * 60.0:
            console.hold(chance.choice(HOLDS), chance.uniform(0.2, 3.0))
            console.type(chance.choice(TAPS))
            console.pump(chance.uniform(0.0, 1.5))
            assert all(process.is_running() for process in processes)
            if not after_warm_up and time.monotonic() - started > WARM_UP_S:
                after_warm_up = _memory(processes)
        at_end = _memory(processes)
        console.type("q")
        assert console.wait_ended() == 0
    for pid, name in names.items():
        grown = at_end[pid] / after_warm_up[pid]
        sys.stderr.write(f"{name}: {after_warm_up[pid] >> 10} kB, then {grown:.3f} of it\n")
        assert grown <= GROWTH, name
    log = Path(os.environ["XDG_STATE_HOME"]) / "rune" / "log" / "rune.log"
    assert "Traceback" not in log.read_text()
    assert "is started again" not in log.read_text()
