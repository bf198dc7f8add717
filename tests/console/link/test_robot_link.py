"""The link to a robot's hub, against a real central: what the operator learns of it."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm import navigation
from hub.gcm.geometry import TwistStamped
from hub.gcm.supervision import CAPABILITY_WANTS, CapabilityWants
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from rune_tui.layout.spec import CapabilitySpec, LayoutSpec
from rune_tui.link.robot_link import RobotLink
from rune_tui.link.way import Way
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.states import rendered
from tests.support.messages import robot_state
from tests.support.waiting import until

LAYOUT = """<rune run="1">
  <robot name="magellan" hub="{hub}">
    <capability name="VIS_VID" interval_ms="66"/>
    <capability name="NAV_STATE"/>
    <capability name="NAV_MOVE"/>
  </robot>
  <view xsize="120" ysize="20">
    <viewport name="camera" robot="magellan" xpos="0" ypos="0" xsize="120" ysize="18">
      <visualizer function="visualizeCameraImage" message="GCM_Common_Image"/>
    </viewport>
    <viewport name="status" robot="magellan" xpos="0" ypos="18" xsize="120" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
    </viewport>
  </view>
</rune>
"""
WATCHES = "OBSERVER: this key may watch and stop, not drive"


class Desk:
    """A hub without a robot, and consoles at it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._keyring = Keyring(folder / "keys")
        gateway = curve_gateway("tcp://127.0.0.1:0", self._keyring)
        self.central = Central([f"ipc://{folder}/central"], gateways=[gateway])
        self._opened = ExitStack()
        self._opened.callback(self.central.close)

    def layout(self, endpoint: str) -> LayoutSpec:
        path = self._folder / "layout.xml"
        path.write_text(LAYOUT.format(hub=endpoint))
        return open_layout(path)

    def link(self, role: Role | None, way: Way | None = None) -> RobotLink:
        """A started link: with a key of this role, or on the hub's machine without one."""
        endpoint = self.central.endpoints[1 if role else 0]
        keys = self._keyring.make(f"one-{role.value}", role) if role else None
        (robot,) = self.layout(endpoint).robots
        link = RobotLink(robot, keys=keys, way=way)
        link.start()
        self._opened.enter_context(closing(link))
        return link

    def screen(self, link: RobotLink) -> str:
        """What stands on the screen, rows one after the other."""
        view = View(self.layout(self.central.endpoints[0]))
        view.resize(120, 10)
        cells = rendered(view, {"magellan": link.state}, ConsoleState(now=time.monotonic()))
        assert cells is not None
        return "\n".join("".join(chr(g or 32) for g in row) for row in cells.glyphs.tolist())

    def close(self) -> None:
        self._opened.close()


class FakeWay:
    """The way to a robot of a fleet."""

    endpoint, shown, trouble = "", "fleet rune", ""

    def __init__(self, *refusals: str, may_command: bool = True) -> None:
        self.may_command, self._refusals = may_command, list(refusals)

    def next_notice(self) -> str:
        return self._refusals.pop(0) if self._refusals else ""


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with closing(Desk(tmp_path)) as opened:
        yield opened


def _connected(link: RobotLink) -> None:
    until(lambda: link.state.link.phase is LinkPhase.CONNECTED, 10.0)


def test_an_observer_is_told_so_before_and_after_it_presses_keys(desk: Desk) -> None:
    link = desk.link(Role.OBSERVE)
    assert WATCHES in desk.screen(link)
    _connected(link)
    assert WATCHES in desk.screen(link)
    came: list[object] = []
    with closing(Client("navigation", desk.central.endpoints[0])) as module:
        for definition in (navigation.STOP, navigation.VELOCITY_COMMAND):
            module.subscribe(definition, lambda value, _: came.append(value))
        module.wait_subscribed(10.0)
        link.send(navigation.VELOCITY_COMMAND, TwistStamped.planar(0.1, 0.0))
        link.send(navigation.STOP, navigation.Stop(reason="the test"))
        until(lambda: came, 10.0, meanwhile=lambda: module.listen(0.01))
    assert came == [navigation.Stop(reason="the test")]
    assert WATCHES in desk.screen(link)


@pytest.mark.parametrize("role", [None, Role.OPERATE, Role.MODULE])
def test_who_may_drive_reads_nothing_of_keys(desk: Desk, role: Role | None) -> None:
    link = desk.link(role)
    _connected(link)
    assert "OBSERVER" not in desk.screen(link)


def test_refusals_on_the_way_are_notices_and_a_role_that_may_not_drive_only_watches(
    desk: Desk,
) -> None:
    link = desk.link(None, FakeWay("the command is old", "the robot is full"))
    until(lambda: link.state.link.refusal_count == 2, 10.0)
    assert link.state.link.refusal == "the robot is full"
    assert WATCHES not in desk.screen(link)
    assert WATCHES in desk.screen(desk.link(None, FakeWay(may_command=False)))


def test_a_robot_without_pictures_is_not_waited_for_in_silence(desk: Desk) -> None:
    link = desk.link(None)
    link.want_pictures({"": PictureNeed(size=(64, 48))})
    until(lambda: "the robot sends no pictures" in desk.screen(link), 10.0)


@pytest.mark.parametrize("role", [None, Role.OPERATE])
def test_what_the_layout_wants_is_wanted_of_the_robot(desk: Desk, role: Role | None) -> None:
    wants: list[CapabilityWants] = []
    with closing(Client("daemon", desk.central.endpoints[0])) as daemon:
        daemon.subscribe(CAPABILITY_WANTS, lambda value, _: wants.append(value))
        daemon.wait_connected(5.0)
        _connected(desk.link(role))
        until(lambda: wants, 5.0, meanwhile=lambda: daemon.listen(0.01))
    assert wants[0].capabilities == "NAV_MOVE NAV_STATE VIS_VID"
    assert wants[0].holder.startswith("rune-")


def test_keep_alives_come_as_often_as_the_layout_says_and_hold_for_longer(desk: Desk) -> None:
    wants: list[tuple[float, CapabilityWants]] = []
    (spec,) = desk.layout(desk.central.endpoints[0]).robots
    often = CapabilitySpec(name="CON_REAL", interval_s=1.0)
    link = desk.link(None)
    with closing(Client("daemon", desk.central.endpoints[0])) as daemon:
        daemon.subscribe(
            CAPABILITY_WANTS, lambda value, reception: wants.append((reception.measured, value))
        )
        daemon.wait_connected(5.0)
        _connected(link)
        until(lambda: wants, 20.0, meanwhile=lambda: daemon.listen(0.01))
        assert wants[0][1].lease_s == 15.0
        link.follow(dataclasses.replace(spec, capabilities=(*spec.capabilities, often)))
        until(
            lambda: sum(want.lease_s == 3.0 for _, want in wants) >= 3,
            20.0,
            meanwhile=lambda: daemon.listen(0.01),
        )
    assert "CON_REAL" in wants[-1][1].capabilities


def test_states_that_come_sooner_than_the_layout_wants_are_left_out(desk: Desk) -> None:
    (spec,) = desk.layout(desk.central.endpoints[0]).robots
    (state,) = [each for each in spec.capabilities if each.name == "NAV_STATE"]
    seldom = dataclasses.replace(state, interval_s=1000.0)
    others = tuple(each for each in spec.capabilities if each is not state)
    link = desk.link(None)
    _connected(link)
    with closing(Client("navigation", desk.central.endpoints[0])) as navigation_module:
        tell = functools.partial(navigation_module.publish, navigation.ROBOT_STATE)

        def told(x: float) -> bool:
            tell(robot_state(x=x))
            navigation_module.listen(0.01)
            return link.state.navigation is not None and link.state.navigation.value.x == x

        until(lambda: told(1.0), 10.0)
        link.follow(dataclasses.replace(spec, capabilities=(*others, seldom)))
        until(lambda: link.spec.capabilities[-1] is seldom, 10.0)
        before = link.state.link.messages_per_s
        for x in range(20):
            tell(robot_state(x=float(x)))
            navigation_module.listen(0.01)
        until(lambda: link.state.link.messages_per_s != before, 10.0)
        assert link.state.navigation is not None
        assert link.state.navigation.value.x == 1.0


def test_a_state_of_the_same_moment_that_says_something_else_is_no_repetition(desk: Desk) -> None:
    """Navigation reports a silent driver with the time of its last measurement."""
    link = desk.link(None)
    _connected(link)
    with closing(Client("navigation", desk.central.endpoints[0])) as navigation_module:
        measured = time.monotonic()

        def has_arrived(motion: navigation.MotionState) -> bool:
            state = robot_state(motion=motion)
            navigation_module.publish(navigation.ROBOT_STATE, state, measured=measured)
            navigation_module.listen(0.01)
            known = link.state.navigation
            return known is not None and known.value.motion is motion

        until(lambda: has_arrived(navigation.MotionState.MOVING), 10.0)
        until(lambda: has_arrived(navigation.MotionState.NO_DRIVER), 10.0)


def test_a_fault_in_taking_a_message_is_told_once_and_the_link_goes_on(
    desk: Desk, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    link = desk.link(None)
    _connected(link)
    with closing(Client("navigation", desk.central.endpoints[0])) as navigation_module:

        def came(what: Callable[[], bool]) -> bool:
            navigation_module.publish(navigation.ROBOT_STATE, robot_state(x=1.0))
            navigation_module.listen(0.01)
            return what()

        faults: list[None] = []

        def broken(*_: object) -> None:
            faults.append(None)
            text = "a fault of ours"
            raise ValueError(text)

        with monkeypatch.context() as patch:
            patch.setattr(link, "received", broken)
            until(lambda: came(lambda: len(faults) > 3), 10.0)
        until(lambda: came(lambda: link.state.navigation is not None), 10.0)
    assert link.state.link.refusal == "a message could not be taken; the log says why"
    assert link.state.link.refusal_count == 1
    assert len([each for each in caplog.records if each.exc_info]) == 1
