"""Orders that are no motion: who may give them, and when they end."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hub.errors import RobotFileError
from hub.gcm.autopilot import (
    MAVLINK_REQUEST,
    AutopilotState,
    AutopilotText,
    MavlinkFrames,
    MavlinkRequest,
)
from hub.gcm.body import HoldKind
from hub.gcm.control import CONTROL_REFUSAL, CONTROL_STATE, ControlState
from hub.gcm.diagnostics import DIAGNOSTICS, DiagnosticStatus, Severity
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.joints import JOINT_STATES, JointState
from hub.gcm.navigation import DRIVE_COMMAND, STOP, GroundTruth, Stop
from hub.gcm.vehicle import (
    VEHICLE_COMMAND,
    VEHICLE_STATE,
    Arming,
    HoldPhase,
    HoldState,
    LightState,
    VehicleCommand,
    VehicleOrder,
    VehicleState,
    too_late,
)
from hub.modules.driver import __main__ as driver
from hub.modules.driver.watchdog import SILENCE_S
from hub.robots.interfaces import Sensors
from hub.robots.robot_file import read_description
from tests.hub.modules.timed_bus import TimedBus

FILE = """
name = "arm"
kind = "simulated-wheels"
[body]
arming = "armed"
[[hold]]
kind = "depth"
[[light]]
name = "lamp"
[[joint]]
name = "front flippers"
lowest_deg = -60.0
highest_deg = 90.0
speed_deg = 57.29577951308232
"""
FORWARD = TwistStamped(twist=Twist.planar(0.4, 0.0))
NEUTRAL = TwistStamped(twist=Twist())
HOLD = VehicleCommand(order=VehicleOrder.HOLD, hold=HoldKind.DEPTH, value=1.5)
RELEASE = VehicleCommand(order=VehicleOrder.RELEASE, hold=HoldKind.DEPTH)
ARM, DISARM = (VehicleCommand(order=each) for each in (VehicleOrder.ARM, VehicleOrder.DISARM))
LAMP = VehicleCommand(order=VehicleOrder.LIGHT, name="lamp", value=0.5)


def turn(rate: float) -> VehicleCommand:
    return VehicleCommand(order=VehicleOrder.JOINT, name="front flippers", value=rate)


class Hardware:
    """A body with everything; it writes down what it is ordered to do."""

    def __init__(self) -> None:
        self.orders: list[tuple[Any, ...]] = []
        self.sensed = Sensors()
        self.velocity = 0.0

    def command(self, twist: Twist) -> None:
        self.velocity = twist.linear.x

    def advance(self, seconds: float) -> None: ...

    def sensors(self, stamp: float) -> Sensors:
        del stamp
        return self.sensed

    def ground_truth(self) -> GroundTruth | None: ...

    def hold(self, kind: HoldKind, target: float) -> None:
        self.orders.append(("hold", kind, target))

    def release(self, kind: HoldKind) -> None:
        self.orders.append(("release", kind))

    def set_light(self, name: str, brightness: float) -> None:
        self.orders.append(("light", name, brightness))

    def turn_joint(self, name: str, rate: float) -> None:
        self.orders.append(("joint", name, rate))

    def arm(self, *, armed: bool) -> None:
        self.orders.append(("arm", armed))


class Scene:
    """A driver with this body."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, folder: Path, hardware: Any = Hardware
    ) -> None:
        self.bus = TimedBus(monkeypatch)
        self.body = hardware()
        kind = SimpleNamespace(open_body=lambda _: self.body)
        monkeypatch.setattr(driver, "kind_of", lambda _: kind)
        path = folder / "arm.toml"
        path.write_text(FILE)
        robot, problems = read_description(path)
        assert not problems
        self.finish = driver.build(self.bus, robot)  # type: ignore[arg-type]
        self.started = list(self.body.orders)
        self.body.orders.clear()

    def order(self, command: VehicleCommand, sender: str = "operator") -> list[tuple[Any, ...]]:
        """What the body is ordered to do because of this command."""
        self.body.orders.clear()
        self.bus.send(VEHICLE_COMMAND, command, sender)
        return list(self.body.orders)

    def owned_by(self, name: str) -> None:
        owner = ControlState(owner=self.bus.number(name), operator=name)
        self.bus.send(CONTROL_STATE, owner, "robomon")

    def published(self, definition: Any, seconds: float) -> list[Any]:
        """The values that the driver publishes in the time that passes now."""
        self.bus.published.clear()
        self.bus.wait(seconds)
        return [value for _, name, value in self.bus.published if name == definition.name]


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Scene:
    return Scene(monkeypatch, tmp_path)


def test_the_body_gets_the_orders(scene: Scene) -> None:
    assert scene.started == [("arm", True)], "as the robot file says"
    assert scene.order(HOLD) == [("hold", HoldKind.DEPTH, 1.5)]
    assert scene.order(RELEASE) == [("release", HoldKind.DEPTH)]
    assert scene.order(LAMP) == [("light", "lamp", 0.5)]
    assert scene.order(replace(LAMP, value=7.0)) == [("light", "lamp", 1.0)]


def test_orders_for_parts_that_the_body_lacks_are_refused(scene: Scene) -> None:
    for lacking in (
        replace(HOLD, hold=HoldKind.HEIGHT),
        replace(LAMP, name="beacon"),
        replace(LAMP, value=math.nan),
        replace(turn(1.0), name="arm"),
    ):
        assert scene.order(lacking) == []


def test_only_the_owner_of_control_may_order_but_anybody_may_disarm(scene: Scene) -> None:
    scene.owned_by("anna")
    for command in (HOLD, RELEASE, ARM, LAMP, turn(0.0)):
        assert scene.order(command, "ben") == []
    assert CONTROL_REFUSAL.name in {name for _, name, _ in scene.bus.published}
    assert ("arm", False) in scene.order(DISARM, "ben")
    assert scene.order(HOLD, "anna") == [("hold", HoldKind.DEPTH, 1.5)]


class WithAutopilot(Hardware):
    """A body with modes, which writes down what is passed on."""

    def drive(self) -> None: ...

    def stay(self) -> None: ...

    def set_mode(self, name: str) -> None: ...

    def autopilot(self, stamp: float) -> AutopilotState:
        return AutopilotState(stamp=stamp)

    def take_texts(self) -> tuple[AutopilotText, ...]:
        return ()

    def take_frames(self, *, wanted: bool) -> tuple[MavlinkFrames, ...]:
        del wanted
        return ()

    def pass_on(self, frames: bytes) -> None:
        self.orders.append(("pass on", frames))


def test_frames_of_another_station_pass_while_no_other_has_control(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scene = Scene(monkeypatch, tmp_path, WithAutopilot)
    request = MavlinkRequest(data=np.frombuffer(b"frame", np.uint8))

    def passed(age: float = 0.0) -> bool:
        scene.body.orders.clear()
        scene.bus.send(MAVLINK_REQUEST, request, "forward", age=age)
        return ("pass on", b"frame") in scene.body.orders

    assert passed()
    assert not passed(age=1.0), "a link that froze delivers it late"
    scene.owned_by("anna")
    assert not passed()
    scene.owned_by("forward")
    assert passed()


def test_an_old_order_switches_nothing_on(scene: Scene) -> None:
    """A link that froze, or a computer that slept, delivers what an operator ordered before."""
    for age in (1.0, math.inf):
        for command in (HOLD, ARM, LAMP):
            scene.body.orders.clear()
            scene.bus.send(VEHICLE_COMMAND, command, "operator", age=age)
            assert scene.body.orders == []
        scene.bus.send(VEHICLE_COMMAND, DISARM, "operator", age=age)
        assert ("arm", False) in scene.body.orders


def test_an_order_that_is_refused_for_its_age_says_so() -> None:
    assert "ARM is refused: it is 3.2 s old" in too_late(VehicleOrder.ARM, 3.2)
    assert "ARM is refused: it is stamped ahead" in too_late(VehicleOrder.ARM, math.inf)
    assert too_late(VehicleOrder.ARM, 0.9) == too_late(VehicleOrder.DISARM, math.inf) == ""


def test_armed_motors_wait_for_a_neutral_command(scene: Scene) -> None:
    scene.bus.send(DRIVE_COMMAND, NEUTRAL, "navigation")
    scene.bus.send(DRIVE_COMMAND, FORWARD, "navigation")
    assert scene.body.velocity == 0.4
    for command, armed in ((DISARM, False), (ARM, True)):
        assert scene.order(command)[-1] == ("arm", armed)
        assert scene.body.velocity == 0.0
        scene.bus.send(DRIVE_COMMAND, FORWARD, "navigation")
        assert scene.body.velocity == 0.0, "a stick that is held moves nothing"
    scene.bus.send(DRIVE_COMMAND, NEUTRAL, "navigation")
    scene.bus.send(DRIVE_COMMAND, FORWARD, "navigation")
    assert scene.body.velocity == 0.4


def test_a_joint_turns_while_orders_are_fresh_and_from_zero_first(scene: Scene) -> None:
    assert scene.order(turn(0.5)) == [], "a key that was held before"
    assert scene.order(turn(0.0))[-1] == ("joint", "front flippers", 0.0)
    for _ in range(5):
        assert scene.order(turn(9.0)) == [("joint", "front flippers", pytest.approx(1.0))]
        scene.bus.wait(0.1)
    scene.body.orders.clear()
    scene.bus.wait(SILENCE_S - 0.1 - 1e-6)
    assert scene.body.orders == []
    scene.bus.wait(2e-6)
    assert scene.body.orders == [("joint", "front flippers", 0.0)]
    assert scene.order(turn(0.5)) == []
    assert scene.order(turn(math.nan))[-1] == ("joint", "front flippers", 0.0)


@pytest.mark.parametrize("event", ["stop", "owner", "end", "disarm"])
def test_joints_stop_with_everything_else(scene: Scene, event: str) -> None:
    scene.order(turn(0.0))
    scene.order(turn(0.5))
    scene.body.orders.clear()
    if event == "stop":
        scene.bus.send(STOP, Stop(), "ben")
    elif event == "owner":
        scene.owned_by("ben")
    elif event == "end":
        scene.finish()
    else:
        scene.order(DISARM)
    assert ("joint", "front flippers", 0.0) in scene.body.orders
    assert scene.order(turn(0.5)) == []


def test_a_stop_lets_a_hold_keep_the_place_of_now(scene: Scene) -> None:
    on = HoldState(kind=HoldKind.DEPTH, phase=HoldPhase.HOLDING, target=9.0)
    scene.body.sensed = Sensors(vehicle=VehicleState(holds=(on,)))
    scene.bus.wait(0.1)
    scene.bus.send(STOP, Stop(), "ben")
    ((order, kind, target),) = [each for each in scene.body.orders if each[0] == "hold"]
    assert (order, kind) == ("hold", HoldKind.DEPTH)
    assert math.isnan(target)


@pytest.mark.parametrize("event", ["stop", "owner"])
def test_a_hold_that_was_just_ordered_does_not_go_on_after_a_stop(scene: Scene, event: str) -> None:
    """The body has not reported since that it is on."""
    scene.order(HOLD)
    if event == "stop":
        scene.bus.send(STOP, Stop(), "ben")
    else:
        scene.owned_by("ben")
    order, kind, target = [each for each in scene.body.orders if each[0] == "hold"][-1]
    assert (order, kind) == ("hold", HoldKind.DEPTH)
    assert math.isnan(target)
    scene.order(HOLD, "ben")
    scene.order(RELEASE, "ben")
    scene.body.orders.clear()
    scene.bus.send(STOP, Stop(), "ben")
    assert [each for each in scene.body.orders if each[0] == "hold"] == []


class Stubborn(Hardware):
    """Its joints cannot be stopped at first."""

    def __init__(self) -> None:
        super().__init__()
        self.faults = 0

    def turn_joint(self, name: str, rate: float) -> None:
        if self.faults:
            self.faults -= 1
            text = "the port is busy"
            raise OSError(text)
        super().turn_joint(name, rate)


def test_a_joint_that_could_not_be_stopped_is_stopped_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scene = Scene(monkeypatch, tmp_path, Stubborn)
    scene.order(turn(0.0))
    scene.order(turn(0.5))
    scene.body.orders.clear()
    scene.body.faults = 2
    assert scene.bus.wait_with_faults(SILENCE_S + 0.2) == 2
    assert scene.body.orders == [("joint", "front flippers", 0.0)]


def test_the_motors_go_off_although_a_joint_cannot_be_stopped(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    scene = Scene(monkeypatch, tmp_path, Stubborn)
    scene.body.faults = 1
    with pytest.raises(OSError, match="the port is busy"):
        scene.order(DISARM)
    assert ("arm", False) in scene.body.orders


def test_a_hold_that_is_off_stays_off_after_a_stop(scene: Scene) -> None:
    scene.body.sensed = Sensors(vehicle=VehicleState(holds=(HoldState(kind=HoldKind.DEPTH),)))
    scene.bus.wait(0.1)
    scene.bus.send(STOP, Stop(), "ben")
    assert [each for each in scene.body.orders if each[0] == "hold"] == []


def test_states_are_published_slowly_and_at_each_change(scene: Scene) -> None:
    scene.bus.wait(1.0)
    assert len(scene.published(VEHICLE_STATE, 5.0)) == pytest.approx(10, abs=1)
    assert len(scene.published(DIAGNOSTICS, 5.0)) == pytest.approx(5, abs=1)
    leak = DiagnosticStatus(level=Severity.ERROR, name="leak", message="water in the hull")
    lamp = LightState(name="lamp", brightness=0.5)
    scene.body.sensed = Sensors(
        diagnostics=(leak,),
        vehicle=VehicleState(arming=Arming.DISARMED, lights=(lamp,)),
        joints=(JointState(name="front flippers", position=0.1),),
    )
    scene.bus.published.clear()
    scene.bus.wait(0.15)
    seen = {name: value for _, name, value in scene.bus.published}
    assert seen[VEHICLE_STATE.name].activity == "disarmed"
    assert seen[VEHICLE_STATE.name].lights == (lamp,)
    assert [each.name for each in seen[DIAGNOSTICS.name].status] == ["leak", "disarmed"]
    assert seen[JOINT_STATES.name].position_of("front flippers") == 0.1


def test_a_body_without_the_parts_of_its_robot_file_does_not_start(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for part in ("hold", "set_light", "turn_joint", "arm"):
        has = {name: value for name, value in vars(Hardware).items() if name != part}
        with pytest.raises(RobotFileError, match="has none"):
            Scene(monkeypatch, tmp_path, type("Less", (), has))
