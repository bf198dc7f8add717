"""A test that tells of its surroundings; `tests/house/test_own_environment.py` runs it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CODE = """
import json, os, signal
print(json.dumps({
    "variables": dict(os.environ),
    "umask": os.umask(0),
    "ignored": [n for n in signal.valid_signals() if signal.getsignal(n) is signal.SIG_IGN],
    "blocked": list(signal.pthread_sigmask(signal.SIG_BLOCK, ())),
}))
"""


def test_tell() -> None:
    with Path(os.environ["RUNE_PROBE"]).open("w") as file:
        subprocess.run([sys.executable, "-c", CODE], stdout=file, check=True)
