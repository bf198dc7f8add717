"""The failsafes of a simulated rover, Sub and blimp, as ArduPilot 4.7 has them; pure.

| vehicle | event | action |
| --- | --- | --- |
| rover | no stick frame for 0.5 s, FS_THR_ENABLE | the sticks count as neutral; does not arm |
| rover | that, or no station for FS_GCS_TIMEOUT, for FS_TIMEOUT | FS_ACTION, not in HOLD or RTL |
| rover | it loses its place where its mode needs it, FS_EKF_ACTION | HOLD |
| Sub | no sticks for FS_PILOT_TIMEOUT, no receiver | neutral sticks; FS_PILOT_INPUT 2: disarm |
| Sub | no station for FS_GCS_TIMEOUT | FS_GCS_ENABLE 2: disarm, 3: depth hold, 4: surface |
| blimp | no stick frame for 0.5 s, or 1 s with a valid override, FS_THR_ENABLE | disarm |
| blimp | no station for FS_GCS_TIMEOUT, FS_GCS_ENABLE | disarm |

A station that was never heard is not missed. FS_THR_ENABLE 0 leaves a rover's state as it is.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping
from typing import Final

from hub.robots.simulated_autopilot.condition import CRITICAL, INFO, WARNING, VehicleCondition

_RADIO: Final = "Radio"
_STATION: Final = "GCS"
_RADIO_S: Final = 0.5
_OVERRIDE_S: Final = 1.0
_SUB_LATE_S: Final = 0.33
"""A Sub looks for its station three times a second [s]."""
_WARN_AGAIN_S: Final = 30.0
_SMART_RTL, _RTL = 12, 11
_DEPTH_HOLD, _SURFACE = 2, 9
_ROVER_ACTIONS: Final = {1: (_RTL,), 2: (), 3: (_SMART_RTL, _RTL), 4: (_SMART_RTL,)}


class Failsafes(abc.ABC):
    """Watches one vehicle."""

    def __init__(self, vehicle: VehicleCondition) -> None:
        self._vehicle = vehicle

    @abc.abstractmethod
    def step(self, *, fresh: bool) -> None:
        """Act where something is missing.

        Args:
            fresh: Whether the radio channels were read with this step.
        """

    def _station_silent(self) -> bool:
        vehicle = self._vehicle
        silent = vehicle.now - vehicle.station_heard
        return silent < math.inf and silent > vehicle.parameters["FS_GCS_TIMEOUT"]


class RoverFailsafes(Failsafes):
    """Those of a rover."""

    def __init__(self, vehicle: VehicleCondition) -> None:
        super().__init__(vehicle)
        self._missing: set[str] = set()
        self._acted_on: set[str] = set()
        self._since = -math.inf
        self._had_place = False

    def step(self, *, fresh: bool) -> None:  # noqa: ARG002 - the age of the last frame counts
        """Act where something is missing."""
        vehicle = self._vehicle
        if vehicle.parameters["FS_THR_ENABLE"]:
            self._set(_RADIO, missing=vehicle.now - vehicle.radio.heard > _RADIO_S)
        if vehicle.parameters["FS_GCS_ENABLE"]:
            self._set(_STATION, missing=self._station_silent())
        vehicle.radio_lost = _RADIO in self._missing
        vehicle.in_failsafe = bool(self._acted_on)
        self._watch_place()

    def _set(self, name: str, *, missing: bool) -> None:
        vehicle, before = self._vehicle, bool(self._missing)
        if missing:
            self._missing.add(name)
        else:
            self._missing.discard(name)
        if self._missing and not before:
            self._since = vehicle.now
        if self._acted_on and not self._missing:
            vehicle.say(INFO, f"{name} Failsafe Cleared")
        self._acted_on &= self._missing
        late = vehicle.now - self._since > vehicle.parameters["FS_TIMEOUT"]
        if (
            self._missing
            and not self._acted_on
            and late
            and vehicle.mode not in (_RTL, vehicle.kind.hold)
        ):
            self._acted_on = set(self._missing)
            vehicle.say(WARNING, f"{name} Failsafe")
            vehicle.radio.release()
            self._act()

    def _act(self) -> None:
        vehicle = self._vehicle
        action = int(vehicle.parameters["FS_ACTION"])
        if action not in _ROVER_ACTIONS or vehicle.kind.hold is None:
            return
        possible = (mode for mode in _ROVER_ACTIONS[action] if vehicle.has_place)
        vehicle.set_mode(next(possible, vehicle.kind.hold))

    def _watch_place(self) -> None:
        vehicle = self._vehicle
        lost = self._had_place and not vehicle.has_place
        self._had_place = vehicle.has_place
        needs = vehicle.mode in vehicle.kind.needs_place
        if lost and vehicle.armed and needs and vehicle.parameters["FS_EKF_ACTION"] == 1.0:
            vehicle.say(CRITICAL, "EKF failsafe")
            if vehicle.kind.hold is not None:
                vehicle.set_mode(vehicle.kind.hold)


class SubFailsafes(Failsafes):
    """Those of a Sub."""

    def __init__(self, vehicle: VehicleCondition) -> None:
        super().__init__(vehicle)
        self._no_pilot = self._no_station = False
        self._warned = self._check_at = -math.inf

    def step(self, *, fresh: bool) -> None:  # noqa: ARG002 - the age of the last frame counts
        """Act where something is missing."""
        self._watch_pilot()
        vehicle = self._vehicle
        if vehicle.now >= self._check_at:
            self._check_at = vehicle.now + _SUB_LATE_S
            self._watch_station()
        vehicle.in_failsafe = self._no_pilot or self._no_station

    def _watch_pilot(self) -> None:
        vehicle = self._vehicle
        action = vehicle.parameters["FS_PILOT_INPUT"]
        late = vehicle.now - vehicle.radio.heard >= vehicle.parameters["FS_PILOT_TIMEOUT"]
        if not action or not late:
            self._no_pilot = False
        elif not self._no_pilot:
            self._no_pilot = True
            vehicle.say(CRITICAL, "Lost manual control")
            vehicle.radio.center()
            if action == 2.0:
                vehicle.disarm()
        vehicle.radio_lost = self._no_pilot

    def _watch_station(self) -> None:
        vehicle = self._vehicle
        action = vehicle.parameters["FS_GCS_ENABLE"]
        if not action or vehicle.station_heard == -math.inf:
            return
        if not self._station_silent():
            if self._no_station:
                vehicle.say(WARNING, "GCS Failsafe Cleared")
            self._no_station = False
            return
        if vehicle.now - self._warned > _WARN_AGAIN_S:
            self._warned = vehicle.now
            station = int(vehicle.parameters["MAV_GCS_SYSID"])
            vehicle.say(WARNING, f"MYGCS: {station}, heartbeat lost")
        if self._no_station or not vehicle.armed:
            return
        self._no_station = True
        if action == 2.0:
            vehicle.disarm()
        elif action in (3.0, 4.0):
            vehicle.set_mode(_DEPTH_HOLD if action == 3.0 else _SURFACE)


class BlimpFailsafes(Failsafes):
    """Those of a blimp."""

    def __init__(self, vehicle: VehicleCondition) -> None:
        super().__init__(vehicle)
        self._no_station = False

    def step(self, *, fresh: bool) -> None:
        """Act where something is missing."""
        vehicle = self._vehicle
        if fresh or not vehicle.parameters["FS_THR_ENABLE"]:
            if vehicle.radio_lost and fresh:
                vehicle.say(WARNING, "Radio Failsafe Cleared")
                vehicle.radio_lost = False
        elif not vehicle.radio_lost and (vehicle.armed or vehicle.receiver):
            valid = vehicle.radio.overridden(vehicle.now, vehicle.parameters["RC_OVERRIDE_TIME"])
            if vehicle.now - vehicle.radio.heard >= (_OVERRIDE_S if valid else _RADIO_S):
                vehicle.radio_lost = True
                vehicle.say(WARNING, "Radio Failsafe - Disarming")
                vehicle.disarm()
        if vehicle.parameters["FS_GCS_ENABLE"]:
            silent = self._station_silent()
            if silent and not self._no_station:
                vehicle.disarm()
            self._no_station = silent
        vehicle.in_failsafe = vehicle.radio_lost or self._no_station


FAILSAFES: Final[Mapping[str, type[RoverFailsafes | SubFailsafes | BlimpFailsafes]]] = {
    "rover": RoverFailsafes,
    "sub": SubFailsafes,
    "blimp": BlimpFailsafes,
}
