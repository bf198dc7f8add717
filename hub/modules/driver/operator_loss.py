"""Commands the hardware when the robot has lost its operator.

| base | event | action |
| --- | --- | --- |
| can only stand | any | none: the command watchdog stops the wheels |
| can do more | `OperatorWatch` finds the operator lost | begin the robot file's `left_alone` |
| can do more | `OperatorWatch` finds an operator again | end it |
"""

from __future__ import annotations

import logging

from hub.errors import RobotFileError
from hub.robots.description import RobotDescription
from hub.robots.interfaces import Body, BodyLeftAlone
from hub.robots.left_alone import LeftAlone, OperatorWatch

_logger = logging.getLogger(__name__)


class OperatorLoss:
    """Begins and ends the action of a base that has lost its operator."""

    def __init__(self, base: Body, robot: RobotDescription) -> None:
        """Check that the base can do what the robot file asks for.

        Raises:
            RobotFileError: The base cannot do it.
        """
        requested = robot.left_alone
        self.watch = OperatorWatch(requested, robot.surface_after_s)
        self._base = base if isinstance(base, BodyLeftAlone) else None
        self._action: LeftAlone | None = None
        if self._base is None and requested is not LeftAlone.STAND:
            problem = (
                f"[safety] left_alone is {requested.value!r}, but the kind {robot.kind!r} can only "
                f"{LeftAlone.STAND.value}"
            )
            raise RobotFileError(str(robot.path), [problem])

    def update(self, now: float) -> None:
        """Begin or end the action, if the watch says so at `now` [s]."""
        action = self.watch.action(now)
        if action is not self._action:
            self._action = action
            if self._base is not None:
                does = "is operated again" if action is None else f"is left alone: {action.value}"
                _logger.warning("the robot %s", does)
                self._base.left_alone(action)
