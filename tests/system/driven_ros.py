"""A simulated robot with ROS, recorded as the other bodies of the stale-stick cases.

Commands are read where the robot receives them, and so is its motion: both outlive the hub.
"""

from __future__ import annotations

import itertools
import json
import math
import time
from pathlib import Path
from typing import Any, Final

from tests.support.bodies import STANDING
from tests.support.held_relay import HeldRelay
from tests.support.ros_robot import SimulatedRos
from tests.system.recorded_robot import Recording, Row

WITH_ROS: Final = "ros-"
"""What the names of bodies begin with that are behind a bridge."""
OPTIONS: Final[dict[str, tuple[str, ...]]] = {
    "ros-stamped": (),
    "ros-twist": ("--twist",),
    "ros-older": ("--ros1", "--clock", "86400"),
}
"""Options of the simulated robot; the last has ROS 1, and a clock that is a day ahead."""
_PERIOD_S: Final = 0.02
_ENDS_S: Final = 0.3
"""How long a command counts: a moving one is sent again after 50 ms [s]."""
_STEP_S: Final = 0.015
"""Of commands that come together, wheels follow the last [s]."""
_TABLES: Final = """
[ros]
address = "ws://127.0.0.1:{port}"
stop_service = "/e_stop"
[limits]
linear = 0.5
angular = 1.0
[body]
radius = 0.18
[[range]]
name = "lidar"
kind = "laser"
beams = 60
height = 0.18
nearest = 0.16
farthest = 12.0
topic = "/scan"
"""


def ros_tables(port: int) -> str:
    """The tables of a robot file for a robot at a TCP port of loopback."""
    return _TABLES.format(port=port)


class RecordedRos(Recording):
    """The commands that reach such a robot, and its motion.

    Attributes:
        robot: The simulated robot with its bridge.
        relay: Between it and the hub.
    """

    def __init__(self, folder: Path, body: str) -> None:
        self.robot = SimulatedRos(folder, *OPTIONS[body], "--arena", "empty")
        self.relay = HeldRelay(self.robot.port)
        self._still = STANDING
        self._file = self.robot.trace.open("rb")
        self._lines: list[dict[str, Any]] = []
        self.environment = {"PYTHONPATH": str(Path(__file__).parents[2])}
        self.hub = {"kind": "ros", "tables": ros_tables(self.relay.port)}

    def rows(self) -> list[Row]:
        """All since `forget`."""
        data = self._file.read()
        whole = data.rfind(b"\n") + 1
        self._file.seek(whole - len(data), 1)
        lines = map(json.loads, data[:whole].splitlines())
        self._lines += (line for line in lines if "service" not in line and "goal" not in line)
        speed = turn = 0.0
        moving_at = -math.inf
        rows = []
        for line, after in itertools.zip_longest(self._lines, self._lines[1:]):
            at, until = line["at"], after["at"] if after else time.monotonic()
            if "motion" in line:
                speed, turn = line["motion"]
            elif after is None or "twist" not in after or until - at > _STEP_S:
                moving_at = at if any(line["twist"]) else -math.inf
            wanted = float(at - moving_at < _ENDS_S)
            rows.append(Row(at, wanted, 0.0, 0.0, 0.0, speed, 0.0, 0.0, turn))
            if wanted and until - moving_at >= _ENDS_S:  # no message came in this time
                rows.append(Row(moving_at + _ENDS_S, *(0.0,) * 4, speed, 0.0, 0.0, turn))
        return rows or [Row(time.monotonic(), *(0.0,) * 8)]

    def away(self, since: float, until: float) -> float:
        """For how long the machine was too busy for the robot [s]."""
        times = [line["at"] for line in self._lines if since <= line["at"] <= until]
        pauses = [after - before for before, after in itertools.pairwise(times)]
        return sum(each - _PERIOD_S for each in pauses if each > 2.0 * _PERIOD_S)

    def forget(self) -> None:
        """All that is older than a second."""
        since = time.monotonic() - 1.0
        self._lines = [line for line in self._lines if line["at"] >= since]

    def close(self) -> None:
        self._file.close()
        self.relay.close()
        self.robot.close()
