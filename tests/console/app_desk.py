"""A console under Textual's pilot, and the robot that it is linked to."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Coroutine, Hashable
from typing import Any, ClassVar, Self

from textual.events import MouseScrollUp
from textual.pilot import Pilot

from hub.gcm.geometry import Twist
from hub.gcm.mapping import (
    INTEREST_POINTS,
    POINT_COMMAND,
    InterestPoints,
    PointAction,
    PointCommand,
)
from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop
from hub.ipc.client import Client
from hub.missions.points import PointBook
from rune_tui.app import Console
from rune_tui.controls.release_guard import FIRST_QUIET_S
from rune_tui.layout.rules import VisualizerRule
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from rune_tui.ui.driver_reports import ReleasesReported

LAYOUT = """<rune>
  <robot name="magellan" hub="{hub}">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <view>
    <arrangement name="usual" xsize="60" ysize="40">
      <place viewport="floor" xpos="0" ypos="0" xsize="60" ysize="40"/>
    </arrangement>
    <arrangement name="wide" min-columns="90" xsize="120" ysize="40">
      <place viewport="floor" xpos="60" ypos="0" xsize="60" ysize="40"/>
    </arrangement>
    <widget handler="widgetQuit"><event key="q"/></widget>
    <widget handler="widgetRecord"><event key="r"/></widget>
    <viewport name="floor">
      <visualizer function="visualizeFloor"/>
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/><event mouse="middle" control="translate"/>
      </widget>
      <widget handler="widgetShowViewport"><event key="v"/></widget>
      <widget handler="widgetFullScreen"><event key="f"/></widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetSetVictim"><event mouse="left"/></widget>
      <widget handler="widgetUndoMark"><event key="u"/></widget>
      <widget handler="widgetEditMark"><event mouse="right"/></widget>
    </viewport>
  </view>
</rune>
"""
TIMEOUT = 20.0
TRAITS = traits_of(Answers(truecolour=True), {}, (60, 20))


class Floor:
    """Shows ten by ten metres from above; the upper half is wall."""

    rule: ClassVar = VisualizerRule(meaning="a floor", locates=True)
    whole_cells: ClassVar[bool] = False

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        del spec
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        del robot
        canvas.fill(state.theme.panel)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        return robot.name, state.theme.name

    def locate(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> WorldPoint | None:
        del robot, state
        x, y = 10.0 * pixel[0] / size[0], 10.0 * pixel[1] / size[1]
        return WorldPoint(x=x, y=-y, uncertainty=0.1) if y > 5.0 else None


class Robot:
    """The robot's side: a map that takes marks as the mapping module does."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.book = PointBook()
        self.speeds: list[float] = []
        self.stops: list[str] = []
        client.subscribe(POINT_COMMAND, lambda command, _: self._mark(command))
        client.subscribe(VELOCITY_COMMAND, lambda command, _: self._drive(command.twist))
        client.subscribe(STOP, lambda stop, _: self._stop(stop))
        client.wait_connected(5.0)

    def _mark(self, command: PointCommand) -> None:
        if command.action is PointAction.REMOVE:
            self.book.drop(command.point.number)
        else:
            self.book.mark(command.point, "somebody", 1.0)
        kept = tuple(dataclasses.replace(point, kept=1) for point in self.book.points)
        self.client.publish(INTEREST_POINTS, InterestPoints(points=kept))

    def _drive(self, twist: Twist) -> None:
        self.speeds.append(twist.linear.x)

    def _stop(self, stop: Stop) -> None:
        self.stops.append(stop.reason)


class Desk:
    """A console under Textual's pilot, and the robot that it is linked to."""

    def __init__(self, console: Console, link: RobotLink, robot: Robot, pilot: Pilot[Any]) -> None:
        self.console, self.link, self.robot, self.pilot = console, link, robot, pilot

    async def until(self, condition: Callable[[], object]) -> None:
        end = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < end, self.notices
            self.robot.client.listen(0.0)
            await self.pilot.pause(0.02)

    @property
    def notices(self) -> list[str]:
        return [notice.text for notice in self.console.state.notices]

    async def press(self, *keys: str) -> None:
        for key in keys:
            await self.pilot.press(key)
            self.robot.client.listen(0.0)  # a robot never sleeps for as long as a hand types

    async def drive(self) -> None:
        """Press the key for forward until the robot gets a command to drive.

        Pressed too soon after all was let go it counts as still down until no key came for a while,
        and a machine that is too busy loses it.
        """
        end = time.monotonic() + TIMEOUT
        while not self.robot.speeds or self.robot.speeds[-1] <= 0.0:
            assert time.monotonic() < end, self.notices
            await self.press("w")
            again = time.monotonic() + FIRST_QUIET_S + 0.4
            while self.robot.speeds[-1:] <= [0.0] and time.monotonic() < again:
                self.robot.client.listen(0.0)
                await self.pilot.pause(0.02)

    async def report_releases(self, *, reported: bool = True) -> None:
        """Let the terminal say whether it reports releases of keys."""
        self.console.post_message(ReleasesReported(reported=reported))
        await self.until(lambda: self.console.state.releases_reported is reported)

    async def commands(self, count: int) -> list[float]:
        """The next so many speeds that are commanded."""
        before = len(self.robot.speeds)
        await self.until(lambda: len(self.robot.speeds) >= before + count)
        return self.robot.speeds[before:]


def scrolled_up() -> MouseScrollUp:
    """The wheel turned away from the operator in the middle of the screen."""
    return MouseScrollUp(
        None, 30, 10, 0, 0, 0, shift=False, meta=False, ctrl=False, screen_x=30, screen_y=10
    )


Script = Callable[[Desk], Coroutine[Any, Any, None]]
