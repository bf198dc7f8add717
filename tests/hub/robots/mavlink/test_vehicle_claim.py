"""One process of this machine has a vehicle: others send nothing to it, and say who has it."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.body import MavlinkBody
from hub.robots.mavlink.link.address import vehicle_address
from hub.robots.mavlink.link.sockets import UdpLink
from hub.robots.mavlink.link.vehicle_claim import VehicleClaim
from tests.hub.robots.mavlink.test_body import TICK_S, Scene, robot


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:7", "udp://:7", "/dev/rune-no-port"])
def test_a_vehicle_has_one_owner_until_that_ends(address: str) -> None:
    place = vehicle_address(address)
    with closing(VehicleClaim(place, 1)) as first, closing(VehicleClaim(place, 1)) as second:
        assert first.take()
        assert first.take()
        assert not second.take()
        assert second.owner() == f"process {os.getpid()} of this machine"
        with closing(VehicleClaim(place, 2)) as other:
            assert other.take(), "it is another vehicle"
        first.close()
        assert second.take()


def test_a_second_hub_sends_nothing_until_the_first_ends(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    with closing(scene):
        claim = VehicleClaim(vehicle_address(scene.vehicle.address), 1)
        assert claim.take()
        scene.body.advance(TICK_S)  # its first datagram shows the vehicle where it is
        scene.wait(2.0)
        scene.vehicle.received.clear()
        scene.wait(4.0)
        assert scene.vehicle.received == []
        assert scene.phase is AutopilotPhase.GONE
        words = f"process {os.getpid()} of this machine has this vehicle"
        assert words in scene.problems[0]
        assert words in scene.body.autopilot(0.0).why
        claim.close()
        scene.wait(6.0)
        assert scene.phase is AutopilotPhase.DISARMED


def test_a_udp_port_that_another_program_has(tmp_path: Path) -> None:
    with closing(UdpLink("127.0.0.1", 0, listen=True)) as first:
        first.read(100.0)
        described = robot(tmp_path, f"udp://:{first.port}")
        with closing(MavlinkBody(described)) as body:
            body.advance(TICK_S)
            (problem,) = [each.message for each in body.sensors(0.0).diagnostics]
    assert "another program of this machine, such as a hub or a ground station" in problem
