"""A wall clock that steps, for processes that are started with it; the monotonic clock stays."""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path

import pytest

_SOURCE = Path(__file__).parents[1] / "misbehaving" / "wall_clock.c"


class WallClock:
    """What is started with `environment` takes its wall clock from here.

    Attributes:
        environment: Variables of such processes.
    """

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            pytest.skip("NOT TESTED: no C compiler here, so no wall clock that steps")
        library, self._file = folder / "wall_clock.so", folder / "offset"
        command = [compiler, "-shared", "-fPIC", "-O1", "-o", str(library), str(_SOURCE), "-ldl"]
        subprocess.run(command, check=True)
        self.environment = {"LD_PRELOAD": str(library), "RUNE_WALL_CLOCK": str(self._file)}
        self.step(0)

    def step(self, seconds: int) -> None:
        """From now on it is so much ahead of the true one [s]."""
        with self._file.open("r+b" if self._file.exists() else "wb") as opened:
            opened.write(struct.pack("<q", seconds * 10**9))
