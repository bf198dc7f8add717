"""A layout of two robots, and what goes into a dispatch and comes out of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from hub.gcm.navigation import STOP, VELOCITY_COMMAND
from rune_tui.controls.events import ControlEvent
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    Effect,
    SendEffect,
)
from rune_tui.startup.opening import open_layout

DEMO = open_layout(Path(__file__).parents[2] / "layouts" / "demo.xml")
TWO_ROBOTS = """\
<rune>
  <robot name="robot">
    <capability name="NAV_MOVE"/><capability name="VIS_PTZ"/>
  </robot>
  <robot name="blimp" hub="tcp://127.0.0.1:1391">
    <capability name="NAV_MOVE"/><capability name="VIS_PTZ"/>
  </robot>
  <robot name="watched" hub="tcp://127.0.0.1:1401">
    <capability name="NAV_MOVE"/><capability name="VIS_PTZ"/>
  </robot>
  <view xsize="160" ysize="96">
    <widget handler="widgetQuit"><event key="q"/></widget>
    <viewport name="slow" robot="robot" xpos="0" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed">
        <option name="linear" value="0.5"/>
        <event key="w" control="translate"/>
        <event key="e" control="translate"/>
        <event key="e" control="rotate" value="-1"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
    </viewport>
    <viewport name="fast" robot="robot" xpos="0" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed">
        <option name="linear" value="1.5"/>
        <event key="r" control="translate"/>
      </widget>
    </viewport>
    <viewport name="blimp" robot="blimp" xpos="80" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/>
        <event key="i" control="translate"/>
      </widget>
    </viewport>
    <viewport name="watched" robot="watched" xpos="80" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetHomePTZ"><event key="h"/></widget>
    </viewport>
  </view>
</rune>
"""


def at(now: float) -> ConsoleState:
    return ConsoleState(now=now)


def down(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=True)


def up(key: str) -> ControlEvent:
    return ControlEvent(name=key, pressed=False)


def velocities(effects: Iterable[Effect], robot: str) -> list[tuple[float, float]]:
    return [
        (effect.value.twist.linear.x, effect.value.twist.angular.z)
        for effect in effects
        if isinstance(effect, SendEffect)
        and effect.definition is VELOCITY_COMMAND
        and effect.robot == robot
    ]


def stops(effects: Iterable[Effect]) -> list[str]:
    return [
        effect.robot
        for effect in effects
        if isinstance(effect, SendEffect) and effect.definition is STOP
    ]
