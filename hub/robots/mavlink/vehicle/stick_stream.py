"""The stream of velocities to one vehicle; pure."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.profiles.profile import Parameters, Setpoint, VehicleProfile
from hub.robots.mavlink.vehicle.button_lights import ButtonLights
from hub.robots.mavlink.vehicle.sender import VehicleSender
from hub.robots.mavlink.vehicle.telemetry import Telemetry

_MOVING_S: Final = 0.045
_NEUTRAL_S: Final = 0.095
"""Least time between two velocities while moving, and else [s]: at steps of 50 ms, 20 and 10 Hz."""
_LOSSY_S: Final = 0.035
"""The same on a link that loses some [s]: no late step of the driver leaves one out."""


class StickStream:
    """Sends velocities as a vehicle of its kind understands them.

    Attributes:
        lights: Its lights, whose buttons are in the same messages.
    """

    def __init__(self, sender: VehicleSender) -> None:
        self._sender = sender
        self.lights = ButtonLights()
        self._sent_at = -math.inf

    def due(self, velocity: Setpoint, now: float, *, lossy: bool) -> bool:
        """Whether it is time to send the velocity again [s, monotonic].

        On a link that loses some, a neutral one is sent as often as the others: a vehicle without a
        receiver takes 0.5 s without sticks for a lost radio.
        """
        usual = _NEUTRAL_S if velocity.neutral else _MOVING_S
        return now - self._sent_at >= (_LOSSY_S if lossy else usual)

    def send(
        self,
        profile: VehicleProfile,
        mode: int,
        velocity: Setpoint,
        parameters: Parameters,
        read: Telemetry,
        now: float,
    ) -> None:
        """Send a velocity.

        Args:
            profile: The vehicle's kind.
            mode: Its mode.
            velocity: The velocity.
            parameters: The vehicle's parameters.
            read: What it measures.
            now: Monotonic time [s].
        """
        self._sent_at = now
        buttons = self.lights.buttons(parameters, read.brightness, now)
        for name, fields in profile.velocity(mode, velocity, parameters, read.gain):
            pressed = {"buttons": buttons} if buttons and name == "MANUAL_CONTROL" else {}
            self._sender.message(name, **fields, **pressed)
