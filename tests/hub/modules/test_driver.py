"""When the driver stops the wheels, and how often it reports."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import DRIVE_COMMAND, DRIVE_STATE, STOP, GroundTruth, Stop
from hub.gcm.own_navigation import DRIVE_GOAL, OWN_NAVIGATION, DriveGoal, OwnGoal, OwnNavigation
from hub.modules.driver import __main__ as driver
from hub.modules.driver.own_goals import BodyGoals
from hub.modules.driver.watchdog import SILENCE_S
from hub.robots.interfaces import FileLoop, Sensors
from hub.robots.left_alone import LeftAlone
from hub.robots.robot_file import find_robot_file, read_description
from hub.sim.arena import load_arena
from tests.hub.modules.timed_bus import TimedBus
from tests.support.magellan import SimulatedMagellan

FORWARD, NEUTRAL = Twist.planar(0.4, 0.0), Twist.planar(0.0, 0.0)


class Wheels:
    """A base that moves as commanded, at once.

    Attributes:
        orders: Each change of velocity with its time [s].
        truth: What it says of its true pose.
        broken: Whether each reading of the hardware raises an error.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.orders: list[tuple[float, float]] = []
        self.truth: GroundTruth | None = None
        self.broken = False
        self._clock = clock
        self._linear = 0.0

    def command(self, twist: Twist) -> None:
        linear = twist.linear.x
        if linear != self._linear:
            self.orders.append((self._clock(), linear))
        self._linear = linear

    def advance(self, seconds: float) -> None:
        assert seconds >= 0.0
        if self.broken:
            text = "could not convert string to float"
            raise ValueError(text)

    def sensors(self, stamp: float) -> Sensors:
        del stamp
        velocity = Twist.planar(self._linear, 0.0)
        return Sensors(velocity=velocity, commanded=velocity)

    def ground_truth(self) -> GroundTruth | None:
        return self.truth


class Diver(Wheels):
    """A base that can surface.

    Attributes:
        actions: What it does left alone, in order.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self.actions: list[LeftAlone | None] = []

    def left_alone(self, action: LeftAlone | None) -> None:
        self.actions.append(action)


class Pilot(Wheels):
    """A base with navigation of its own.

    Attributes:
        goals: The goals that it got since the last velocity, with their times [s].
        ends: When goals ended by a velocity [s].
        state: What it reports.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        super().__init__(clock)
        self.goals: list[tuple[float, DriveGoal]] = []
        self.ends: list[float] = []
        self.state = OwnNavigation(available=1)

    def command(self, twist: Twist) -> None:
        super().command(twist)
        if self.goals:
            self.goals.clear()
            self.ends.append(self._clock())

    def stop(self) -> None:
        self.command(Twist())

    def go(self, goal: DriveGoal) -> None:
        self.goals.append((self._clock(), goal))

    def own_navigation(self) -> OwnNavigation:
        return self.state


class Waking(Wheels):
    """A base that measures by itself.

    Attributes:
        woken: Asks the driver for a report.
    """

    woken: Callable[[], bool]

    def wake_by(self, loop: FileLoop, report: Callable[[], bool]) -> None:
        del loop
        self.woken = report


class Seldom(Wheels):
    """A base that measures 20 times a second."""

    def sensors(self, stamp: float) -> Sensors:
        return dataclasses.replace(super().sensors(stamp), slow=True)


class Scene:
    """A driver and its wheels."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, base: type[Wheels] = Wheels, *settings: str
    ) -> None:
        self.bus = TimedBus(monkeypatch)
        self.wheels = base(lambda: self.bus.now)
        kind = SimpleNamespace(open_body=lambda _: self.wheels)
        monkeypatch.setattr(driver, "kind_of", lambda _: kind)
        robot, _ = read_description(find_robot_file("magellan"), settings)
        driver.build(self.bus, robot)  # type: ignore[arg-type]

    def command(self, twist: Twist) -> None:
        """Navigation sends a command now."""
        self.bus.send(DRIVE_COMMAND, TwistStamped.of(twist), "navigation")

    def reports(self, seconds: float) -> list[float]:
        """The times of the reports in the time that passes now [s]."""
        self.bus.published.clear()
        self.bus.wait(seconds)
        return [at for at, name, _ in self.bus.published if name == DRIVE_STATE.name]

    def rate(self, seconds: float) -> float:
        """Reports per second in the time that passes now."""
        return len(self.reports(seconds)) / seconds


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(monkeypatch)


def test_the_wheels_stop_when_the_silence_has_lasted_long_enough(scene: Scene) -> None:
    """Not with the next report."""
    scene.bus.wait(0.013)
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    commanded_at = scene.bus.now
    scene.bus.wait(1.0)
    assert scene.wheels.orders == [
        (commanded_at, 0.4),
        (pytest.approx(commanded_at + SILENCE_S, abs=1e-9), 0.0),
    ]


def test_the_wheels_stop_after_a_sleep_of_the_robots_computer_and_wait_for_neutral(
    scene: Scene,
) -> None:
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    scene.bus.sleep(0.02)
    scene.command(FORWARD)
    assert [velocity for _, velocity in scene.wheels.orders] == [0.4, 0.0]
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    assert [velocity for _, velocity in scene.wheels.orders] == [0.4, 0.0, 0.4]


def test_commands_keep_the_wheels_moving(scene: Scene) -> None:
    scene.command(NEUTRAL)
    for _ in range(20):
        scene.command(FORWARD)
        scene.bus.wait(0.05)
    assert [velocity for _, velocity in scene.wheels.orders] == [0.4]


def test_a_robot_that_moves_reports_fifty_times_a_second_and_one_that_stands_less(
    scene: Scene,
) -> None:
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    commanded_at = scene.bus.now
    reports = scene.reports(0.2)
    assert len(reports) == pytest.approx(13, abs=1)
    assert [at - commanded_at for at in reports[:4]] == pytest.approx([0.003, 0.006, 0.009, 0.012])
    scene.command(FORWARD)
    scene.bus.wait(0.011)
    scene.command(NEUTRAL)
    stopped_at = scene.bus.now
    assert scene.reports(0.02)[0] <= stopped_at + 0.003 + 1e-9, "and one shows the stop"
    scene.bus.wait(0.5)
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)


def test_reports_of_a_body_that_measures_seldom_go_with_the_commands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One wake-up of the processor is enough for both."""
    scene = Scene(monkeypatch, Seldom)
    scene.bus.wait(1.0)
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    scene.bus.wait(0.05)
    scene.bus.published.clear()
    commanded = []
    for jitter in (0.0, 0.004, -0.003, 0.005, -0.005, 0.002) * 5:
        commanded.append(scene.bus.now)
        scene.command(FORWARD)
        scene.bus.wait(0.05 + jitter)
    assert [at for at, name, _ in scene.bus.published if name == DRIVE_STATE.name] == commanded
    scene.bus.wait(0.5)
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0), "without commands"


def test_a_simulated_robot_that_stands_reports_as_seldom_while_its_true_pose_is_seen(
    scene: Scene,
) -> None:
    scene.wheels.truth = SimulatedMagellan(load_arena("empty")).ground_truth()
    scene.bus.watched = True
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)


def test_what_a_body_measures_by_itself_is_reported_at_once_while_it_moves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = Scene(monkeypatch, Waking)
    body = scene.wheels
    assert isinstance(body, Waking)
    assert not body.woken()
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0), "at rest"
    scene.command(NEUTRAL)

    def moves(every: float) -> float:
        """Reports per second of a body that wakes."""
        reports, steps = 0, round(2.0 / every)
        for number in range(steps):
            if not number % round(0.05 / every):
                scene.command(FORWARD)
            scene.bus.published.clear()
            assert body.woken() or not number
            scene.bus.wait(every)
            reports += sum(name == DRIVE_STATE.name for _, name, _ in scene.bus.published)
        return reports / (steps * every)

    assert moves(0.025) == pytest.approx(40.0, abs=2.0)
    looked_at = scene.reports(0.06)
    assert looked_at, "a body that is silent is still looked at"
    scene.bus.wait(looked_at[-1] + 0.03 - scene.bus.now)
    scene.bus.published.clear()
    assert body.woken()
    assert [at for at, name, _ in scene.bus.published if name == DRIVE_STATE.name] == [
        scene.bus.now
    ]
    assert moves(0.001) == pytest.approx(100.0, abs=2.0), "a flood"


def test_the_wheels_stop_although_the_hardware_cannot_be_read(scene: Scene) -> None:
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    scene.wheels.broken = True
    commanded_at = scene.bus.now
    scene.bus.wait_with_faults(1.0)
    assert scene.wheels.orders[-1] == (pytest.approx(commanded_at + SILENCE_S, abs=1e-9), 0.0)


def test_a_command_reaches_the_wheels_although_the_hardware_cannot_be_read(scene: Scene) -> None:
    scene.command(NEUTRAL)
    scene.command(FORWARD)
    scene.wheels.broken = True
    with pytest.raises(ValueError, match="could not convert"):
        scene.command(NEUTRAL)
    assert scene.wheels.orders[-1] == (scene.bus.now, 0.0)


def test_the_reports_go_on_after_a_reading_that_failed(scene: Scene) -> None:
    scene.wheels.broken = True
    faults = scene.bus.wait_with_faults(1.0)
    assert 10 <= faults <= 50, "neither silent nor a flood of errors"
    scene.wheels.broken = False
    assert scene.rate(2.0) == pytest.approx(20.0, abs=1.0)


def test_a_stop_keeps_a_robot_without_an_operator_from_surfacing_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = Scene(monkeypatch, Diver, "safety.left_alone=surface")
    assert isinstance(scene.wheels, Diver)
    owner = ControlState(owner=scene.bus.number("anna"), operator="anna")
    scene.bus.send(CONTROL_STATE, owner, "robomon")
    scene.bus.send(CONTROL_STATE, ControlState(), "robomon")
    scene.bus.wait(11.0)
    scene.bus.send(STOP, Stop(), "ben")
    scene.bus.wait(9.0)
    assert scene.wheels.actions == [LeftAlone.STAND, LeftAlone.SURFACE, LeftAlone.STAND]
    scene.bus.wait(2.0)
    assert scene.wheels.actions[-1] is LeftAlone.SURFACE


GOAL = DriveGoal(number=1, x=2.0, y=1.0, theta=0.0)


class GoalScene(Scene):
    """A driver whose body has navigation of its own, ready to drive."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        super().__init__(monkeypatch, Pilot)
        assert isinstance(self.wheels, Pilot)
        self.pilot = self.wheels
        self.command(NEUTRAL)


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> GoalScene:
    return GoalScene(monkeypatch)


def test_a_goal_goes_to_the_body_while_navigation_repeats_it(site: GoalScene) -> None:
    for _ in range(10):
        site.bus.send(DRIVE_GOAL, GOAL, "navigation")
        site.bus.wait(0.05)
    assert [goal for _, goal in site.pilot.goals] == [GOAL] * 10
    assert not site.pilot.ends
    last = site.bus.now - 0.05
    site.bus.wait(1.0)
    assert site.pilot.ends == [pytest.approx(last + SILENCE_S, abs=1e-9)]
    site.bus.send(DRIVE_GOAL, GOAL, "navigation")
    assert not site.pilot.goals, "after a silence a neutral command comes first"


def test_a_stop_and_a_velocity_end_a_goal_at_once(site: GoalScene) -> None:
    site.bus.send(DRIVE_GOAL, GOAL, "navigation")
    site.command(NEUTRAL)
    assert site.pilot.ends == [site.bus.now]
    site.bus.send(DRIVE_GOAL, GOAL, "navigation")
    site.bus.send(STOP, Stop(reason="test"), "console")
    assert site.pilot.ends == [site.bus.now] * 2


def test_goals_of_others_and_late_ones_are_refused(site: GoalScene) -> None:
    site.bus.send(DRIVE_GOAL, GOAL, "console")
    site.bus.send(DRIVE_GOAL, GOAL, "navigation", age=SILENCE_S)
    assert not site.pilot.goals


def test_the_state_of_the_goal_is_reported_at_each_change(site: GoalScene) -> None:
    site.bus.published.clear()
    site.bus.wait(1.0)
    site.pilot.state = OwnNavigation(available=1, number=1, goal=OwnGoal.DRIVES)
    site.bus.wait(0.2)
    reports = [value for _, name, value in site.bus.published if name == OWN_NAVIGATION.name]
    assert 5 <= len(reports) <= 7
    assert reports[-1] is site.pilot.state


def test_a_driver_that_ends_waits_for_the_end_of_a_goal_but_not_for_long(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With clocks that run: 0.9 s at most."""
    bus = TimedBus(monkeypatch)
    steps: list[float] = []
    body = Pilot(lambda: bus.now)

    def slept(seconds: float) -> None:
        bus.now += seconds
        if len(steps) == 3:
            body.state = OwnNavigation(ending=0)

    monkeypatch.setattr(time, "sleep", slept)
    goals = BodyGoals(bus, body, lambda *_: True)  # type: ignore[arg-type]
    body.state = OwnNavigation(ending=1)
    goals.finish(steps.append)
    assert 3 <= len(steps) <= 4
    body.state = OwnNavigation(ending=1, unanswered=1)
    began = bus.now
    goals.finish(lambda _: None)
    assert bus.now - began == pytest.approx(0.9, abs=0.02)
