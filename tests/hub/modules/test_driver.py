"""When the driver stops the wheels, and how often it reports."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hub.gcm.navigation import DRIVE_COMMAND, DRIVE_STATE, DriveState, GroundTruth, Twist
from hub.ipc.message_info import MessageInfo
from hub.ipc.transport.timers import Timers
from hub.modules.driver import __main__ as driver
from hub.modules.driver.watchdog import SILENCE_S
from hub.robots.description import find_robot_file, read_description
from hub.robots.magellan import SimulatedMagellan
from hub.sim.arena import load_arena

NAVIGATION = 7
FORWARD, NEUTRAL = Twist.planar(0.4, 0.0), Twist.planar(0.0, 0.0)
NOTHING = np.full(16, np.inf, np.float32)


class Wheels:
    """A base that moves as it is told, at once.

    Attributes:
        orders: Each change of velocity with its time [s].
        truth: What it says of its true pose.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.orders: list[tuple[float, float]] = []
        self.truth: GroundTruth | None = None
        self._clock = clock
        self._linear = 0.0

    def set_velocity(self, linear: float, angular: float) -> None:
        del angular
        if linear != self._linear:
            self.orders.append((self._clock(), linear))
        self._linear = linear

    def advance(self, seconds: float) -> None:
        assert seconds >= 0.0

    def drive_state(self, stamp: float) -> DriveState:
        del stamp
        still = dict.fromkeys(("stamp", "x", "y", "theta", "angular", "commanded_angular"), 0.0)
        return DriveState(
            **still,
            linear=self._linear,
            commanded_linear=self._linear,
            sonar=NOTHING,
            infrared=NOTHING,
            bumpers=0,
            battery_voltage=math.nan,
            battery_fraction=math.nan,
        )

    def ground_truth(self) -> GroundTruth | None:
        return self.truth


class Scene:
    """A driver, its wheels, and a bus on which time passes only when a test says so."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        self.watched = False
        self.reports: list[float] = []
        self._timers = Timers()
        self._handlers: dict[str, Callable[..., None]] = {}
        self.wheels = Wheels(lambda: self.now)
        kind = SimpleNamespace(open_base=lambda _: self.wheels)
        monkeypatch.setattr(driver, "kind_of", lambda _: kind)
        monkeypatch.setattr(time, "monotonic", lambda: self.now)
        robot, _ = read_description(find_robot_file("magellan"))
        bus: Any = SimpleNamespace(
            alarm=self._timers.alarm,
            define=lambda *_: None,
            directory=SimpleNamespace(follow=lambda _, connected: connected(NAVIGATION)),
            has_subscribers=lambda _: self.watched,
            publish=self._publish,
            subscribe=self._subscribe,
        )
        driver.build(bus, robot)

    def command(self, twist: Twist) -> None:
        """Navigation sends a command now."""
        self._handlers[DRIVE_COMMAND.name](twist, MessageInfo(NAVIGATION, 1, 0, 0.0, self.now))

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds
        while (due := self._timers.due(math.inf)) <= end:
            self.now = max(self.now, due)
            self._timers.run(self.now)
        self.now = end

    def rate(self, seconds: float) -> float:
        """Reports per second in the time that passes now."""
        self.reports.clear()
        self.wait(seconds)
        return len(self.reports) / seconds

    def _publish(self, definition: Any, _value: object, *, measured: float) -> None:
        if definition is DRIVE_STATE:
            self.reports.append(measured)

    def _subscribe(self, definition: Any, handler: Callable[..., None], **_: Any) -> None:
        self._handlers[definition.name] = handler


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(monkeypatch)


def test_the_wheels_stop_when_the_silence_has_lasted_long_enough(scene: Scene) -> None:
    """Not with the next report."""
    scene.wait(0.013)
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    told = scene.now
    scene.wait(1.0)
    assert scene.wheels.orders == [
        (told, 0.4),
        (pytest.approx(told + SILENCE_S, abs=1e-9), 0.0),
    ]


def test_commands_keep_the_wheels_moving(scene: Scene) -> None:
    scene.command(NEUTRAL)
    for _ in range(20):
        scene.command(FORWARD)
        scene.wait(0.05)
    assert [velocity for _, velocity in scene.wheels.orders] == [0.4]


def test_a_robot_that_moves_reports_fifty_times_a_second_and_one_that_stands_less(
    scene: Scene,
) -> None:
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    told = scene.now
    assert scene.rate(0.2) == pytest.approx(50.0, abs=5.0)
    assert scene.reports[0] <= told + 0.02 + 1e-9, "the first report shows the motion soon"
    scene.wait(0.5)
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)


def test_a_simulated_robot_that_stands_reports_as_often_while_its_true_pose_is_seen(
    scene: Scene,
) -> None:
    scene.wheels.truth = SimulatedMagellan(load_arena("empty")).ground_truth()
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)
    scene.watched = True
    scene.wait(0.1)
    assert scene.rate(2.0) == pytest.approx(50.0, abs=1.0)
