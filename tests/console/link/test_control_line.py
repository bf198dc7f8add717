"""Two links at one robot's hub, and the daemon's desk that says who has control."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.control_gate import ControlGate
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.autonomy import AUTONOMY_COMMAND, AutonomyCommand
from hub.gcm.control import CONSOLE_HEARTBEAT, ControlAction
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from hub.robomon.control_service import ControlService
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.control import Standing, asks, control_of, standing
from rune_tui.startup.opening import open_layout
from tests.support.waiting import until

LAYOUT = """<rune>
  <robot name="magellan" hub="{hub}"><capability name="AUT_PILOT"/></robot>
  <view xsize="80" ysize="20">
    <viewport name="drive" xpos="0" ypos="0" xsize="80" ysize="18">
      <widget handler="widgetAutonomy"><event key="e"/></widget>
    </viewport>
  </view>
</rune>
"""


class Robot:
    """Central, the desk, a module that keeps others out, and consoles that are looked after."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._stack, self._folder = stack, folder
        self.central = stack.enter_context(closing(Central([f"ipc://{folder}/central"])))
        self.client = Client("robomon", self.central.endpoints[0])
        self.desk = ControlService(self.client, self.central.peer_of)
        self.gate = ControlGate(self.client)
        self.heard: dict[int, list[int]] = {}
        self.client.subscribe(
            CONSOLE_HEARTBEAT,
            lambda beat, how: self.heard.setdefault(how.publisher, []).append(beat.holds),
        )
        self.client.subscribe(
            AUTONOMY_COMMAND, lambda _, how: self.gate.admits(AUTONOMY_COMMAND, how)
        )
        self.attended: list[RobotLink] = []
        self._done = threading.Event()
        thread = threading.Thread(target=self._serve, daemon=True)
        thread.start()
        stack.callback(thread.join)
        stack.callback(self._done.set)

    def _serve(self) -> None:
        while not self._done.is_set():
            self.client.listen(0.02)
            for link in self.attended:
                link.attend()
        self.client.close()

    def console(self, name: str) -> RobotLink:
        """A linked console, whose robot has another name there, as both are of one process."""
        path = self._folder / "layout.xml"
        path.write_text(LAYOUT.format(hub=self.central.endpoints[0]))
        (spec,) = open_layout(path).robots
        link = RobotLink(dataclasses.replace(spec, name=name), operator=name)
        link.start()
        self._stack.enter_context(closing(link))
        self.attended.append(link)
        until(lambda: standing(link.state) is not Standing.UNKNOWN, 10.0)
        return link


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    with ExitStack() as stack:
        yield Robot(tmp_path, stack)


def wait(link: RobotLink, stands: Standing) -> None:
    until(lambda: standing(link.state) is stands, 10.0, lambda: str(control_of(link.state)))


def test_two_consoles_take_ask_grant_and_release(robot: Robot) -> None:
    alice, bob = robot.console("alice"), robot.console("bob")
    assert standing(alice.state) is standing(bob.state) is Standing.FREE
    alice.control(ControlAction.TAKE)
    wait(alice, Standing.MINE)
    wait(bob, Standing.OTHERS)
    assert len(bob.state.link.owned_since) == len("12:03")
    bob.control(ControlAction.ASK)
    until(lambda: asks(bob.state), 10.0)
    alice.control(ControlAction.GRANT)
    wait(alice, Standing.OTHERS)
    wait(bob, Standing.MINE)
    bob.control(ControlAction.RELEASE)
    wait(alice, Standing.FREE)
    wait(bob, Standing.FREE)
    assert alice.state.link.owned_since == ""


def test_what_is_refused_is_told_to_who_sent_it_alone(robot: Robot) -> None:
    alice, bob = robot.console("alice"), robot.console("bob")
    alice.control(ControlAction.TAKE)
    wait(bob, Standing.OTHERS)
    bob.control(ControlAction.TAKE)
    until(lambda: bob.state.link.refusal == "alice has control; ask for it", 10.0)
    bob.send(AUTONOMY_COMMAND, AutonomyCommand())
    until(lambda: bob.state.link.refusal == "autonomy command refused: alice has control", 10.0)
    assert bob.state.link.refusal_count == 2
    assert alice.state.link.refusal_count == 0


def test_console_says_five_times_a_second_whether_it_has_control(robot: Robot) -> None:
    alice = robot.console("alice")
    beats = robot.heard.setdefault(alice.state.link.number, [])
    until(lambda: len(beats) > 2, 10.0)
    assert set(beats) == {0}
    alice.control(ControlAction.TAKE)
    until(lambda: beats[-3:] == [1, 1, 1], 10.0)


def test_console_that_nobody_looks_after_falls_silent_and_loses_control(robot: Robot) -> None:
    alice, bob = robot.console("alice"), robot.console("bob")
    alice.control(ControlAction.TAKE)
    wait(bob, Standing.OTHERS)
    robot.attended.remove(alice)
    wait(bob, Standing.FREE)
    wait(alice, Standing.FREE)


def test_console_that_closes_gives_up_control_at_once(robot: Robot) -> None:
    alice, bob = robot.console("alice"), robot.console("bob")
    alice.control(ControlAction.TAKE)
    wait(bob, Standing.OTHERS)
    robot.attended.remove(alice)
    alice.close()
    wait(bob, Standing.FREE)
    control = control_of(bob.state)
    assert control is not None
    assert control.why == "the console of alice has left"


def test_robot_without_a_desk_is_commanded_as_ever_and_says_so_when_asked(tmp_path: Path) -> None:
    path = tmp_path / "layout.xml"
    with closing(Central([f"ipc://{tmp_path}/central"])) as central:
        path.write_text(LAYOUT.format(hub=central.endpoints[0]))
        (spec,) = open_layout(path).robots
        link = RobotLink(spec)
        link.start()
        with closing(link):
            until(lambda: link.state.link.number, 10.0)
            assert standing(link.state) is Standing.UNKNOWN
            link.control(ControlAction.TAKE, by_driving=True)
            link.control(ControlAction.TAKE)
            until(lambda: "everybody commands it" in link.state.link.refusal, 10.0)
            assert link.state.link.refusal_count == 1


def test_observer_says_and_asks_nothing(tmp_path: Path) -> None:
    keyring = Keyring(tmp_path / "keys")
    keys = keyring.make("watcher", Role.OBSERVE)
    gateway = curve_gateway("tcp://127.0.0.1:0", keyring)
    heard: list[object] = []
    with closing(Central([f"ipc://{tmp_path}/c"], gateways=[gateway])) as central:
        path = tmp_path / "layout.xml"
        path.write_text(LAYOUT.format(hub=central.endpoints[1]))
        (spec,) = open_layout(path).robots
        with closing(Client("desk", central.endpoints[0])) as desk:
            desk.subscribe(CONSOLE_HEARTBEAT, lambda beat, _: heard.append(beat))
            desk.wait_connected(5.0)
            link = RobotLink(spec, keys=keys)
            link.start()
            with closing(link):
                until(lambda: link.state.link.number, 10.0, meanwhile=lambda: desk.listen(0.01))
                link.attend()
                link.control(ControlAction.TAKE)
                count = link.state.link.messages_per_s
                second: Callable[[], bool] = lambda: link.state.link.messages_per_s != count  # noqa: E731
                until(second, 10.0, meanwhile=lambda: (link.attend(), desk.listen(0.01)))
    assert heard == []
    assert link.state.link.refusal_count == 0
