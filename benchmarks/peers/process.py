"""The entry point of every process of a run.

`python -m benchmarks.peers.process ROLE MODULE JOB PARENT`: PARENT is the process that measures.

A contender's module has `broker(job)`, `send(job)`, `receive(job)`, and where it can query
`ask(job)` and `answer(job)`; each serves until the process is killed.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import signal
import sys
import time

from benchmarks.peers.job import Job

_PR_SET_PDEATHSIG = 1


def end_with_parent(parent: int) -> None:
    """Be killed when the process that measures ends, in any way; brokers inherit that.

    Args:
        parent: Process id of who measures.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before this was said
            os._exit(1)


def main() -> None:
    role, module, text, parent = sys.argv[1:]
    end_with_parent(int(parent))
    getattr(importlib.import_module(f"benchmarks.peers.{module}"), role)(Job(**json.loads(text)))
    time.sleep(60.0)  # who measures reads our CPU time first, then kills


if __name__ == "__main__":
    main()
