"""Whose drive commands the driver obeys: those of the one module that may send them."""

from __future__ import annotations

import logging

from hub.gcm.navigation import DRIVE_COMMAND
from hub.ipc.security.publish_rights import COMMANDS

_logger = logging.getLogger(__name__)

TELL_S = 1.0
"""The log says no more often than this that a command is refused [s]."""


class Navigator:
    """Knows the number that central gave the module which may command the wheels.

    Attributes:
        name: The module's name.
        refused: How many commands came from others.
    """

    def __init__(self) -> None:
        self.name = COMMANDS[DRIVE_COMMAND.name].module
        self.refused = 0
        self._number = 0
        self._tell_at = 0.0

    def connected(self, number: int) -> None:
        """Central says the module's number; 0: it is not connected."""
        self._number = number

    def obeyed(self, publisher: int, now: float) -> bool:
        """Whether a command of this number counts at this time [s]; else it is logged."""
        if publisher == self._number != 0:
            return True
        self.refused += 1
        if now >= self._tell_at:
            self._tell_at = now + TELL_S
            _logger.warning(
                "a drive command of number %d is refused: only %s may send one (%d so far)",
                publisher,
                self.name,
                self.refused,
            )
        return False
