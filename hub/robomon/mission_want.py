"""The robot's own want: mapping, which keeps the mission, runs while a mission runs.

| state | mapping is wanted |
| --- | --- |
| the disk has a mission without an end, no report of mapping yet | yes |
| mapping reports a running mission | yes |
| mapping reports none, but cannot read the disk | as before |
| mapping reports none | no |
| a console has control, and missions start with control | yes |
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from hub.errors import MissionFileError
from hub.gcm.capability import Capability
from hub.gcm.mission import MISSION_STATE, MissionState
from hub.gcm.supervision import LEASE_S
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.missions.folder import MissionFolder
from hub.paths import for_missions
from hub.robomon.wants import Wants
from hub.robots.description import MissionBegin, RobotDescription

_logger = logging.getLogger(__name__)

HOLDER = "mission"
_NUMBER = 0
"""The want's holder has no number at central."""
_CAPABILITIES = (Capability.PRO_MAP, Capability.PRO_POINTS)
_RENEW_S = LEASE_S / 3.0


class MissionWant:
    """Holds the want, for the life of the hub."""

    def __init__(
        self,
        client: Client,
        wants: Wants,
        robot: RobotDescription,
        *,
        controlled: Callable[[], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Read the disk, and subscribe to mapping's reports.

        Args:
            client: The daemon's connection.
            wants: The wants of all holders.
            robot: The robot file.
            controlled: Whether a console has control of the robot.
            clock: Monotonic time [s].
        """
        self._wants, self._controlled, self._clock = wants, controlled, clock
        self._with_control = robot.mission_begin is MissionBegin.WITH_CONTROL
        self._running = _on_disk(robot)
        client.subscribe(MISSION_STATE, self._on_state)
        client.every(_RENEW_S, self.renew)
        self.renew()

    def renew(self) -> None:
        """Renew the want, or let it expire."""
        wanted = self._running or (self._with_control and self._controlled())
        capabilities = _CAPABILITIES if wanted else ()
        self._wants.renew(_NUMBER, HOLDER, capabilities, self._clock())

    def _on_state(self, state: MissionState, _reception: MessageInfo) -> None:
        if state.running or not state.fault:
            self._running = bool(state.running)


def _on_disk(robot: RobotDescription) -> bool:
    """Whether a mission runs from before the start of this hub."""
    try:
        return bool(MissionFolder(for_missions(robot.mission_folder), robot.name).running())
    except MissionFileError as error:
        _logger.warning("%s", error)
        return True
