"""The robot's own want: the recorder runs while anything is recorded.

| state | the recorder is wanted |
| --- | --- |
| the robot file says `always` | yes |
| the disk has a recording that an order began, no report of the recorder yet | yes |
| the recorder reports a recording | yes |
| it reports none | no |
"""

from __future__ import annotations

import time
from collections.abc import Callable

from hub.gcm.capability import Capability
from hub.gcm.recording import RECORD_STATE, RecordState
from hub.gcm.supervision import LEASE_S
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.recording.live.places import RecordingFolder
from hub.robomon.wants import Wants
from hub.robots.description import RobotDescription

HOLDER = "recording"
_NUMBER = -1
"""The want's holder has no number at central."""
_RENEW_S = LEASE_S / 3.0


class RecordingWant:
    """Holds the want, for the life of the hub."""

    def __init__(
        self,
        client: Client,
        wants: Wants,
        robot: RobotDescription,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Read the disk, and subscribe to the recorder's reports.

        Args:
            client: The daemon's connection.
            wants: The wants of all holders.
            robot: The robot file.
            clock: Monotonic time [s].
        """
        self._wants, self._clock = wants, clock
        self._always = robot.recording.always
        self._running = RecordingFolder(robot.recording.folder, robot.name).running.exists()
        client.subscribe(RECORD_STATE, self._on_state)
        client.every(_RENEW_S, self.renew)
        self.renew()

    def renew(self) -> None:
        """Renew the want, or let it expire."""
        wanted = (Capability.REC_LOG,) if self._always or self._running else ()
        self._wants.renew(_NUMBER, HOLDER, wanted, self._clock())

    def _on_state(self, state: RecordState, _reception: MessageInfo) -> None:
        self._running = bool(state.recording or state.ring)
