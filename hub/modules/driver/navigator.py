"""Which drive commands the driver obeys: those of the one module that may send them.

| connection of the module | number of the publisher | action |
| --- | --- | --- |
| connected | its number | obey |
| connected | another number | refuse, count, log at most once per second |
| not connected | any | refuse, count, log at most once per second |
"""

from __future__ import annotations

import logging

from hub.gcm.navigation import DRIVE_COMMAND
from hub.ipc.security.publish_rights import COMMANDS

_logger = logging.getLogger(__name__)

LOG_INTERVAL_S = 1.0
"""Least time between two log lines about refused commands [s]."""


class Navigator:
    """Keeps the number that central gave to the module that may command the wheels.

    Attributes:
        name: The module's name.
        refused: Number of commands that came from others.
    """

    def __init__(self) -> None:
        self.name = COMMANDS[DRIVE_COMMAND.name].module
        self.refused = 0
        self._number = 0
        self._log_at = 0.0

    def connected(self, number: int) -> None:
        """Central reports the module's number; 0: it is not connected."""
        self._number = number

    def obeys(self, publisher: int, now: float) -> bool:
        """Whether the driver obeys a command of this publisher at `now` [s]; it logs refusals."""
        if publisher == self._number != 0:
            return True
        self.refused += 1
        if now >= self._log_at:
            self._log_at = now + LOG_INTERVAL_S
            _logger.warning(
                "a drive command of number %d is refused: only %s may send one (%d so far)",
                publisher,
                self.name,
                self.refused,
            )
        return False
