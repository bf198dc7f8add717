"""Benchmarks leave nothing behind, whatever ends them."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from tests.support.waiting import until


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_brokers_end_with_the_benchmark_that_started_them(how: signal.Signals) -> None:
    command = [sys.executable, "-m", "benchmarks.bus", "--quick", "--only", "throughput"]
    running = subprocess.Popen(
        [*command, "--peers", "none"],
        cwd=Path(__file__).parents[2],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        process = psutil.Process(running.pid)
        until(lambda: len(process.children(recursive=True)) >= 2, 30.0)
        children = process.children(recursive=True)
        running.send_signal(how)
        running.wait(20.0)
        gone, left = psutil.wait_procs(children, 10.0)
        for each in left:
            each.kill()
        assert len(gone) == len(children)
        assert running.returncode == (128 + how if how == signal.SIGTERM else -how)
    finally:
        running.kill()
        running.wait()
