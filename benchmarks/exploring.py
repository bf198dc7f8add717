"""An exploration without processes and without waiting: the modules' own parts, called in turn.

The same seed gives the same exploration; it runs some twenty times as fast as a robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from hub.gcm.autonomy import AutonomyCommand, Behaviour
from hub.gcm.battery import BatteryState
from hub.gcm.beam_scans import ScanReader
from hub.gcm.beams import beams_of
from hub.gcm.navigation import GoalCommand, MotionState
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.ranges import RangeReadings
from hub.grids.grid import Grid
from hub.modules.autonomy.autonomy_driver import AutonomyDriver as Autonomy
from hub.modules.mapping.grid import OccupancyGrid
from hub.modules.mapping.scans import ScanSelector
from hub.modules.navigation.dynamic_window import body_of
from hub.modules.navigation.path_follower import PathFollower as Navigator
from hub.modules.navigation.reports import robot_state, status
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.robots.robot_file import find_robot_file, read_description
from hub.sim.arena import load_arena
from tests.support.magellan import SimulatedMagellan

STEP = 0.05
"""Time between two commands to the wheels, and two reports [s]."""
LATE_S = 0.1
"""So late a map comes after it was asked for [s]."""
ROBOT = read_description(find_robot_file("magellan"))[0]
BODY = body_of(ROBOT)
BEAMS = beams_of(ROBOT.body)
_OURS = 1
_STEPS_PER_ACT, _STEPS_PER_MAP = 2, 30


class Exploration:
    """A simulated robot that explores an arena.

    Attributes:
        robot: The hardware.
        now: Simulated time [s].
    """

    def __init__(self, seed: int, arena: str = "yellow") -> None:
        """Stand at the start.

        Args:
            seed: Of everything that is drawn by lot.
            arena: Its name.
        """
        self.robot = SimulatedMagellan(load_arena(arena), seed=seed)
        self.now = 0.0
        self.navigator = Navigator(BODY, ROBOT.body)
        self.autonomy = Autonomy(radius=BODY.radius + BODY.margin, seed=seed)
        self.occupancy = OccupancyGrid(ROBOT.map_resolution, ROBOT.map_size, BEAMS)
        self._governor = SpeedGovernor(ROBOT.body.motions, 0.0)
        self._scans = ScanSelector(BEAMS)
        self._reader = ScanReader(ROBOT.body)
        self._mail: list[tuple[float, Callable[[], None]]] = []
        self._steps = 0

    def explore(self, longest: float, watch: Callable[[], object] = lambda: None) -> float:
        """Explore until autonomy has done, or the time is over; how long it took [s].

        Args:
            longest: This time [s].
            watch: Called after each step.
        """
        began = self.now
        self._step()
        self.autonomy.command(AutonomyCommand(behaviour=Behaviour.EXPLORE), self.now)
        while self.autonomy.state(self.now).behaviour is Behaviour.EXPLORE:
            self._step()
            watch()
            if self.now - began > longest:
                break
        return self.now - began

    def grid(self) -> Grid:
        """The map as others get it."""
        return _as_grid(self.occupancy.whole())

    def _step(self) -> None:
        """Let everything happen that happens within a period of the wheels' commands."""
        self.robot.advance(STEP)
        self.now += STEP
        self._steps += 1
        drive = self.robot.drive_state(self.now)
        self._governor.driver_reported(self.now)
        self.navigator.reported(drive, self.now, self.now)
        scans = self.robot.ranges(self.now)
        readings = None if scans is None else RangeReadings(scans=scans)
        if readings is not None:
            self.navigator.scanned(readings, self.now, self.now)
        state = robot_state(drive, BatteryState(), self.navigator, self._governor, 0, 1, self.now)
        self._reader.moved(state, self.now)
        scan = readings and self._reader.read(readings, self.now)
        evidence = scan and self._scans.evidence(scan)
        if scan is not None and evidence is not None:
            self.occupancy.add(scan.pose, evidence)
        self.autonomy.see_robot(state, self.now)
        for due, deliver in self._mail[:]:
            if due <= self.now:
                self._mail.remove((due, deliver))
                deliver()
        if self._steps % _STEPS_PER_MAP == 0:
            self._map_navigation()
        self._drive()
        if self._steps % _STEPS_PER_ACT == 0:
            self._act()

    def _drive(self) -> None:
        if self._governor.state(self.now) is MotionState.GOING:
            steered = self.navigator.steered(self.now)
            if steered is None:
                self._governor.end_task()
            else:
                self._governor.steer(*steered, self.now)
        self.robot.command(self._governor.velocity(self.now))

    def _act(self) -> None:
        said = status(self.navigator.task, self._governor.driver, self.now)
        self.autonomy.see_navigation(said, self.now, mine=said.sender == _OURS)
        if self.autonomy.wants_map(self.now):
            self._later(lambda: self.autonomy.see_map(self.grid(), self.now))
        goal = self.autonomy.act(self.now)
        if goal is not None:
            self._go(goal)

    def _go(self, goal: GoalCommand) -> None:
        if not goal.points:
            self.navigator.task.go(goal, _OURS, self.now)
            self._governor.end_task()
        elif not self._governor.begin_task(self.now):
            self.navigator.go(goal, _OURS, self.now)
            self._map_navigation()

    def _map_navigation(self) -> None:
        window = self.navigator.window
        if window is None:
            return
        if math.isnan(window.x):
            picture = self.occupancy.whole()
        else:
            part = self.occupancy.window(window.x, window.y, window.width, window.height)
            picture = part or self.occupancy.whole()
        grid = _as_grid(picture)
        self._later(lambda: self.navigator.mapped(grid, self.now))

    def _later(self, deliver: Callable[[], None]) -> None:
        self._mail.append((self.now + LATE_S, deliver))


def _as_grid(picture: OccupancyMap) -> Grid:
    return Grid(
        cells=picture.cells,
        resolution=picture.resolution,
        origin_x=picture.origin_x,
        origin_y=picture.origin_y,
    )
