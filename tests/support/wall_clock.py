"""Clocks of a process that step: its wall clock, and the one that counts sleeps of its machine.

The monotonic clock stays.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path

import pytest

_SOURCE = Path(__file__).parents[1] / "misbehaving" / "wall_clock.c"


class WallClock:
    """What is started with `environment` takes these clocks from here.

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
        self._offsets = [0, 0]
        self.step(0)

    def step(self, seconds: int) -> None:
        """From now on the wall clock is so much ahead of the true one [s]."""
        self._offsets[0] = seconds * 10**9
        self._write()

    def sleep(self, seconds: int) -> None:
        """From now on it is as if the machine had slept for so long before [s]."""
        self._offsets[1] += seconds * 10**9
        self._write()

    def _write(self) -> None:
        with self._file.open("r+b" if self._file.exists() else "wb") as opened:
            opened.write(struct.pack("<2q", *self._offsets))
