"""Names of kinds of vehicles, of their autopilots and versions; pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

KINDS: Final[Mapping[int, str]] = {
    1: "fixed wing",
    2: "quadrotor",
    3: "coaxial helicopter",
    4: "helicopter",
    5: "antenna tracker",
    6: "ground station",
    7: "blimp",
    10: "rover",
    11: "boat",
    12: "sub",
    13: "hexarotor",
    14: "octorotor",
    18: "companion computer",
    26: "gimbal",
    27: "traffic receiver",
    30: "camera",
}
"""By MAV_TYPE."""
_AUTOPILOT: Final = 1
"""The component that is the autopilot."""
_NO_AUTOPILOT: Final = 8
"""MAV_AUTOPILOT_INVALID."""
_NO_VEHICLES: Final = frozenset({5, 6, 18, 26, 27, *range(30, 35), *range(36, 43), 44})
"""MAV_TYPE of stations, companion computers, gimbals, cameras and other parts of vehicles."""
AUTOPILOTS: Final[Mapping[int, str]] = {3: "ArduPilot", 12: "PX4"}
"""By MAV_AUTOPILOT."""


def kind_name(number: int) -> str:
    """The name of a MAV_TYPE."""
    return KINDS.get(number, f"type {number}")


def is_vehicle(component: int, autopilot: int, kind: int) -> bool:
    """Whether a heartbeat is that of a vehicle's autopilot.

    Args:
        component: Number of the sender.
        autopilot: Its MAV_AUTOPILOT.
        kind: Its MAV_TYPE.
    """
    return component == _AUTOPILOT and autopilot != _NO_AUTOPILOT and kind not in _NO_VEHICLES


def firmware_name(autopilot: str, version: int) -> str:
    """An autopilot with its version, such as "ArduPilot 4.7.0".

    Args:
        autopilot: Its name; empty: not known.
        version: A byte each: major, minor, patch, kind; 0: not known.
    """
    if not autopilot or not version:
        return autopilot
    return f"{autopilot} {version >> 24 & 0xFF}.{version >> 16 & 0xFF}.{version >> 8 & 0xFF}"
