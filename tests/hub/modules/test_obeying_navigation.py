"""The driver obeys the module navigation, known by its connection, and nobody else."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.errors import NotAllowedError
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import DRIVE_COMMAND, DRIVE_STATE, GROUND_TRUTH, GroundTruth
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.transport.loop import Loop
from hub.modules.driver import __main__ as driver
from hub.modules.driver.navigator import LOG_INTERVAL_S, Navigator
from hub.robots.robot_file import read_description
from tests.support.waiting import until

FORWARD, NEUTRAL = TwistStamped.planar(0.4, 0.0), TwistStamped.planar(0.0, 0.0)


def test_only_the_number_that_central_told_counts() -> None:
    navigator = Navigator()
    assert not navigator.obeys(0, 0.0)
    assert not navigator.obeys(5, 0.0)
    navigator.connected(5)
    assert navigator.obeys(5, 0.0)
    assert not navigator.obeys(6, 0.0)
    navigator.connected(0)
    assert not navigator.obeys(5, 0.0)
    assert not navigator.obeys(0, 0.0)
    assert navigator.refused == 5


def test_refused_commands_fill_no_log(caplog: pytest.LogCaptureFixture) -> None:
    navigator = Navigator()
    for step in range(1000):
        navigator.obeys(7, 0.002 * step)
    assert len(caplog.records) == round(2.0 / LOG_INTERVAL_S)
    assert "only navigation may send one" in caplog.text


class Robot:
    """A simulated robot's driver on a central, and clients in the same loop."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        file = folder / "robot.toml"
        file.write_text(
            'name = "magellan"\nkind = "simulated-magellan"\n[simulation]\narena = "empty"\n'
            '[modules.driver]\nrun = "hub.modules.driver"\n'
        )
        robot, problems = read_description(file)
        assert not problems
        self._stack = stack
        self.central = Central([f"ipc://{folder}/central"])
        stack.callback(self.central.close)
        self.loop = Loop()
        stack.callback(self.loop.close)
        self.truths: list[GroundTruth] = []
        self._commands = itertools.cycle([NEUTRAL, FORWARD, FORWARD])
        driver.build(self.client("driver"), robot)
        watcher = self.client("watcher")
        watcher.subscribe(GROUND_TRUTH, lambda truth, _: self.truths.append(truth))
        self.until(lambda: self.truths)

    def client(self, name: str) -> Client:
        made = Client(name, self.central.endpoints[0], loop=self.loop)
        self._stack.enter_context(closing(made))
        made.wait_connected(10.0)
        made.define(DRIVE_COMMAND, DRIVE_STATE)
        made.wait_defined(10.0)
        return made

    def until(
        self, condition: Callable[[], object], meanwhile: Callable[[], object] = lambda: None
    ) -> None:
        def serve() -> None:
            meanwhile()
            self.loop.listen(0.02)

        until(condition, 15.0, meanwhile=serve)

    def told(self) -> float:
        """What the wheels are told now [m/s]."""
        return float(self.truths[-1].commanded_linear)

    def send(self, client: Client) -> None:
        """One command of a driver who knows that the wheels want a neutral one first."""
        client.publish(DRIVE_COMMAND, next(self._commands))

    def drives(self, client: Client) -> None:
        """Wait until the wheels do what this client sends."""
        self.until(lambda: self.told() == 0.0, lambda: client.publish(DRIVE_COMMAND, NEUTRAL))
        begun = len(self.truths)
        self.until(
            lambda: any(truth.commanded_linear > 0.3 for truth in self.truths[begun:]),
            lambda: self.send(client),
        )


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    with ExitStack() as stack:
        yield Robot(tmp_path, stack)


def test_wheels_follow_navigation_and_its_successor(robot: Robot) -> None:
    first = robot.client("navigation")
    robot.drives(first)
    first.close()
    robot.until(lambda: robot.told() == 0.0)
    robot.drives(robot.client("navigation"))


def test_nobody_else_on_this_machine_publishes_drive_commands(robot: Robot) -> None:
    with pytest.raises(NotAllowedError, match="only the robot's module navigation sends it"):
        robot.client("pilot").publish(DRIVE_COMMAND, FORWARD)


def test_wheels_do_not_follow_who_gets_past_that(
    robot: Robot, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    for where in ("node.connection", "security.permissions"):
        monkeypatch.setattr(f"hub.ipc.{where}.demand_right", lambda *_: None)
    other, begun = robot.client("pilot"), len(robot.truths)

    robot.until(lambda: "a drive command of number" in caplog.text, lambda: robot.send(other))
    robot.until(lambda: len(robot.truths) > begun + 10, lambda: robot.send(other))
    assert {truth.commanded_linear for truth in robot.truths} == {0.0}
