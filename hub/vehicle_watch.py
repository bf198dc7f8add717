"""Watches whether the vehicle follows velocities; where it stops to, tasks end.

| the driver reports | why it does not follow |
| --- | --- |
| an autopilot that follows velocities | empty |
| an autopilot that does not: another mode, disarmed, silent, waits for neutral | its reason |
| no autopilot, and motors that are disarmed | they are disarmed |
| no autopilot otherwise | empty |
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotState
from hub.gcm.vehicle import VEHICLE_STATE, Arming, VehicleState
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo

_DISARMED: Final = "its motors are off: arm it"


class VehicleWatch:
    """What the driver reports of one vehicle.

    Attributes:
        why: Why it does not follow velocities, for people; empty: it does, or nothing is known.
    """

    def __init__(self, client: Client, lost: Callable[[str], None]) -> None:
        """Follow the driver's reports.

        Args:
            client: The connection of a module.
            lost: Called with the reason when the vehicle stops to follow.
        """
        self.why = ""
        self._lost = lost
        self._autopilot: str | None = None
        self._motors = ""
        client.subscribe(VEHICLE_STATE, self._vehicle)
        client.subscribe(AUTOPILOT_STATE, self._piloted)

    def _vehicle(self, state: VehicleState, _reception: MessageInfo) -> None:
        self._motors = _DISARMED if state.arming is Arming.DISARMED else ""
        self._judge()

    def _piloted(self, state: AutopilotState, _reception: MessageInfo) -> None:
        self._autopilot = state.why
        self._judge()

    def _judge(self) -> None:
        followed = not self.why
        self.why = self._motors if self._autopilot is None else self._autopilot
        if followed and self.why:
            self._lost(self.why)
