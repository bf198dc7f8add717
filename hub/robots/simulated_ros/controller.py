"""Takes velocities as diff_drive_controller of ros2_controllers does; pure.

A command counts from the time in its header. With a time that lies ahead it lasts longer, and with
an old one it counts for nothing. The time 0 stands for that of its arrival.
"""

from __future__ import annotations

from typing import Final

from hub.gcm.geometry import Twist

TIMEOUT: Final = 0.5
"""The parameter `cmd_vel_timeout` of the controller, unless it is set [s]."""


class DiffDriveController:
    """The velocity that wheels follow.

    Attributes:
        timeout: For how long a command counts [s]; 0: until the next one.
        halted: Whether it follows nothing until a neutral command comes.
    """

    def __init__(self, timeout: float = TIMEOUT) -> None:
        self.timeout = timeout
        self.halted = False
        self._twist, self._stamp = Twist(), 0.0

    def halt(self) -> None:
        """Stop, and wait for a neutral command."""
        self.halted = True
        self._twist = Twist()

    def take(self, twist: Twist, stamp: float, now: float) -> bool:
        """Take a command.

        Args:
            twist: The velocity.
            stamp: The time in its header, by the robot's clock [s]; 0: now.
            now: The time by the robot's clock [s].

        Returns:
            Whether the robot follows it.
        """
        stamp = stamp or now
        if self.timeout and now - stamp >= self.timeout:
            return False
        self.halted = self.halted and not twist.neutral
        if self.halted:
            return False
        self._twist, self._stamp = twist, stamp
        return True

    def velocity(self, now: float) -> Twist:
        """The velocity at a time of the robot's clock [s]."""
        if self.timeout and now - self._stamp > self.timeout:
            return Twist()
        return self._twist
