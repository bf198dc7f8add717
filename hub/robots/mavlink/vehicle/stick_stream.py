"""The stream of velocities to one vehicle; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.profiles.profile import Parameters, Setpoint, VehicleProfile
from hub.robots.mavlink.vehicle.sender import VehicleSender

_MOVING_S: Final = 0.045
_NEUTRAL_S: Final = 0.095
"""Least time between two velocities while moving, and else [s]: at steps of 50 ms, 20 and 10 Hz."""


class StickStream:
    """Sends velocities as a vehicle of its kind understands them."""

    def __init__(self, sender: VehicleSender) -> None:
        self._sender = sender
        self._sent_at = -math.inf

    def due(self, velocity: Setpoint, now: float) -> bool:
        """Whether it is time to send the velocity again [s, monotonic]."""
        return now - self._sent_at >= (_NEUTRAL_S if velocity.neutral else _MOVING_S)

    def send(
        self,
        profile: VehicleProfile,
        mode: int,
        velocity: Setpoint,
        parameters: Parameters,
        gain: float,
        buttons: int,
        now: float,
    ) -> None:
        """Send a velocity.

        Args:
            profile: The vehicle's kind.
            mode: Its mode.
            velocity: The velocity.
            parameters: The vehicle's parameters.
            gain: Share of its sticks' effect; NaN: not known.
            buttons: Buttons that are pressed, a bit each.
            now: Monotonic time [s].
        """
        self._sent_at = now
        for name, fields in profile.velocity(mode, velocity, parameters, gain):
            pressed = {"buttons": buttons} if buttons and name == "MANUAL_CONTROL" else {}
            self._sender.message(name, **fields, **pressed)
