"""From hands to wheels without a process: the pure parts of console and robot, on one clock.

What connects them here is what connects them there: `rune_tui.app` for the console, a link that
takes its time, and the modules navigation and driver for the robot, with their periods.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable
from types import MappingProxyType
from typing import Any

from hub.gcm.control import CONTROL_STATE, ConsoleHeartbeat, ControlAction, ControlState
from hub.gcm.navigation import ROBOT_STATE, STOP, VELOCITY_COMMAND
from hub.own_pauses import OwnPauses
from rune_tui.controls.devices.device_reader import Gone, Opened, Scanned
from rune_tui.controls.events import PAUSE_S, STALE_S, ControlEvent
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ControlEffect, Effect, ReleaseFirst, SendEffect
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from tests.console.controls.joystick.fake_reader import FakeReader
from tests.console.controls.joystick.pads import LEFT_X, LEFT_Y, PAD, REST, device
from tests.console.controls.pure_agent import HeardPads, PadAgent
from tests.console.controls.pure_robot import STEP_S, Robot
from tests.console.controls.slow_link import Link
from tests.support.messages import robot_state

TICK_S = 0.05
"""How often the console does [s]."""
ROBOT = "magellan"
_REPEAT_S = 0.03
_GAPS = 0.15
"""The share of repeats that come late, where there are gaps."""
_ROUND_TRIP_S = 0.02
_HAND_S = 0.06
_CENTRE, _THROW = 128, 127


class Console:
    """A console with a pad and keys, as `rune_tui.app` connects its parts.

    Attributes:
        runs: Whether it does; False while it is stopped, or dead.
        joysticks: What it knows of joysticks.
        link: Its way to the robot.
        reader: What is plugged in.
    """

    def __init__(
        self,
        layout: LayoutSpec,
        link: Link,
        phase: float,
        now: float,
        reader: FakeReader | HeardPads,
    ) -> None:
        self.link = link
        self.runs = True
        self.reader = reader
        self.joysticks = Joysticks(layout.joysticks, self.reader, CalibrationStore())
        self.joysticks.start(lambda: None)
        self.resting = False
        self._dispatch = Dispatch(layout)
        self._keyboard = KeyboardHold(self._dispatch.waits_for_hold)
        self._pauses = OwnPauses(PAUSE_S, stale_s=STALE_S)
        self._owner = self._stops = 0
        self._due = now + phase * TICK_S
        self._robots = self._known()

    def hears(self, owner: int, stops: int) -> None:
        """The robot says who has control, and how often it was stopped."""
        if (owner, stops) != (self._owner, self._stops):
            self._owner, self._stops = owner, stops
            self._robots = self._known()

    def connected(self) -> None:
        """Its link is there anew, and who has control is not known yet."""
        self._owner = 0
        self._robots = self._known()

    def pass_time(self, now: float) -> None:
        """As the app's clock does."""
        if self.runs and now >= self._due:
            self._due = max(self._due + TICK_S, now)
            self.link.send(ConsoleHeartbeat(holds=int(self._owner == self.link.number)), now)
            self._look_up(now)
            self._execute(self._dispatch.look(self._state(now)), now)
            self._keyboard.answers = True
            self._keyboard.heard(now, now - _ROUND_TRIP_S)
            self._handle(self._keyboard.expire(now), now)
            self._execute(self._dispatch.tick(self._state(now)), now)

    def key(self, key: str, now: float) -> None:
        self._look_up(now)
        self._execute(self._dispatch.look(self._state(now)), now)
        self._handle(self._keyboard.press(key, now, stale=self._pauses.is_stale(now)), now)

    def moved(self, now: float) -> None:
        """The pad has something to tell."""
        self._look_up(now)
        self._handle(self.joysticks.events(now), now)
        if self.resting:
            self._handle(self.joysticks.release_all(now), now)

    def let_go(self, now: float) -> None:
        self._keyboard.release_all(now)
        released = self.joysticks.release_all(now)
        self._execute(self._dispatch.released(self._state(now)), now)
        self._handle(released, now)

    def _look_up(self, now: float) -> None:
        if self._pauses.look(now):
            self.let_go(now)

    def _handle(self, events: Iterable[ControlEvent], now: float) -> None:
        for event in events:
            self._execute(self._dispatch.handle(event, self._state(now)), now)

    def _execute(self, effects: Iterable[Effect], now: float) -> None:
        for effect in effects:
            if isinstance(effect, SendEffect | ControlEffect):
                self.link.send(effect, now)
            elif isinstance(effect, ReleaseFirst):
                self._keyboard.stop(effect.keys, now)

    def _state(self, now: float) -> ConsoleState:
        return ConsoleState(
            now=now, robots=self._robots, joysticks=self.joysticks.states, help=self.resting
        )

    def _known(self) -> Any:
        number = self.link.number
        link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="", number=number)
        state = Received(value=ControlState(owner=self._owner), measured=0.0, number=1)
        driven = Received(value=robot_state(stops=self._stops), measured=0.0, number=1)
        messages = {CONTROL_STATE.name: state, ROBOT_STATE.name: driven}
        robot = RobotState(name=ROBOT, link=link, messages=messages)
        return MappingProxyType({ROBOT: robot})


class World:
    """A robot, an operator's console, perhaps a rival's, and the operator's hands.

    Attributes:
        now: The robot's clock [s].
        ahead: How much the operator's clock is ahead of it [s].
        gaps: Whether repeats of a key that is held are missing now and then.
        driven_until: When a motion was last commanded to the wheels [s].
        moved_until: When they last moved [s].
        agent: What the pad is plugged in at; None: the console's machine.
    """

    def __init__(
        self, layout: LayoutSpec, chance: random.Random, *, elsewhere: bool = False
    ) -> None:
        self.now = 0.0
        self.ahead = 0.0
        self.chance = chance
        self.robot = Robot()
        self.driven_until = self.moved_until = -math.inf
        self.consoles: list[Console] = []
        self._layout = layout
        self._numbers = 0
        self._paths = 0
        self._stick: tuple[float, float] | None = None
        self._key = ""
        self.gaps = False
        self._hand_due = self._repeat_due = self._rival_due = self._report_due = 0.0
        self._reported_stops = 0
        self._path = ""
        self._rival: Console | None = None
        self._rival_key = ""
        self.agent: PadAgent | None = None
        self._elsewhere = elsewhere
        self.console = self.start()
        if elsewhere:
            self.start_agent()
        else:
            self.plug()

    def _way(self) -> Link:
        self._numbers += 1
        return Link(delay=self.chance.uniform(0.001, 0.02), number=self._numbers)

    def start(self) -> Console:
        """Somebody starts a console."""
        now = self.now + self.ahead
        elsewhere = self._elsewhere and not self.consoles
        reader = HeardPads(clock=lambda: self.now + self.ahead) if elsewhere else FakeReader()
        made = Console(self._layout, self._way(), self.chance.random(), now, reader)
        self.consoles.append(made)
        return made

    def start_agent(self) -> None:
        """The operator starts `rune pad`; the pad says where it stands when it is moved."""
        self.agent = PadAgent(self._way(), self.now + self.ahead)

    @property
    def rival(self) -> Console:
        """Somebody else's console, with the same keys and no pad."""
        if self._rival is None:
            self._rival = self.start()
            self.wait(0.1)
        return self._rival

    def rival_pushes(self) -> None:
        """The rival holds a key from now on."""
        self._rival_key = "s"
        assert self.rival.runs

    def reconnect(self) -> None:
        """The console's link is there again; central takes it for another one."""
        link = self.console.link
        self.robot.arbiter.disconnected(link.number, self.now)
        self._numbers += 1
        link.number, link.gone = self._numbers, False
        self.console.connected()

    def plug(self) -> None:
        """Plug the pad in at the operator's console; it says where it stands when it is moved."""
        self._paths += 1
        self._path = f"/dev/hidraw{self._paths}"
        reader = self._plugged
        reader.told.append(Scanned((device(self._path),)))
        self.console.moved(self.now + self.ahead)
        reader.told += [Opened(path, PAD) for path in reader.asked]
        reader.asked.clear()
        self.console.moved(self.now + self.ahead)
        self._report(REST if self._stick is None else self._positions())

    @property
    def _plugged(self) -> FakeReader:
        assert isinstance(self.console.reader, FakeReader)
        return self.console.reader

    def unplug(self) -> None:
        reader = self._plugged
        reader.told += [Gone(self._path), Scanned(())]
        self.console.moved(self.now + self.ahead)
        self._path = ""

    def neutral(self) -> None:
        """Hands off."""
        self._stick, self._key, self._rival_key = None, "", ""
        self.gaps = False
        self._report(REST)

    def push(self) -> None:
        """Deflect the stick, in any direction."""
        angle = self.chance.choice(
            (self.chance.uniform(0.0, 2.0 * math.pi), self.chance.randrange(4) * math.pi / 2.0)
        )
        self._stick = math.cos(angle), math.sin(angle)
        self._report(self._positions())

    def hold_key(self) -> None:
        """It repeats after the keyboard's delay."""
        self._key = self.chance.choice("ws")
        self.console.key(self._key, self.now + self.ahead)
        self._repeat_due = self.now + self.chance.uniform(0.25, 0.55)

    def wait(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Let time pass, so much or until this holds."""
        end = self.now + seconds - STEP_S / 2
        while self.now < end and not until():
            self._step()

    def _step(self) -> None:
        self.now += STEP_S
        self._hands()
        if self.agent is not None:
            self._hear(self.agent, self.now + self.ahead)
        for console in self.consoles:
            ahead = self.ahead if console is self.console else 0.0
            console.pass_time(self.now + ahead)
            for sent, effect in console.link.arrived(self.now + ahead):
                self._take(effect, console.link.number, sent - ahead)
        self.robot.pass_time(self.now)
        if self.now >= self._report_due:
            self._report_due = self.now + 1.0 / ROBOT_STATE.rate_hz
            self._reported_stops = self.robot.stops
        for console in self.consoles:
            if console.runs and not (console.link.cut or console.link.gone):
                console.hears(self.robot.owner, self._reported_stops)
        if self.robot.driven:
            self.driven_until = self.now
        if self.robot.moves:
            self.moved_until = self.now

    def _hear(self, agent: PadAgent, now: float) -> None:
        pads = self.console.reader
        agent.pass_time(now)
        if self.console.runs and isinstance(pads, HeardPads):
            agent.told(pads, now)
            self.console.moved(now)

    def _take(
        self, effect: SendEffect | ControlEffect | ConsoleHeartbeat, number: int, sent: float
    ) -> None:
        if isinstance(effect, ConsoleHeartbeat):
            self.robot.arbiter.heartbeat(number, self.now, holds=bool(effect.holds))
        elif isinstance(effect, ControlEffect):
            if effect.action is ControlAction.RELEASE:
                self.robot.arbiter.release(number, self.now)
            else:
                self.robot.arbiter.take(number, "", self.now)
            self.robot.tell(self.now)
        elif effect.definition is VELOCITY_COMMAND:
            self.robot.command(number, effect.value.twist, sent, self.now)
        elif effect.definition is STOP:
            self.robot.stop(self.now)

    def _hands(self) -> None:
        if self._stick is not None and self.now >= self._hand_due:
            self._hand_due = self.now + _HAND_S
            self._report(self._positions(self.chance.uniform(0.8, 1.0)))
        if self._key and self.now >= self._repeat_due and self.console.runs:
            self._repeat_due = self.now + self._pause()
            self.console.key(self._key, self.now + self.ahead)
        if self._rival_key and self.now >= self._rival_due:
            self._rival_due = self.now + _REPEAT_S
            self.rival.key(self._rival_key, self.now)

    def _pause(self) -> float:
        """Until the key that is held repeats again [s]."""
        if self.gaps and self.chance.random() < _GAPS:
            return self.chance.uniform(0.1, 0.5)
        return _REPEAT_S

    def _positions(self, share: float = 1.0) -> tuple[tuple[int, int | None], ...]:
        """The stick, with the wobble of a hand."""
        x, y = self._stick or (0.0, 0.0)
        wobble = self.chance.uniform(-0.2, 0.2)
        x, y = share * x - wobble * y, share * y + wobble * x
        x, y = (max(-1.0, min(1.0, each)) for each in (x, y))
        return (
            (LEFT_X, round(_CENTRE + _THROW * x) & 0xFF),
            (LEFT_Y, round(_CENTRE + _THROW * y) & 0xFF),
        )

    def _report(self, values: tuple[tuple[int, int | None], ...]) -> None:
        if self.agent is not None:
            self.agent.report(values)
            return
        inbox = self.console.reader.inbox(self._path)
        if inbox is not None and inbox.put(values) and self.console.runs:
            self.console.moved(self.now + self.ahead)
