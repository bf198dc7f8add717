"""A recorded robot, the consoles that drive it, a pad and keys: what cases of stale sticks need."""

from __future__ import annotations

import contextlib
import itertools
import math
import os
import random
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hub.gcm.body import Freedom
from tests.support import warm_start
from tests.support.bodies import robot_of
from tests.support.fake_hid import VirtualBed, VirtualDevice
from tests.support.waiting import until
from tests.system.driven_autopilot import DOOR, RecordedAutopilot
from tests.system.driven_ros import WITH_ROS, RecordedRos
from tests.system.harness import ConsoleProcess, HubProcess
from tests.system.recorded_robot import Recording, Row
from tests.system.terminal_process import DELAY_S, write_keys

_PAD = "logitech_f310_dinput"
_STICKS = """
    <event joystick="pad" axis="lefty" control="translate"/>
    <event joystick="pad" axis="leftx" control="rotate" value="-1"/>
"""
_GUARDED = """
  <widget handler="widgetSetSpeed">
    <event joystick="pad" axis="righty" control="translate"/>
    <event joystick="pad" axis="rightx" control="rotate" value="-1"/>
    <event joystick="pad" button="leftshoulder" control="enable"/>
  </widget>
"""
_LAYOUT = """<rune run="1">
  <robot name="magellan" hub="{hub}">
    <capability name="NAV_STATE"/>
    <capability name="NAV_MOVE"/>
    {capabilities}
  </robot>
  {joystick}
  <view xsize="160" ysize="16">
    <widget handler="widgetHelp"><event key="?"/></widget>
    <viewport name="status" robot="magellan" xpos="0" ypos="0" xsize="160" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/>
        <event key="s" control="translate" value="-1"/>
        {keys}
        {sticks}
      </widget>
      {guarded}
      {orders}
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetTakeOver"><event key="k"/></widget>
      <widget handler="widgetReleaseControl"><event key="c"/></widget>
    </viewport>
    <viewport name="pad" xpos="0" ypos="2" xsize="60" ysize="14">
      <visualizer function="visualizeJoystick"/>
    </viewport>
    {pane}
  </view>
</rune>
"""
_CAPABILITIES = '<capability name="DRV_MODE"/><capability name="DRV_ARM"/>'
_ORDERS = """
      <widget handler="widgetArm"><event key="e"/></widget>
      <widget handler="widgetAutopilot"><event key="g"/></widget>
"""
_PANE = """
    <viewport name="autopilot" robot="magellan" xpos="60" ypos="2" xsize="100" ysize="14">
      <visualizer function="visualizeAutopilot" message="GCM_Autopilot_State"/>
    </viewport>
"""
_FOLLOWS, _DISARMED = "follows you", "DISARMED"
_KEYS = {
    Freedom.SWAY: ("q", "strafe"),
    Freedom.HEAVE: ("r", "climb"),
}
"""The keys of motions that not every body has, and their controls."""
_CENTRE, _THROW = 128, 127
_READY = "STANDING", "HOLDS", "BRAKES", "DRIFTS"
"""Words of the status line for a robot that follows the next command."""
_TRIES = 5
_ASKED_AGAIN_S = 1.2
_PRELOAD = "LD_PRELOAD"
_REPEAT_S = 0.033
_GAPS = 0.15
"""The share of repeats that come late, where there are gaps."""
_SHOULDER = 1


def layout(hub: str, body: str, *, pad: bool) -> str:
    """A layout that drives with keys, and with the pad's sticks; the right one is guarded."""
    parts = ('<joystick name="pad"/>', _STICKS, _GUARDED) if pad else ("", "", "")
    own = (_CAPABILITIES, _ORDERS, _PANE) if body.startswith(DOOR) else ("", "", "")
    keys = (f'<event key="{key}" control="{control}"/>' for key, control in _own_keys(body))
    return _LAYOUT.format(
        hub=hub,
        keys="".join(keys),
        **dict(zip(("joystick", "sticks", "guarded"), parts, strict=True)),
        **dict(zip(("capabilities", "orders", "pane"), own, strict=True)),
    )


def _own_keys(body: str) -> list[tuple[str, str]]:
    if body.startswith((DOOR, WITH_ROS)):
        return []
    return [_KEYS[each.freedom] for each in robot_of(body).body.motions if each.freedom in _KEYS]


def recording(folder: Path, body: str) -> Recording:
    """What records the robot with this body."""
    if body.startswith(WITH_ROS):
        return RecordedRos(folder, body)
    return (RecordedAutopilot if body.startswith(DOOR) else Recording)(folder, body)


class Finger:
    """Keeps a key down: a press and repeats, at whatever terminal that is then.

    Attributes:
        gaps: Whether some repeats come late, as much as a window manager or a line makes them.
    """

    def __init__(self) -> None:
        self.gaps = False
        self._lifted = threading.Event()
        self._thread: threading.Thread | None = None

    def press(self, terminal: Callable[[], int], key: str) -> None:
        """Until it is lifted."""
        self._lifted.clear()
        chance = random.Random(key)

        def repeat() -> None:
            pause = 0.0
            for number in itertools.count():
                if self._lifted.wait(pause):
                    return
                with contextlib.suppress(OSError):  # the terminal is closed, or takes no more
                    write_keys(terminal(), key.encode())
                late = self.gaps and chance.random() < _GAPS
                pause = chance.uniform(0.16, 0.5) if late else _REPEAT_S if number else DELAY_S

        self._thread = threading.Thread(target=repeat)
        self._thread.start()

    def lift(self) -> None:
        self._lifted.set()
        self.gaps = False
        if self._thread is not None:
            self._thread.join()
            self._thread = None


class DrivenRobot:
    """A hub whose robot is recorded, and what drives it.

    Attributes:
        hub: The hub.
        record: The commands to the robot, and its motion.
        chance: Decides what is left to chance.
        console: The operator's.
        rival: Somebody else's console, without a pad; None: there is none.
        pad: What is plugged in; None: nothing is.
        finger: On the operator's keys.
        agent: `rune pad` at the operator's machine, if that is another one than the console's.
    """

    def __init__(
        self,
        folder: Path,
        bed: VirtualBed,
        *,
        body: str = "magellan",
        clock: dict[str, str] | None = None,
        programs: Path | None = None,
    ) -> None:
        """Start all but the rival.

        Args:
            folder: For files.
            bed: Where the pad is plugged in.
            body: One of `BODIES`.
            clock: Variables of processes with another wall clock.
            programs: Folder of programs that consoles find before all others.
        """
        self.chance = random.Random(1)
        self.record = recording(folder, body)
        self.console: ConsoleProcess
        self.rival: ConsoleProcess | None = None
        self.pad: VirtualDevice | None = None
        self.finger = Finger()
        self.agent: warm_start.Process | None = None
        self._nothing_plugged = VirtualBed()
        self._folder = folder
        self._bed = bed
        self._way: tuple[str, ...] = ()
        self._programs = programs
        preloaded = filter(None, ((clock or {}).get(_PRELOAD), bed.environment[_PRELOAD]))
        # The same for all, so that all are forked from one process; only some get a bed.
        self._common = {
            **(clock or {}),
            **self.record.environment,
            _PRELOAD: ":".join(preloaded),
        }
        self._name = f"driven-{os.getpid()}-{folder.name}"[:32]
        self._stick = (0.0, 0.0)
        self._guarded = False
        self._driving_keys = ["w", "s", *(key for key, _ in _own_keys(body))]
        self.hub = self._started_hub()
        (folder / "pad.xml").write_text(layout(self.hub.endpoint, body, pad=True))
        (folder / "keys.xml").write_text(layout(self.hub.endpoint, body, pad=False))
        self.plug()
        self.console = self._started_console(())

    # The parts of it.

    def _started_hub(self) -> HubProcess:
        modules = ("driver", "navigation")
        return HubProcess(
            self._folder,
            environment=self._common,
            name=self._name,
            modules=modules,
            **self.record.hub,
        )

    def start_hub(self) -> None:
        """Another one in place of the last."""
        self.hub.close()
        self.hub = self._started_hub()

    def _started_console(
        self, way: tuple[str, ...], *, own: bool = True, elsewhere: bool = False
    ) -> ConsoleProcess:
        bed = self._nothing_plugged if elsewhere else self._bed
        environment = self._operator(bed) if own else self._files() | {"LOGNAME": "bob"}
        file = self._folder / ("pad.xml" if own else "keys.xml")
        command = ["run", *(() if elsewhere else way), str(file)]
        return ConsoleProcess(command, columns=160, rows=8, environment=environment)

    def _files(self) -> dict[str, str]:
        """Where a console and `rune pad` keep their files and find programs, and their clock."""
        own = {"XDG_CONFIG_HOME": str(self._folder), "XDG_STATE_HOME": str(self._folder)}
        own |= {"PATH": f"{self._programs}:{os.environ['PATH']}"} if self._programs else {}
        return own | self._common

    def _operator(self, bed: VirtualBed) -> dict[str, str]:
        return bed.environment | self._files() | {"LOGNAME": "alice"}

    def start_console(self) -> None:
        """Another console in place of the last, in the same way."""
        self.console.close()
        self.console = self._started_console(self._way, elsewhere=self.agent is not None)

    def start_agent(self) -> None:
        """Another `rune pad` in place of the last; the pad is as deflected as it was."""
        self._end_agent()
        command = [sys.executable, "-m", "rune_tui", "pad", self.hub.endpoint, *self._way]
        environment = os.environ | self._operator(self._bed)
        self.agent = warm_start.start(command, environment=environment)

    def _end_agent(self) -> None:
        if self.agent is not None:
            self.agent.kill()
            self.agent.wait()
            self.agent = None

    def want_operator(self, *way: str, elsewhere: bool = False) -> None:
        """The operator's console is well.

        Args:
            way: Options of the command for the way from the operator's machine to the hub.
            elsewhere: Whether the pad is at another machine than the console.
        """
        as_wanted = way == self._way and elsewhere == (self.agent is not None)
        self._way = way
        if not as_wanted:
            self._end_agent()
            if elsewhere:
                self.start_agent()
        if not as_wanted or self.console.process.poll() is not None:
            self.start_console()
        self.wait(lambda: "linked" in self.console.text, "the console is not linked")

    def start_rival(self) -> ConsoleProcess:
        """Somebody else's console, if it does not run yet."""
        if self.rival is None:
            self.rival = self._started_console((), own=False)
        rival = self.rival
        self.wait(lambda: "linked" in rival.text, "the other console is not linked")
        return rival

    def plug(self) -> None:
        """Plug the pad in, as deflected as it was."""
        self.pad = self._bed.plug(_PAD)

    def unplug(self) -> None:
        """Pull it out."""
        if self.pad is not None:
            self.pad.unplug()
            self.pad = None

    def close(self) -> None:
        self.finger.lift()
        for console in (self.console, self.rival):
            if console is not None:
                console.close()
        self._end_agent()
        self.unplug()
        self._nothing_plugged.close()
        self.hub.close()
        self.record.close()

    # Hands.

    def neutral(self) -> None:
        """Let go of everything."""
        self.finger.lift()
        self._stick, self._guarded = (0.0, 0.0), False
        self._report()

    def hold_key(self) -> None:
        """Hold a key that drives."""
        key = self.chance.choice(self._driving_keys)
        self.finger.press(lambda: self.console.terminal, key)

    def push(self, *, guarded: bool = False) -> None:
        """Deflect a stick; `guarded`: the right one, with the dead-man button held."""
        angle = self.chance.uniform(0.0, 2.0 * math.pi)
        self._stick = (math.cos(angle), math.sin(angle))
        self._guarded = guarded
        self._report(shoulder=guarded)

    def insist(self) -> None:
        """Whoever holds a stick goes on; keys are held anyway."""
        if self._stick != (0.0, 0.0):
            self.shake(shoulder=self._guarded)

    def shake(self, *, shoulder: bool = False) -> None:
        """Hold the stick as hands do: it reports again and again, and stays deflected."""
        self._report(self.chance.uniform(0.7, 1.0), shoulder=shoulder)

    def _report(self, share: float = 1.0, *, shoulder: bool = False) -> None:
        x, y = (round(_CENTRE + share * _THROW * each) for each in self._stick)
        rest = [_CENTRE, _CENTRE]
        axes = [*rest, x, y] if self._guarded else [x, y, *rest]
        assert self.pad is not None
        self.pad.send(bytes([*axes, 0x08, _SHOULDER * shoulder, 0, 0]))

    # Waiting.

    def pump(self) -> None:
        """Let the consoles write."""
        for console in (self.console, self.rival):
            if console is not None and console.process.poll() is None:
                console.pump(0.01)

    def wait(self, condition: Callable[[], object], why: str, timeout: float = 15.0) -> None:
        until(condition, timeout, lambda: f"{why}\n{self._said()}", meanwhile=self.pump)

    def watch(self, seconds: float) -> None:
        """Let time go by."""
        end = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() >= end, "time stands still")

    def _said(self) -> str:
        others = [self.rival.text] if self.rival is not None else []
        return "\n".join([self.console.text, *others, str(self.record.now)])

    # Driving.

    def drive(self, press: Callable[[], Any], let_go: Callable[[], Any]) -> None:
        """Drive from neutral, for a while that is left to chance.

        Where the robot does not, let go and push again, as a person does: on a machine that is
        busy, commands can fall silent for long enough that it wants neutral first.
        """
        for _ in range(_TRIES):
            let_go()
            self._make_it_follow()
            self.wait(self._at_rest, "the robot does not want to be driven")
            self.record.forget()
            press()
            end = time.monotonic() + 2.0
            while time.monotonic() < end:
                self.pump()
                if self._drives(self.record.now):
                    self.watch(self.chance.uniform(0.0, 0.4))
                    if self._drives(self.record.now):
                        return
        message = f"nothing drives the robot\n{self._said()}"
        raise AssertionError(message)

    def _make_it_follow(self) -> None:
        """Arm a vehicle with an autopilot, or ask it for the mode that follows."""
        if not isinstance(self.record, RecordedAutopilot):
            return
        asked_at = -math.inf

        def follows() -> bool:
            nonlocal asked_at
            if time.monotonic() - asked_at > _ASKED_AGAIN_S:
                asked_at = time.monotonic()
                self.console.type("e" if _DISARMED in self.console.text else "g")
            return _FOLLOWS in self.console.text

        self.wait(follows, "the vehicle does not follow", 30.0)

    def _at_rest(self) -> bool:
        shown = [line.split() for line in self.console.screen.display]
        whole = (words for words in shown if len(words) > 2)
        axes = [words[2] for words in whole if words[0].endswith(("x", "y"))]
        seen = self.pad is None or (axes and set(axes) <= {"+0.00", "-0.00"})
        text = self.console.text
        ready = any(word in text for word in _READY)
        return bool(seen and ready and "LET GO OF" not in text)

    def _drives(self, row: Row) -> bool:
        return row.commanded and (row.speed > 0.1 or abs(row.yaw) > 0.2)
