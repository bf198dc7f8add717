"""The light of a camera, and orders that come late."""

from __future__ import annotations

import math

import pytest

from hub.gcm.vehicle import VEHICLE_COMMAND, VehicleCommand, VehicleOrder
from hub.gcm.vision import CAMERA_STATE
from hub.modules.vision.__main__ import Vision
from tests.hub.modules.timed_bus import TimedBus
from tests.support.bodies import robot_of


class Bus(TimedBus):
    def respond_later(self, *_: object) -> None:
        """Nobody asks for pictures."""

    def post(self, *_: object) -> None: ...


def test_a_late_order_does_not_switch_a_light_on(monkeypatch: pytest.MonkeyPatch) -> None:
    bus = Bus(monkeypatch)
    robot = robot_of("magellan")
    vision = Vision(bus, robot)
    (name, *_) = (each.name for each in robot.body.lights if each.camera)
    lit = VehicleCommand(order=VehicleOrder.LIGHT, name=name, value=0.5)

    def shown(age: float) -> list[float]:
        bus.published.clear()
        bus.send(VEHICLE_COMMAND, lit, "operator", age=age)
        return [value.headlight for _, name, value in bus.published if name == CAMERA_STATE.name]

    for age in (1.0, math.inf):
        assert shown(age) == []
    assert shown(0.0) == [0.5]
    vision.finish()
