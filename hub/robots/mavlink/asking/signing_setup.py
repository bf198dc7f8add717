"""Gives a vehicle a signing key; pure. A vehicle does not answer this message."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.robots.mavlink.asking.findings import ARMED, AUTOPILOT
from hub.robots.mavlink.asking.session import OutgoingMessage, addressed
from hub.robots.mavlink.wire.frames import MavlinkFrame

_BETWEEN_S: Final = 0.2
_TIMES: Final = 3


class SigningSetup:
    """Sends a key three times; a `VehicleQuestion`.

    Attributes:
        armed: Whether the vehicle was armed, so that nothing more was sent.
    """

    def __init__(self, system: int, key: bytes, stamp: int) -> None:
        """Take a key.

        Args:
            system: Number of the vehicle.
            key: 32 bytes.
            stamp: The first stamp, in units of 10 us since 2015.
        """
        self._system, self._key, self._stamp = system, key, stamp
        self._left = _TIMES
        self._next = -math.inf
        self.armed = False
        self._ended = False

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._ended or self.armed

    def received(self, frame: MavlinkFrame, now: float) -> None:  # noqa: ARG002 - as all questions
        """Take a frame of the link."""
        if frame.name == "HEARTBEAT" and (frame.system, frame.component) == (
            self._system,
            AUTOPILOT,
        ):
            self.armed = self.armed or bool(frame["base_mode"] & ARMED)

    def due(self, now: float) -> Iterator[OutgoingMessage]:
        """The messages to send now."""
        if self.done or now < self._next:
            return
        if not self._left:
            self._ended = True
            return
        self._left -= 1
        self._next = now + _BETWEEN_S
        yield addressed(
            "SETUP_SIGNING",
            self._system,
            secret_key=self._key,
            initial_timestamp=self._stamp,
        )
