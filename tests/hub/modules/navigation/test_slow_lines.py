"""No command older than its lifespan drives, on any line, by a time that no part of Rune knows.

Each schedule is a console and a hub on two machines, with a line whose ways differ. The delays
drift, jump and jitter; the clocks drift; the console's machine sleeps; the console connects again.
"""

from __future__ import annotations

import heapq
import itertools
import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Final

import pytest

from hub.gcm.body import Freedom, Motion
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.transport.clock_sync import DRIFT, ClockSync
from hub.modules.navigation.__main__ import Navigation
from hub.modules.navigation.speed_governor import SpeedGovernor
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.timed_bus import TimedBus
from tests.support.repetitions import repetitions

LIFESPAN: Final = VELOCITY_COMMAND.lifespan_s
PING_S, COMMAND_S, REPORT_S = 0.5, 0.05, 0.1
FORWARD, NEUTRAL = Twist.planar(0.4, 0.0), Twist.planar(0.0, 0.0)
ROUNDING: Final = LIFESPAN * DRIFT + 1e-6
"""The lifespan is measured by a clock that drifts [s]."""


class Way:
    """One way of a line, which keeps the order."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance
        self.base = chance.choice([0.0, math.exp(chance.uniform(math.log(0.05), math.log(2.0)))])
        self.drift = chance.choice([0.0, 0.0, chance.uniform(-0.1, 0.1)])
        self.jitter = chance.choice([0.0, 0.01, 0.3])
        self.jump = chance.choice([0.0, chance.uniform(-1.0, 1.0)])
        self._jumps_at = chance.uniform(1.0, 5.0)
        self._last = 0.0

    def arrival(self, sent: float) -> float:
        """When what is sent now arrives [s]."""
        delay = self.base + self.drift * sent + (self.jump if sent > self._jumps_at else 0.0)
        arrives = sent + max(0.0, delay) + self._chance.uniform(0.0, self.jitter)
        self._last = max(self._last, arrives)
        return self._last


class Schedule:
    """A console whose operator holds a key now and then, its hub, and the true time.

    Attributes:
        up: The way up of control.
        commands: The way up of commands.
        down: The way down.
        ages: True ages of the commands of motion that the robot followed [s].
        overdue: True times at which the wheels turned without a fresh command [s].
    """

    def __init__(self, seed: int) -> None:
        self._chance = chance = random.Random(seed)
        self._rates = [1.0 + chance.uniform(-0.5, 0.5) * DRIFT for _ in range(2)]
        self._begins = [chance.uniform(0.0, 1e6) for _ in range(2)]
        self.up, self.down, other = Way(chance), Way(chance), Way(chance)
        self.commands = chance.choice([self.up, other])
        self._sleeps_at = chance.choice([math.inf, chance.uniform(0.5, 4.0)])
        self._sleeps_s = chance.uniform(0.05, 3.0)
        self._connects = [0.0, chance.choice([math.inf, chance.uniform(1.0, 4.0)])]
        self._sync, self._connection, self._connected = ClockSync(lambda: 0.0), 0, False
        limit = Motion(freedom=Freedom.SURGE, limit=0.5, acceleration=2.0)
        self._governor = SpeedGovernor([limit], self._hub(0.0))
        self._holds, self._fresh_until = False, -math.inf
        self._events: list[tuple[float, int, Callable[[float], None]]] = []
        self._order = itertools.count()
        self.ages: list[float] = []
        self.overdue: list[float] = []

    def run(self, seconds: float = 6.0) -> None:
        """Let the true time pass."""
        for at in self._connects:
            self._at(at, self._connect)
        works: list[tuple[Callable[[float], None], float]] = [
            (self._ping, PING_S),
            (self._send, COMMAND_S),
            (self._report, REPORT_S),
        ]
        for work, period in works:
            for number in range(round(seconds / period)):
                self._at(number * period, work)
        while self._events and self._events[0][0] < seconds:
            now, _, event = heapq.heappop(self._events)
            turns = not self._governor.velocity(self._hub(now)).neutral
            if turns and now > self._fresh_until + ROUNDING:
                self.overdue.append(now)
            event(now)

    def _hub(self, now: float) -> float:
        """The hub's clock [s]."""
        return self._begins[0] + self._rates[0] * now

    def _own(self, now: float) -> float:
        """The console's clock, which stands still while its machine sleeps [s]."""
        slept = min(max(0.0, now - self._sleeps_at), self._sleeps_s)
        return self._begins[1] + self._rates[1] * (now - slept)

    def _asleep(self, now: float) -> bool:
        return 0.0 <= now - self._sleeps_at < self._sleeps_s

    def _at(self, when: float, work: Callable[[float], None]) -> None:
        heapq.heappush(self._events, (when, next(self._order), work))

    def _connect(self, now: float) -> None:
        self._sync.begin(1)
        self._connection += 1
        self._connected = False
        self._ping(now)

    def _ping(self, now: float) -> None:
        if self._asleep(now):
            return
        sent, connection = self._own(now), self._connection

        def answer(now: float) -> None:
            hub_time = self._hub(now)

            def answered(now: float) -> None:
                if self._asleep(now):
                    self._at(self._sleeps_at + self._sleeps_s + ROUNDING, answered)
                elif connection == self._connection:
                    self._sync.note(sent, hub_time, self._own(now))
                    self._connected = True

            self._at(self.down.arrival(now), answered)

        self._at(self.up.arrival(now), answer)

    def _send(self, now: float) -> None:
        if self._chance.random() < 0.04:
            self._holds = not self._holds
        if self._asleep(now) or not self._connected:
            return
        twist, sent = FORWARD if self._holds else NEUTRAL, now
        stamp = self._own(now) + self._sync.least

        def receive(now: float) -> None:
            hub_now = self._hub(now)
            age, refused = max(0.0, hub_now - stamp), self._governor.refused
            if age > LIFESPAN:
                return
            self._governor.command(self._connection, twist, hub_now - age, hub_now)
            if self._governor.refused == refused and not twist.neutral:
                self.ages.append(now - sent)
                self._fresh_until = sent + LIFESPAN

        self._at(self.commands.arrival(now), receive)

    def _report(self, now: float) -> None:
        self._governor.driver_reported(self._hub(now))


def test_no_command_that_is_older_than_its_lifespan_drives() -> None:
    """Also when the operator has released the key meanwhile."""
    driven = 0
    for seed in range(repetitions(300, 100_000)):
        schedule = Schedule(seed)
        schedule.run()
        oldest = max(schedule.ages, default=0.0)
        assert oldest <= LIFESPAN + ROUNDING, f"schedule {seed}: {oldest} s old"
        assert not schedule.overdue, f"schedule {seed}: still drives at {schedule.overdue[0]} s"
        driven += bool(schedule.ages)
    assert driven > 20, "good lines drive"


def test_navigation_says_that_a_motion_came_too_late(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    bus = TimedBus(monkeypatch)
    Navigation(bus, read_description(find_robot_file("magellan"))[0])  # type: ignore[arg-type]

    def said() -> list[str]:
        all_said = [each for _, name, each in bus.published if name == DIAGNOSTICS.name]
        return [status.message for status in all_said[-1].status]

    bus.wait(1.0)
    bus.send(VELOCITY_COMMAND, TwistStamped.of(NEUTRAL), "console", 0.7, late=True)
    assert said() == [], "an idle console"
    bus.send(VELOCITY_COMMAND, TwistStamped.of(FORWARD), "console", 0.7, late=True)
    assert said() == ["a command came too late to drive: up to 0.70 s old, 0.3 s is the most"]
    bus.wait(4.0)
    assert said() == []


@pytest.mark.parametrize(
    ("up", "commands", "down", "drives"),
    [
        (0.1, 0.1, 0.1, True),
        (0.2, 0.2, 0.0, True),
        (0.0, 0.0, 0.2, True),
        (0.4, 0.4, 0.0, False),
        (1.2, 0.7, 0.0, False),
        (0.05, 0.7, 0.05, False),
        (0.2, 0.2, 0.2, False),
    ],
)
def test_a_line_drives_if_its_way_up_and_shortest_way_down_fit_into_the_lifespan(
    up: float, commands: float, down: float, *, drives: bool
) -> None:
    held = 0
    for seed in range(30):
        schedule = Schedule(seed)
        schedule.commands = Way(random.Random(seed))
        for way, delay in ((schedule.up, up), (schedule.commands, commands), (schedule.down, down)):
            way.base, way.drift, way.jitter, way.jump = delay, 0.0, 0.0, 0.0
        schedule.run()
        held += len(schedule.ages)
        assert not schedule.overdue
    assert (held > 200) == drives, held
    assert drives or not held
