"""The action of a robot that has lost its operator; pure.

| state | event | next state |
| --- | --- | --- |
| OPERATED | control ends: the robot has no owner any more | LOST |
| LOST | a motion command, also of a task; a stop | LOST, and its time starts again |
| LOST | a console takes control | OPERATED |

It starts as OPERATED: a robot without an operator yet has lost none. While LOST, the action
is that of the robot file; SURFACE begins after `surface_after_s`, with STAND before.
"""

from __future__ import annotations

import enum
import math

SURFACE_AFTER_S = 10.0
"""Default time that a robot stands before it surfaces [s]."""


class LeftAlone(enum.Enum):
    """The action of a robot without an operator, as robot files name it.

    Attributes:
        STAND: Stop the wheels or thrusters.
        HOLD_HEIGHT: A flying robot keeps its height.
        SURFACE: A diving robot stops for a while, then comes up.
    """

    STAND = "stand"
    HOLD_HEIGHT = "hold height"
    SURFACE = "surface"


class OperatorWatch:
    """Keeps the time since which a robot has no operator; methods get the monotonic time [s]."""

    def __init__(self, wanted: LeftAlone, surface_after_s: float = SURFACE_AFTER_S) -> None:
        self._action = wanted
        self._surface_after_s = surface_after_s
        self._owner = 0
        self._since = math.inf

    def controlled_by(self, owner: int, now: float) -> None:
        """Take the number of the owner of control; 0: none."""
        if owner:
            self._since = math.inf
        elif self._owner:
            self._since = now
        self._owner = owner

    def moved(self, now: float) -> None:
        """Take a motion command or a stop, which postpones the action."""
        if self._since < math.inf:
            self._since = now

    def action(self, now: float) -> LeftAlone | None:
        """The action now; None: the robot has an operator."""
        if self._since == math.inf:
            return None
        if self._action is LeftAlone.SURFACE and now - self._since < self._surface_after_s:
            return LeftAlone.STAND
        return self._action
