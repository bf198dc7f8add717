"""The robot's own want: what keeps the mission runs while a mission runs, whatever consoles do.

| what is known | mapping is wanted |
| --- | --- |
| the disk has a mission that was not ended, mapping has not told yet | yes |
| mapping tells that a mission runs | yes |
| mapping tells that none runs, but cannot read the disk | as before |
| mapping tells that none runs | no |
| somebody has control, and missions begin with that | yes |
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
    """Holds the want; it lives as long as the hub does."""

    def __init__(
        self,
        client: Client,
        wants: Wants,
        robot: RobotDescription,
        *,
        controlled: Callable[[], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Look at the disk, and listen to mapping.

        Args:
            client: The daemon's connection.
            wants: Who wants what.
            robot: What the robot file says.
            controlled: Tells whether somebody has control of the robot.
            clock: Monotonic time [s].
        """
        self._wants, self._controlled, self._clock = wants, controlled, clock
        self._with_control = robot.mission_begin is MissionBegin.WITH_CONTROL
        self._running = _on_disk(robot)
        client.subscribe(MISSION_STATE, self._told)
        client.every(_RENEW_S, self.renew)
        self.renew()

    def renew(self) -> None:
        """Want it for a while, or no longer."""
        wanted = self._running or (self._with_control and self._controlled())
        capabilities = _CAPABILITIES if wanted else ()
        self._wants.renew(_NUMBER, HOLDER, capabilities, self._clock())

    def _told(self, state: MissionState, _reception: MessageInfo) -> None:
        if state.running or not state.fault:
            self._running = bool(state.running)


def _on_disk(robot: RobotDescription) -> bool:
    """Whether a mission runs that was begun before this hub was started."""
    try:
        return bool(MissionFolder(for_missions(robot.mission_folder), robot.name).running())
    except MissionFileError as error:
        _logger.warning("%s", error)
        return True
