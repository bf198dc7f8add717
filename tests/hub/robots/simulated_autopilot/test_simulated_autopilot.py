"""A simulated autopilot answers stations as the recorded ones did."""

import pytest

from tests.support.mavlink_numbers import GUIDED, HOLD
from tests.support.simulated_station import NEUTRAL, World, velocity

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


def driving_rover(**settings):
    world = World("rover", settings=settings)
    station = world.station()
    station.stream(NEUTRAL["rover"])
    world.wait(2.0)
    assert station.mode(GUIDED) == ACCEPTED
    assert station.arm() == ACCEPTED
    station.stream(NEUTRAL["rover"], velocity(1.0))
    world.wait(3.0)
    assert world.motion.state.ahead == pytest.approx(1.0, abs=0.02)
    return world, station


def test_streams_are_those_of_one_link_and_end_with_a_restart():
    world = World("rover", settings={"SIM_RC_FAIL": 1})
    one, other = world.station(), world.station(254)
    world.wait(2.0)
    assert one.rate("ATTITUDE", 20) == ACCEPTED
    assert one.rate("ATTITUDE", 50) == DENIED
    one.frames.clear()
    other.frames.clear()
    world.wait(2.0)
    assert len(one.of("ATTITUDE")) == pytest.approx(40, abs=1)
    assert len(other.of("ATTITUDE")) == 2
    assert one.command(246, 1) == ACCEPTED
    world.wait(1.5)
    one.frames.clear()
    world.wait(2.0)
    assert len(one.of("ATTITUDE")) == 2
    assert one.of("ATTITUDE")[0]["time_boot_ms"] < 2500


def test_a_rover_without_a_receiver_arms_only_with_a_stick_stream():
    world = World("rover", settings={"SIM_RC_FAIL": 1})
    station = world.station()
    world.wait(3.0)
    assert station.mode(GUIDED) == ACCEPTED
    assert station.arm() == FAILED
    assert "Arm: Radio failsafe on" in station.texts()
    station.stream(NEUTRAL["rover"])
    world.wait(0.2)
    assert station.arm() == ACCEPTED
    world.wait(1.0)
    assert station.beat()["base_mode"] == 137


@pytest.mark.parametrize(
    ("settings", "slows", "holds"),
    [
        ({"SIM_RC_FAIL": 1, "FS_TIMEOUT": 0.1}, 0.77, True),
        ({"SIM_RC_FAIL": 1}, 2.2, True),
        ({}, 3.25, False),
        ({"FS_GCS_ENABLE": 1}, 3.25, True),
        ({"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 1.2, "FS_TIMEOUT": 0.1}, 1.4, True),
    ],
)
def test_a_silent_station_stops_a_rover_after_the_measured_time(settings, slows, holds):
    world, station = driving_rover(**settings)
    station.alive = False
    station.stream()
    cut = world.now
    while world.motion.state.ahead > 0.9:
        world.wait(0.02)
        assert world.now < cut + 10.0
    assert world.now - cut == pytest.approx(slows, rel=0.1)
    world.wait(8.0)
    assert abs(world.motion.state.ahead) < 0.01
    assert (station.beat()["custom_mode"] == HOLD) is holds
    # The link comes back with a deflected stick: HOLD stands until a mode is asked for.
    station.alive = True
    station.stream(NEUTRAL["rover"], velocity(1.0))
    world.wait(3.0)
    assert (world.motion.state.ahead < 0.01) is holds
