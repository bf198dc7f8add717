"""A speed governor on a clock of its own."""

from __future__ import annotations

from hub.gcm.body import Freedom, Motion
from hub.gcm.geometry import Twist
from hub.gcm.navigation import MotionState
from hub.modules.navigation.speed_governor import (
    SpeedGovernor,
)

MOTIONS = (
    Motion(freedom=Freedom.SURGE, limit=0.5, acceleration=2.0),
    Motion(freedom=Freedom.YAW, limit=1.0, acceleration=4.0),
)
STEP = 0.01
A, B = 1, 2


class Scene:
    """A governor whose process looks every 10 ms, and whose driver reports."""

    def __init__(self) -> None:
        self.now = 0.0
        self.driver_lives = True
        self.governor = SpeedGovernor(MOTIONS, 0.0)
        self.governor.driver_reported(0.0)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            if self.driver_lives:
                self.governor.driver_reported(self.now)
            self.governor.velocity(self.now)

    def command(self, sender: int, linear: float, angular: float = 0.0, age: float = 0.0) -> None:
        """A command arrives."""
        twist = Twist.planar(linear, angular)
        self.governor.command(sender, twist, self.now - age, self.now)

    def hold(self, sender: int, linear: float, seconds: float) -> None:
        """Commands keep coming."""
        for _ in range(round(seconds / 0.05)):
            self.command(sender, linear)
            self.wait(0.05)

    @property
    def velocity(self) -> tuple[float, float]:
        twist = self.governor.velocity(self.now)
        return twist.linear.x, twist.angular.z

    @property
    def state(self) -> MotionState:
        return self.governor.state(self.now)


def driving(sender: int = A) -> Scene:
    scene = Scene()
    scene.command(sender, 0.0)
    scene.command(sender, 0.4, -0.5)
    return scene


def under_way() -> Scene:
    """A task has the wheels."""
    scene = Scene()
    assert scene.governor.begin_task(scene.now) == ""
    scene.governor.steer(0.3, 0.2, scene.now)
    return scene
