"""The profile of a vehicle by its autopilot and type."""

from __future__ import annotations

from typing import Final

from hub.robots.mavlink.profiles.ardublimp import BLIMP
from hub.robots.mavlink.profiles.arducopter import COPTER
from hub.robots.mavlink.profiles.ardurover import BOAT, ROVER
from hub.robots.mavlink.profiles.ardusub import SUB
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.profiles.px4 import PX4_BOAT, PX4_COPTER, PX4_ROVER

ARDUPILOT: Final = 3
"""MAV_AUTOPILOT_ARDUPILOTMEGA."""
PX4: Final = 12
"""MAV_AUTOPILOT_PX4."""
PROFILES: Final = (
    (ARDUPILOT, ROVER),
    (ARDUPILOT, BOAT),
    (ARDUPILOT, SUB),
    (ARDUPILOT, BLIMP),
    (ARDUPILOT, COPTER),
    (PX4, PX4_ROVER),
    (PX4, PX4_BOAT),
    (PX4, PX4_COPTER),
)


def profile_of(autopilot: int, kind: int) -> VehicleProfile | None:
    """The profile of a vehicle; None: it is not known, and only watched.

    Args:
        autopilot: Its MAV_AUTOPILOT.
        kind: Its MAV_TYPE.
    """
    for number, profile in PROFILES:
        if number == autopilot and kind in profile.types:
            return profile
    return None
