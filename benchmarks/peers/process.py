"""The entry point of every process of a run: `python -m benchmarks.peers.process ROLE MODULE JOB`.

A contender's module has `broker(job)`, `send(job)`, `receive(job)`, and where it can query
`ask(job)` and `answer(job)`; each serves until the process is killed.
"""

from __future__ import annotations

import importlib
import json
import sys
import time

from benchmarks.peers.job import Job


def main() -> None:
    role, module, text = sys.argv[1:]
    getattr(importlib.import_module(f"benchmarks.peers.{module}"), role)(Job(**json.loads(text)))
    time.sleep(60.0)  # who measures reads our CPU time first, then kills


if __name__ == "__main__":
    main()
