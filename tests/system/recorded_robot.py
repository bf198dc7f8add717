"""A simulated robot with any of the bodies, which writes down its commands and its motion.

Its file outlives every process of the hub, so it also says what became of the robot when the hub
died. A row is a time on the monotonic clock [s], the velocities that the driver commands, and the
true ones: forward, to the left, up [m/s] and turning [rad/s] each.
"""

from __future__ import annotations

import atexit
import math
import os
import struct
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from hub.gcm.geometry import Twist
from hub.robots.description import RobotDescription
from hub.robots.interfaces import Body
from hub.robots.registry import KINDS, RobotKind
from hub.robots.simulated_base import STEP
from tests.support.bodies import STANDING, STILL, hub_with

_VARIABLE = "RUNE_TEST_WHEELS"
_ROW = struct.Struct("<9d")
_PERIOD_S = 0.02
"""How often a driver looks at its hardware [s]."""
_LONGEST_ROLL = round(1.0 / STEP)


class Row(NamedTuple):
    """The commands and the motion of the robot at a moment."""

    at: float
    wanted_surge: float
    wanted_sway: float
    wanted_heave: float
    wanted_yaw: float
    surge: float
    sway: float
    heave: float
    yaw: float

    @property
    def commanded(self) -> bool:
        """Whether a motion is commanded."""
        return any(self[1:5])

    @property
    def speed(self) -> float:
        """[m/s]"""
        return math.hypot(self.surge, self.sway, self.heave)


class Recorder:
    """Writes what a body gets and does; it rolls out when its driver ends, as a real one does."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self._command, self._advance = body.command, body.advance
        self._wanted = (0.0, 0.0, 0.0, 0.0)
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC
        self._file = os.open(os.environ[_VARIABLE], flags)
        atexit.register(self._roll_out)
        self._write()

    def command(self, twist: Twist) -> None:
        """As the body, and note it."""
        self._command(twist)
        before, linear = self._wanted, twist.linear
        self._wanted = (linear.x, linear.y, linear.z, twist.angular.z)
        if self._wanted != before:
            self._write()

    def advance(self, seconds: float) -> None:
        """As the body, and note it."""
        self._advance(seconds)
        self._write()

    def _write(self) -> Row:
        truth = self._body.ground_truth()
        assert truth is not None
        moves = truth.linear, truth.sway, truth.heave, truth.angular
        row = Row(time.monotonic(), *self._wanted, *moves)
        os.write(self._file, _ROW.pack(*row))
        return row

    def _roll_out(self) -> None:
        for _ in range(_LONGEST_ROLL):
            time.sleep(STEP)
            self._advance(STEP)
            row = self._write()
            if max(row.speed, abs(row.yaw)) < STANDING:
                return


def _opened(robot: RobotDescription) -> Body:
    """The body itself, with all its abilities; only two of its methods are recorded."""
    body = KINDS["simulated-wheels"].open_body(robot)
    recorder = Recorder(body)
    vars(body).update(command=recorder.command, advance=recorder.advance)
    return body


KIND = RobotKind(open_body=_opened)


class Recording:
    """Reads what such a robot writes.

    Attributes:
        environment: Variables of a hub with such a robot.
        hub: Keys of a `HubProcess` with it.
    """

    def __init__(self, folder: Path, body: str) -> None:
        self._path = folder / "wheels"
        self._path.touch()
        self._file = self._path.open("rb")
        self._rows: list[Row] = []
        self._still = STILL.get(body, STANDING)
        root = str(Path(__file__).parents[2])
        self.environment = {_VARIABLE: str(self._path), "PYTHONPATH": root}
        self.hub: dict[str, Any] = hub_with(body, f"{__name__}:KIND")

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

    def moves(self, row: Row) -> bool:
        """Whether the robot is not at rest, for a body of its kind."""
        return max(row.speed, abs(row.yaw)) >= self._still

    def first(self, since: float, holds: Callable[[Row], bool]) -> float | None:
        """When this first held after `since`, after that [s]; None: not yet."""
        return next((row.at - since for row in self.rows() if row.at >= since and holds(row)), None)

    def away(self, since: float, until: float) -> float:
        """For how long in this time whoever moves the robot did not [s]: the machine was busy."""
        times = [row.at for row in self.rows() if since <= row.at <= until]
        pauses = (later - earlier - _PERIOD_S for earlier, later in pairwise([since, *times]))
        return sum(pause for pause in pauses if pause > _PERIOD_S)

    def forget(self) -> None:
        """All rows but the last."""
        self._rows = self.rows()[-1:]

    def close(self) -> None:
        self._file.close()
