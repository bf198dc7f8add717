"""A virtual gamepad at the simulated robot: what the layout binds, what the pad sends, driving."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from tests.support.fake_hid import VirtualBed, VirtualDevice
from tests.support.waiting import Limit
from tests.system.harness import ConsoleProcess, HubProcess, Observer

PAD = "logitech_f310_dinput"
NAME = "Logitech Gamepad F310"
LAYOUT = """<rune run="1">
  <robot name="magellan" hub="{hub}">
    <capability name="NAV_STATE"/>
    <capability name="NAV_MOVE"/>
  </robot>
  <joystick name="pad"/>
  <view xsize="100" ysize="60">
    <widget handler="widgetQuit"><event key="q"/></widget>
    <widget handler="widgetHelp"><event key="?"/></widget>
    <widget handler="widgetCalibrate"><event key="c"/></widget>
    <viewport name="status" robot="magellan" xpos="0" ypos="58" xsize="100" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
      <widget handler="widgetSetSpeed">
        <event joystick="pad" axis="lefty" control="translate"/>
        <event joystick="pad" axis="leftx" control="rotate" value="-1"/>
      </widget>
      <widget handler="widgetStop"><event joystick="pad" button="b"/></widget>
      <widget handler="widgetTakeOver"><event key="t"/></widget>
    </viewport>
    <viewport name="pad" xpos="0" ypos="8" xsize="60" ysize="20">
      <visualizer function="visualizeJoystick"/>
    </viewport>
  </view>
</rune>
"""


@contextmanager
def console_at(
    hub: HubProcess, bed: VirtualBed, folder: Path, *options: str
) -> Iterator[ConsoleProcess]:
    """A console that is linked with the hub, at a machine with these devices."""
    layout = folder / "layout.xml"
    layout.write_text(LAYOUT.format(hub=hub.endpoint))
    own = {"XDG_CONFIG_HOME": str(folder), "XDG_STATE_HOME": str(folder)}
    arguments = ["run", str(layout), *options]
    with closing(ConsoleProcess(arguments, environment=bed.environment | own)) as started:
        started.wait(lambda: "linked" in started.text, 20.0, "no link")
        yield started


def report(x: int = 128, y: int = 128, *, b: bool = False) -> bytes:
    """What the pad sends: both sticks, the hat at rest, its buttons."""
    return bytes([x, y, 128, 128, 0x08 | 0x40 * b, 0, 0, 0])


def drive(pad: VirtualDevice, observer: Observer, console: ConsoleProcess) -> None:
    """Push the stick from its neutral until the robot drives at full speed.

    Where it does not, let go and push again, as a person does: on a machine that is busy, commands
    can fall silent for long enough that the robot wants neutral first.
    """
    limit = Limit(25.0)
    while not limit.over:
        pad.send(report())
        console.wait(lambda: forward(console) == "+0.00", 10.0, "the stick is not seen at rest")
        console.pump(0.3)
        pad.send(report(y=0))
        end = time.monotonic() + 5.0
        while time.monotonic() < end:
            console.pump(0.02)
            observer.client.listen(0.01)
            if observer.truth.linear > 0.45:
                return
    message = "the stick does not drive"
    raise AssertionError(message)


def forward(console: ConsoleProcess) -> str:
    """How far the bar says that the stick is moved; empty if it is not there."""
    found = [line.split() for line in console.screen.display if line.startswith("lefty")]
    return found[0][2] if found else ""


def expect_no_driving(observer: Observer) -> None:
    """The robot is commanded to stand, and goes on being."""
    observer.history.clear()
    observer.wait(lambda: len(observer.history) > 10, 10.0)
    assert {truth.commanded_linear for _, truth in observer.history} == {0.0}
