"""Which parameters of a vehicle are unsafe, or not known to be safe; pure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

from hub.gcm.autopilot import UnsafeParameter
from hub.robots.mavlink.profiles.profile import (
    STATION_WANTED,
    Parameters,
    VehicleProfile,
    WantedParameter,
)


def wanted_parameters(profile: VehicleProfile, station: int) -> tuple[WantedParameter, ...]:
    """The parameters that make a vehicle safe with a ground station of this number."""
    return tuple(
        dataclasses.replace(each, allowed=(float(station),)) if each is STATION_WANTED else each
        for each in profile.wanted
    )


def unsafe_parameters(
    profile: VehicleProfile, values: Parameters, station: int
) -> Iterator[UnsafeParameter]:
    """Those that are unsafe, and those that were not read: their value is NaN.

    Args:
        profile: The vehicle's kind.
        values: What was read.
        station: Number of the ground station.
    """
    for each in wanted_parameters(profile, station):
        value = values.get(each.name, math.nan)
        if not each.safe(value):
            yield UnsafeParameter(name=each.name, value=value, wanted=each.allowed[0], why=each.why)
