"""The claim of one hub on a robot with ROS: two would both send it velocities."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.machine_claim import MachineClaim, local_place
from hub.robots.ros.address import RosAddress

_AGAIN_S: Final = 0.5
"""Time between two looks whether another process still has the robot [s]."""


class RobotClaim:
    """The claim on what follows the velocities on one topic.

    Attributes:
        rival: Which other process has the robot, in words; empty: none.
    """

    def __init__(self, address: RosAddress, cmd_vel: str, known_as: str = "") -> None:
        """Take the address and the topic of velocities; nothing is claimed yet.

        Args:
            address: Where the robot is.
            cmd_vel: Topic of its velocities.
            known_as: Names it in place of host and port, where these change; empty: they do not.
        """
        place = known_as or local_place(f"{address.host}:{address.port}")
        words = f"{address.kind.value} {place} {address.domain} {cmd_vel}"
        self._claim = MachineClaim("ros", words)
        self._asked = -math.inf
        self.rival = ""

    def held(self, now: float) -> bool:
        """Whether this process has the robot; takes it once it is free [s, monotonic]."""
        if now - self._asked >= _AGAIN_S:
            self._asked = now
            self.rival = "" if self._claim.take() else self.rival or self._claim.owner()
        return not self.rival

    def close(self) -> None:
        """Let others have it."""
        self._claim.close()
