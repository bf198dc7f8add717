"""A command of `rune-hub` that runs until its standard input ends."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from typing import Any

from tests.support import warm_start


class RunningCommand:
    """`rune-hub WORDS --json --stop-with-stdin`.

    Attributes:
        process: The process.
        ready: The first line that it printed.
    """

    def __init__(self, *words: str) -> None:
        self.process = warm_start.start(
            [sys.executable, "-m", "hub", *words, "--json", "--stop-with-stdin"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=sys.__stderr__.fileno() if sys.__stderr__ else 2,
            environment=dict(os.environ),
        )
        assert self.process.stdout is not None
        self.ready: dict[str, Any] = json.loads(self.process.stdout.readline())

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.close()

    def close(self) -> None:
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()
        self.process.wait(10.0)
