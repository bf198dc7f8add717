"""Commands to a simulation, for experiments; real robots have none."""

from __future__ import annotations

from hub.gcm.fields import Flag
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationPause:
    """Let the time of a simulation stand still, or run again.

    Motion, sensors and battery stand still with it; the robot stops, and obeys new commands
    only after the pause.

    Attributes:
        paused: 1: it stands still; 0: it runs.
    """

    paused: Flag = 0


SIMULATION_PAUSE = MessageDefinition(
    name="SIM_Pause",
    type=SimulationPause,
    keep=Keep.ALL,
    plane=Plane.COMMAND,
)

MESSAGES = (SIMULATION_PAUSE,)
