"""A simulated Magellan whose wheels write down what they are told and what they do.

Its file outlives every process of the hub, so it also says what became of the wheels when the hub
died. A row is a time on the monotonic clock [s], the velocities that the wheels are told, and the
true ones: forward [m/s] and turning [rad/s] each.
"""

from __future__ import annotations

import atexit
import os
import struct
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from hub.gcm.navigation import Twist
from hub.robots.description import RobotDescription
from hub.robots.registry import RobotKind
from hub.robots.simulated_base import STEP
from hub.sim.arena import load_arena
from tests.support.magellan import SimulatedMagellan

STILL = 1e-3
"""A robot that is slower stands [m/s, rad/s]."""
_VARIABLE = "RUNE_TEST_WHEELS"
_ROW = struct.Struct("<5d")
_PERIOD_S = 0.02
"""How often a driver looks at its hardware [s]."""
_LONGEST_ROLL = round(1.0 / STEP)


class Row(NamedTuple):
    """What the wheels did at a moment."""

    at: float
    told_linear: float
    told_angular: float
    linear: float
    angular: float

    @property
    def told(self) -> bool:
        """Whether they are told to move."""
        return (self.told_linear, self.told_angular) != (0.0, 0.0)

    @property
    def moves(self) -> bool:
        return max(abs(self.linear), abs(self.angular)) >= STILL


class RecordedMagellan(SimulatedMagellan):
    """The robot; it rolls out when its driver ends, as a real one does."""

    def __init__(self, robot: RobotDescription) -> None:
        super().__init__(
            load_arena(robot.arena),
            linear_limit=robot.linear_limit,
            angular_limit=robot.angular_limit,
        )
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC
        self._file = os.open(os.environ[_VARIABLE], flags)
        atexit.register(self._roll_out)
        self._write()

    def command(self, twist: Twist) -> None:
        """As every base, and note it."""
        before = self._commanded
        super().command(twist)
        if self._commanded != before:
            self._write()

    def advance(self, seconds: float) -> None:
        """As every base, and note it."""
        super().advance(seconds)
        self._write()

    def _write(self) -> None:
        row = Row(
            time.monotonic(), self._commanded[0], self._commanded[2], self._linear, self._angular
        )
        os.write(self._file, _ROW.pack(*row))

    def _roll_out(self) -> None:
        for _ in range(_LONGEST_ROLL):
            if not (self._linear or self._angular):
                return
            time.sleep(STEP)
            self.advance(STEP)


KIND = RobotKind(open_body=RecordedMagellan)


class Wheels:
    """Reads what the wheels of such a robot write.

    Attributes:
        environment: Variables of a hub with such a robot.
    """

    kind = f"{__name__}:KIND"

    def __init__(self, folder: Path) -> None:
        self._path = folder / "wheels"
        self._path.touch()
        self._file = self._path.open("rb")
        self._rows: list[Row] = []
        root = str(Path(__file__).parents[2])
        self.environment = {_VARIABLE: str(self._path), "PYTHONPATH": root}

    @property
    def now(self) -> Row:
        """The last there is."""
        return self.rows()[-1]

    def rows(self) -> list[Row]:
        """All since `forget`."""
        data = self._file.read()
        whole = len(data) - len(data) % _ROW.size
        self._file.seek(whole - len(data), os.SEEK_CUR)
        self._rows += [Row(*each) for each in _ROW.iter_unpack(data[:whole])]
        return self._rows

    def first(self, since: float, holds: Callable[[Row], bool]) -> float | None:
        """When this first held after `since`, after that [s]; None: not yet."""
        return next((row.at - since for row in self.rows() if row.at >= since and holds(row)), None)

    def away(self, since: float, until: float) -> float:
        """For how long in this time whoever moves the wheels did not [s]: the machine was busy."""
        times = [row.at for row in self.rows() if since <= row.at <= until]
        pauses = (later - earlier - _PERIOD_S for earlier, later in pairwise([since, *times]))
        return sum(pause for pause in pauses if pause > _PERIOD_S)

    def forget(self) -> None:
        """All rows but the last."""
        self._rows = self.rows()[-1:]

    def close(self) -> None:
        self._file.close()
