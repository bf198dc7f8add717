"""Has the hardware do what it can when the robot has lost its operator."""

from __future__ import annotations

import logging

from hub.errors import RobotFileError
from hub.robots.description import RobotDescription
from hub.robots.interfaces import BaseLeftAlone, DriveBase
from hub.robots.left_alone import LeftAlone, OperatorWatch

_logger = logging.getLogger(__name__)


class OperatorLoss:
    """Commands a base that has lost its operator, if the base can do more than stand."""

    def __init__(self, base: DriveBase, robot: RobotDescription) -> None:
        """Prepare.

        Raises:
            RobotFileError: The robot file wants what the base cannot do.
        """
        wanted = robot.left_alone
        self.watch = OperatorWatch(wanted, robot.surface_after_s)
        self._base = base if isinstance(base, BaseLeftAlone) else None
        self._action: LeftAlone | None = None
        if self._base is None and wanted is not LeftAlone.STAND:
            problem = (
                f"[safety] left_alone is {wanted.value!r}, but the kind {robot.kind!r} can only "
                f"{LeftAlone.STAND.value}"
            )
            raise RobotFileError(str(robot.path), [problem])

    def look(self, now: float) -> None:
        """See whether there is something new to do."""
        action = self.watch.action(now)
        if action is not self._action:
            self._action = action
            if self._base is not None:
                does = "is operated again" if action is None else f"is left alone: {action.value}"
                _logger.warning("the robot %s", does)
                self._base.left_alone(action)
