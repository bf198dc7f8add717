"""What stops a simulated Sub or blimp, and when, as measured; and what does not."""

import pytest

from tests.support.simulated_station import NEUTRAL, World, blimp_sticks, velocity

DEPTH_HOLD, POSITION_HOLD, SUB_GUIDED, SURFACE = 2, 16, 4, 9
BLIMP_VELOCITY, BLIMP_LOITER = 2, 3
SUB_AHEAD = ("MANUAL_CONTROL", {"target": 1, "x": 500, "z": 500})
BLIMP_AHEAD = blimp_sticks(c2=2000)
NO_RECEIVER = {"SIM_RC_FAIL": 1}


class Drive:
    """A vehicle that drives ahead."""

    def __init__(self, kind, mode, *messages, seconds=6.0, **settings):
        self.world = World(kind, settings=settings, depth=5.0 if kind == "sub" else 0.0)
        self.station = self.world.station()
        self.station.stream(NEUTRAL[kind])
        self.world.wait(2.0)
        assert self.station.mode(mode) == 0
        assert self.station.arm() == 0
        self.station.stream(*messages)
        self.world.wait(seconds)
        self.motion, self.vehicle = self.world.motion.state, self.world.autopilot.vehicle
        self.began = self.world.now
        self.speed = abs(self.motion.ahead)
        assert self.speed > 0.1

    def cut(self):
        """Send nothing any more; times count from the last message."""
        self.began = self.station.repeated_at
        self.station.alive = False
        self.station.stream()

    def until(self, condition, most=30.0):
        """Time until something holds [s]."""
        while not condition():
            self.world.wait(0.02)
            assert self.world.now - self.began < most
        return self.world.now - self.began

    def slows(self):
        return self.until(lambda: abs(self.motion.ahead) < 0.93 * self.speed)

    def rests(self):
        return self.until(lambda: abs(self.motion.ahead) < 0.05)


@pytest.mark.parametrize(
    ("mode", "settings", "slows", "rests"),
    [
        (POSITION_HOLD, {"FS_PILOT_INPUT": 1, "FS_PILOT_TIMEOUT": 0.5}, 0.65, 2.6),
        (DEPTH_HOLD, {"FS_PILOT_INPUT": 1, "FS_PILOT_TIMEOUT": 0.5}, 0.55, 4.4),
        (POSITION_HOLD, {"FS_PILOT_INPUT": 2}, 3.05, 6.9),
    ],
)
def test_a_silent_pilot_stops_a_sub_without_a_receiver(mode, settings, slows, rests):
    drive = Drive("sub", mode, SUB_AHEAD, **NO_RECEIVER, **settings)
    drive.cut()
    assert drive.slows() == pytest.approx(slows, abs=0.12)
    assert drive.rests() == pytest.approx(rests, rel=0.12)
    assert drive.vehicle.armed is (settings["FS_PILOT_INPUT"] == 1)
    assert "Lost manual control" in drive.station.texts()


def test_without_its_failsafes_a_sub_goes_on():
    drive = Drive("sub", DEPTH_HOLD, SUB_AHEAD, **NO_RECEIVER, FS_PILOT_INPUT=0, FS_GCS_ENABLE=0)
    drive.cut()
    drive.world.wait(12.0)
    assert drive.motion.ahead == pytest.approx(0.52, abs=0.02)


def test_a_sub_with_a_receiver_surfaces_then_obeys_deflected_sticks_again():
    settings = {"FS_GCS_ENABLE": 4, "FS_GCS_TIMEOUT": 2}
    drive = Drive("sub", POSITION_HOLD, SUB_AHEAD, **settings)
    drive.cut()
    surfaces = drive.until(lambda: drive.vehicle.mode == SURFACE)
    assert 2.0 < surfaces < 2.4
    drive.until(lambda: drive.vehicle.mode == DEPTH_HOLD)
    assert drive.vehicle.armed
    drive.world.wait(5.0)
    drive.station.alive = True
    drive.station.stream(SUB_AHEAD)
    drive.world.wait(2.0)
    assert drive.motion.ahead == pytest.approx(0.52, abs=0.03)


def test_a_sub_in_guided_is_disarmed_without_sticks():
    setpoint = velocity(0.3)
    drive = Drive("sub", SUB_GUIDED, setpoint, seconds=2.5, **NO_RECEIVER)
    assert drive.until(lambda: not drive.vehicle.armed) < 0.6
    drive = Drive("sub", SUB_GUIDED, setpoint, NEUTRAL["sub"], **NO_RECEIVER)
    assert drive.speed == pytest.approx(0.3, abs=0.01)
    drive.station.stream(NEUTRAL["sub"])
    assert drive.slows() == pytest.approx(3.1, abs=0.15)
    assert drive.vehicle.armed


@pytest.mark.parametrize(
    ("settings", "slows", "rests"),
    [({"RC_OVERRIDE_TIME": 3}, 3.25, 5.0), ({"RC_OVERRIDE_TIME": 0.5}, 0.7, 2.4)],
)
def test_a_blimp_with_a_receiver_brakes_when_the_override_expires(settings, slows, rests):
    drive = Drive("blimp", BLIMP_VELOCITY, BLIMP_AHEAD, **settings)
    drive.cut()
    assert drive.slows() == pytest.approx(slows, rel=0.1)
    assert drive.rests() == pytest.approx(rests, rel=0.12)
    assert drive.vehicle.armed
    drive.station.alive = True
    drive.station.stream(BLIMP_AHEAD)
    drive.world.wait(3.0)
    assert drive.motion.ahead > 0.15


@pytest.mark.parametrize(("lasting", "disarms"), [(3, 1.05), (0.5, 0.51)])
def test_a_blimp_without_a_receiver_is_disarmed_and_drifts(lasting, disarms):
    settings = {**NO_RECEIVER, "RC_OVERRIDE_TIME": lasting}
    drive = Drive("blimp", BLIMP_VELOCITY, BLIMP_AHEAD, **settings)
    drive.cut()
    took = drive.until(lambda: not drive.vehicle.armed)
    assert took == pytest.approx(disarms, abs=0.07)
    north = drive.motion.north
    drive.world.wait(12.0)
    assert 1.6 < drive.motion.north - north < 2.4
    assert drive.motion.ahead > 0.05
    assert "Radio Failsafe - Disarming" in drive.station.texts()
    drive.station.alive = True
    drive.station.stream(BLIMP_AHEAD)
    drive.world.wait(3.0)
    assert not drive.vehicle.armed


def test_a_blimp_without_a_receiver_and_failsafe_goes_on():
    drive = Drive("blimp", BLIMP_VELOCITY, BLIMP_AHEAD, **NO_RECEIVER, FS_THR_ENABLE=0)
    drive.cut()
    drive.world.wait(12.0)
    assert drive.motion.ahead > 0.2


def test_a_blimp_ignores_manual_control_but_counts_it_as_life():
    drive = Drive("blimp", BLIMP_VELOCITY, BLIMP_AHEAD, FS_GCS_ENABLE=1, FS_GCS_TIMEOUT=2)
    drive.station.alive = False
    drive.station.stream(("MANUAL_CONTROL", {"target": 1, "x": 1000}))
    drive.world.wait(8.0)
    assert abs(drive.motion.ahead) < 0.05
    assert drive.vehicle.armed
    drive.cut()
    assert drive.until(lambda: not drive.vehicle.armed) == pytest.approx(2.04, abs=0.1)


@pytest.mark.parametrize(
    ("settings", "goes_on"),
    [({"FS_THR_ENABLE": 0}, True), ({"FS_THR_ENABLE": 1}, False)],
)
def test_a_rover_with_sticks_and_no_receiver_stops_only_by_its_failsafe(settings, goes_on):
    ahead = ("MANUAL_CONTROL", {"target": 1, "z": 300})
    drive = Drive("rover", 1, ahead, **NO_RECEIVER, **settings)
    assert drive.speed == pytest.approx(1.02, rel=0.05)
    drive.cut()
    drive.world.wait(12.0)
    assert (drive.motion.ahead > 1.0) is goes_on
    drive.station.alive = True
    drive.station.stream(ahead)
    drive.world.wait(3.0)
    assert (drive.motion.ahead > 1.0) is goes_on


@pytest.mark.parametrize(("timeout", "failsafe", "holds"), [(5, 1.5, 6.6), (2, 0.5, 2.55)])
def test_a_silent_station_makes_a_rover_with_a_receiver_hold(timeout, failsafe, holds):
    settings = {"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": timeout, "FS_TIMEOUT": failsafe}
    drive = Drive("rover", 15, NEUTRAL["rover"], velocity(1.0), **settings)
    drive.cut()
    took = drive.until(lambda: drive.vehicle.mode == 4)
    assert took == pytest.approx(holds, abs=0.12)
    # The words are those of another failsafe: the receiver is sound.
    assert "Radio Failsafe" in drive.station.texts()


@pytest.mark.parametrize(("lasting", "slows", "rests"), [(3, 3.1, 3.8), (0.5, 0.6, 1.3)])
def test_sticks_of_a_rover_with_a_receiver_expire(lasting, slows, rests):
    ahead = ("MANUAL_CONTROL", {"target": 1, "z": 185})
    drive = Drive("rover", 1, ahead, RC_OVERRIDE_TIME=lasting)
    drive.cut()
    assert drive.slows() == pytest.approx(slows, abs=0.12)
    assert drive.rests() == pytest.approx(rests, rel=0.1)
