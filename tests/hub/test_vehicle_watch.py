"""Whether a vehicle follows velocities, by what its driver reports."""

from __future__ import annotations

import time
from random import Random

from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase, AutopilotState
from hub.gcm.vehicle import VEHICLE_STATE, Arming, VehicleState
from hub.vehicle_watch import VehicleWatch
from tests.hub.modules.extremes_bus import ExtremesBus


class Driver:
    """A driver, and the watch that hears it."""

    def __init__(self) -> None:
        bus = ExtremesBus(time.monotonic, Random(1))
        self.handlers = bus.handlers
        self.lost: list[str] = []
        self.watch = VehicleWatch(bus, self.lost.append)  # type: ignore[arg-type]

    def motors(self, arming: Arming) -> None:
        for take in self.handlers[VEHICLE_STATE.name]:
            take(VehicleState(arming=arming))

    def autopilot(self, why: str, phase: AutopilotPhase = AutopilotPhase.DRIVING) -> None:
        for take in self.handlers[AUTOPILOT_STATE.name]:
            take(AutopilotState(phase=phase, why=why))


def test_motors_that_are_off_follow_nothing() -> None:
    driver = Driver()
    for arming in (Arming.NONE, Arming.ARMED):
        driver.motors(arming)
        assert not driver.watch.why
    driver.motors(Arming.DISARMED)
    driver.motors(Arming.DISARMED)
    assert driver.lost == ["its motors are off: arm it"], "it is reported once"
    driver.motors(Arming.ARMED)
    assert not driver.watch.why


def test_an_autopilot_gives_its_own_reason() -> None:
    driver = Driver()
    driver.autopilot("")
    driver.motors(Arming.ARMED)
    assert not driver.lost
    driver.autopilot("it is in hold, asked for here", AutopilotPhase.ELSEWHERE)
    driver.motors(Arming.DISARMED)
    driver.autopilot("it is disarmed: arm it", AutopilotPhase.DISARMED)
    assert driver.watch.why == "it is disarmed: arm it"
    driver.autopilot("release the stick first")
    assert driver.lost == ["it is in hold, asked for here"], "it did not follow between"
    driver.autopilot("")
    driver.autopilot("release the stick first")
    assert driver.lost[1:] == ["release the stick first"]
