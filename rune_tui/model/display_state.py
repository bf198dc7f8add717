"""How the picture reaches the operator's eyes."""

from __future__ import annotations

from dataclasses import dataclass

from hub.ipc.definition import MessageDefinition


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayState:
    """What the console knows of the way to its terminal.

    Attributes:
        latency: From handing a frame over to the terminal's word that it is shown [s]; NaN where
            it does not say.
        frames_per_s: Frames that were handed over in the last second [1/s].
        bytes_per_s: What they took [bytes/s].
        coarseness: 0 where pictures are exact, more the coarser they are.
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
