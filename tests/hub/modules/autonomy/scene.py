"""A pilot with a navigation and a mapping that do as the real ones, as far as the pilot can see."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hub.gcm.autonomy import AutonomyCommand, AutonomyState, Behaviour, DrivingMode
from hub.gcm.navigation import (
    Cause,
    GoalCommand,
    MotionState,
    NavigationStatus,
    Point,
    RobotState,
    Task,
)
from hub.grids.grid import Grid
from hub.modules.autonomy.autonomy_driver import AutonomyDriver

ASKED = [Behaviour.EXPLORE, Behaviour.GO, Behaviour.RETURN, Behaviour.WANDER]
STEP = 0.1
RADIUS = 0.25
NOTHING = np.full(16, np.inf, np.float32)


def hall(width: int = 60, height: int = 40, known: int = 30) -> Grid:
    """A hall of which the robot, at the origin, knows the part on the left."""
    cells = np.full((height, width), -1, np.int8)
    cells[:, :known] = 0
    cells[[0, -1], :known] = 100
    cells[:, 0] = 100
    return Grid(cells=cells, resolution=0.1, origin_x=-1.0, origin_y=-1.0)


class Scene:
    """Time, and everything the pilot sees and sends."""

    def __init__(self, seed: int = 1) -> None:
        self.now = 100.0
        self.pilot = AutonomyDriver(radius=RADIUS, seed=seed)
        self.x = self.y = 0.0
        self.theta = 1.0  # it has turned, so that exploring begins without a base line
        self.motion = MotionState.STANDING
        self.frame = 0
        self.number = 0
        self.task = Task.NONE
        self.mine = False
        self.driver = 0
        self.left, self.distance = 0, math.nan
        self.cause, self.said = Cause.NONE, "so it is"
        self.task_began = self.now
        self.goals: list[GoalCommand] = []
        self.grid: Grid | None = hall()
        self.navigation_lives = self.driver_reports = self.accepts = True
        self.hears()

    @property
    def state(self) -> AutonomyState:
        return self.pilot.state(self.now)

    @property
    def why(self) -> str:
        return self.state.why

    @property
    def targets(self) -> list[tuple[float, float]]:
        """Where navigation was sent."""
        return [(goal.points[-1].x, goal.points[-1].y) for goal in self.goals if goal.points]

    def ask(self, behaviour: Behaviour, *points: tuple[float, float]) -> None:
        """The operator wants something."""
        sent = tuple(Point(x=x, y=y) for x, y in points)
        command = AutonomyCommand(behaviour=behaviour, points=sent)
        self.pilot.command(command, self.now)
        self.act()

    def hears(self) -> None:
        """The pilot gets what the others publish."""
        if self.driver_reports:
            seen = robot(self.x, self.y, self.motion, self.theta)
            self.pilot.see_robot(dataclasses.replace(seen, frame=self.frame), self.now)
        if self.navigation_lives:
            self.tell()

    def tell(self) -> None:
        """Navigation says what it does."""
        status = NavigationStatus(
            number=self.number,
            task=self.task,
            sender=7,
            driver=self.driver,
            points_left=self.left,
            distance_left=self.distance,
            why=self.said,
            path=(),
            cause=self.cause,
            seconds=self.now - self.task_began,
        )
        self.pilot.see_navigation(status, self.now, mine=self.mine)

    def act(self) -> None:
        """The pilot decides, and navigation does as it is sent."""
        if self.pilot.wants_map(self.now) and self.grid is not None:
            self.pilot.see_map(self.grid, self.now)
        goal = self.pilot.act(self.now)
        if goal is None:
            return
        self.goals.append(goal)
        if not (self.navigation_lives and self.accepts):
            return
        if goal.points:
            self.number += 1
            self.task, self.mine, self.left = Task.GOING, True, len(goal.points)
            self.cause, self.task_began = Cause.NONE, self.now
            self.motion = MotionState.GOING
        elif self.task is Task.GOING:
            self.end(Task.CANCELLED, cause=Cause.WITHDRAWN)

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            self.hears()
            self.act()

    def end(
        self,
        task: Task,
        motion: MotionState = MotionState.STANDING,
        cause: Cause = Cause.NONE,
    ) -> None:
        """The task of navigation ends."""
        self.task, self.motion, self.cause = task, motion, cause
        self.hears()

    def arrive(self) -> None:
        """The robot is where it was sent."""
        self.x, self.y = self.targets[-1]
        self.end(Task.REACHED)
        self.act()


def robot(x: float, y: float, motion: MotionState, theta: float = 0.0) -> RobotState:
    return RobotState(
        stamp=0.0,
        x=x,
        y=y,
        theta=theta,
        linear=0.0,
        angular=0.0,
        commanded_linear=0.0,
        commanded_angular=0.0,
        bumpers=0,
        battery_voltage=24.0,
        battery_fraction=1.0,
        motion=motion,
        refused=0,
    )


def busy(behaviour: Behaviour = Behaviour.GO) -> Scene:
    """A robot on its way by itself."""
    scene = Scene()
    scene.x = 0.5
    scene.hears()
    scene.ask(behaviour, *([(1.5, 0.5)] if behaviour is Behaviour.GO else []))
    scene.wait(3.0)
    assert scene.task is Task.GOING
    assert scene.state.behaviour is behaviour
    assert scene.state.pilot is DrivingMode.AUTONOMY
    return scene


def stands_for_good(scene: Scene) -> bool:
    """Whether the robot is left alone from now on."""
    before = len(scene.targets)
    scene.wait(30.0)
    return (
        len(scene.targets) == before
        and scene.state.behaviour is Behaviour.HOLD
        and scene.task is not Task.GOING
    )
