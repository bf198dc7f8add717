"""Turns the camera of a vehicle up and down at a rate; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.vehicle.sender import VehicleSender

_TURN_CAMERA: Final = 1000
"""MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW."""
_EVERY_S: Final = 0.09
_STEP_S: Final = 0.2
"""Longest step of time that turns the camera [s]."""


class CameraTilt:
    """The camera of one vehicle.

    Attributes:
        wanted: The angle that was asked for last [rad], positive up; NaN: none was.
    """

    def __init__(self, sender: VehicleSender) -> None:
        self._sender = sender
        self.wanted = math.nan
        self._rate = 0.0
        self._limits = (-math.pi / 2, math.pi / 2)
        self._at = self._sent_at = -math.inf

    def turn(self, rate: float, lowest: float, highest: float, now: float) -> None:
        """Turn at a rate [rad/s], positive up, between two angles [rad]; 0 stops it."""
        self._rate = rate if math.isfinite(rate) else 0.0
        self._limits, self._at = (lowest, highest), now

    def step(self, present: float, now: float, *, allowed: bool) -> None:
        """Let time pass.

        Args:
            present: The camera's angle [rad]; NaN: not known, it counts from the middle.
            now: Monotonic time [s].
            allowed: Whether the vehicle is this operator's; else the camera is not turned.
        """
        seconds, self._at = min(_STEP_S, now - self._at), now
        if not self._rate or not allowed:
            return
        if math.isnan(self.wanted):
            self.wanted = present if math.isfinite(present) else 0.0
        lowest, highest = self._limits
        self.wanted = max(lowest, min(highest, self.wanted + self._rate * seconds))
        if now - self._sent_at >= _EVERY_S:
            self._sent_at = now
            self._sender.message(
                "COMMAND_LONG",
                command=_TURN_CAMERA,
                param1=math.degrees(self.wanted),
                param3=math.nan,
                param4=math.nan,
            )
