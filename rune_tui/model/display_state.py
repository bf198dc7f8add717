"""The state of the terminal's picture."""

from __future__ import annotations

from hub.ipc.definition import MessageDefinition
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayState:
    """The state of the connection to the terminal.

    Attributes:
        latency: Time from writing a frame to the terminal's report that it is shown [s]; NaN:
            not reported.
        frames_per_s: Frames written in the last second [1/s].
        bytes_per_s: Bytes of these frames [bytes/s].
        coarseness: 0 for exact pictures; a larger number is coarser.
    """

    latency: float
    frames_per_s: float
    bytes_per_s: float
    coarseness: int


RUNE_DISPLAY = MessageDefinition(
    name="RuneDisplay",
    type=DisplayState,
    rate_hz=1.0,
)
"""A local message: it is recorded, and goes over no bus."""
