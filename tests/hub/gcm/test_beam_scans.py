"""Ranges of any sensors: what is new, where the robot was, and what is left out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.beam_scans import ATTITUDE_S, LARGEST_TILT, TILTED_REACH, BeamScan, ScanReader
from hub.gcm.beams import beams_of
from hub.gcm.body import RobotBody
from hub.gcm.imu import Imu
from hub.gcm.orientation import rotation
from hub.gcm.ranges import RangeReadings, scan_of
from hub.pose import Pose
from tests.hub.modules.navigation.bodies import HALF_WIDTH, LONG
from tests.support.messages import drive_state

NAMES = [group.name for group in LONG.ranges]


def readings(ranges: dict[str, float], stamps: dict[str, float] | float = 5.0) -> RangeReadings:
    """Each group measures this range with all its beams; the others measure nothing."""
    return RangeReadings(
        scans=tuple(
            scan_of(
                group,
                np.full(group.beams, ranges.get(group.name, math.inf), np.float32),
                stamps if isinstance(stamps, float) else stamps[group.name],
            )
            for group in LONG.ranges
        )
    )


def reader() -> ScanReader:
    """It stands at the origin."""
    made = ScanReader(LONG)
    made.moved(drive_state(), 1.0)
    return made


def read(made: ScanReader, said: RangeReadings, measured: float = 1.0) -> BeamScan:
    scan = made.read(said, measured)
    assert scan is not None
    return scan


def fresh(made: ScanReader, scan: BeamScan) -> set[str]:
    return {name for name, place in made.beams.groups.items() if scan.fresh[place].any()}


def test_a_group_is_new_when_its_stamp_has_changed() -> None:
    made, stamps = reader(), dict.fromkeys(NAMES, 5.0)
    assert fresh(made, read(made, readings({}, stamps))) == set(NAMES) - {"floor"}
    assert made.read(readings({}, stamps), 1.1) is None
    assert fresh(made, read(made, readings({}, stamps | {"rear": 5.1}), 1.2)) == {"rear"}


def test_scans_without_a_clock_are_always_new() -> None:
    made = reader()
    for _ in range(2):
        assert "laser" in fresh(made, read(made, readings({}, 0.0)))


def test_the_pose_is_that_of_the_measurement() -> None:
    made = reader()
    made.moved(drive_state(x=0.2, theta=0.4), 1.1)
    assert read(made, readings({}), 1.05).pose == Pose(
        x=pytest.approx(0.1), y=0.0, theta=pytest.approx(0.2)
    )
    assert made.read(readings({}, 6.0), 3.0) is None, "the robot's pose is not known"


def test_of_a_tilted_robot_only_near_ranges_are_used() -> None:
    made = reader()
    made.tilted(Imu.of(roll=0.0, pitch=-1.2 * LARGEST_TILT), 1.0)
    scan = read(made, readings({"left": 0.4, "rear": 1.1 * TILTED_REACH}))
    assert scan.tilted
    assert fresh(made, scan) == {"left"}
    assert made.tilt == pytest.approx(1.2 * LARGEST_TILT)
    made.tilted(Imu.of(roll=0.9 * LARGEST_TILT, pitch=0.0), 1.0)
    scan = read(made, readings({"rear": 1.1 * TILTED_REACH}, 6.0))
    assert not scan.tilted
    assert "rear" in fresh(made, scan)
    assert made.tilt == 0.0


def test_a_range_is_not_used_where_the_beam_meets_the_floor() -> None:
    """Nose down by 4 degrees the laser, 0.3 m up and 0.3 m ahead, meets the floor at 4 m."""
    pitch = math.radians(4.0)
    floor = (0.3 * math.cos(pitch) - 0.3 * math.sin(pitch)) / math.sin(pitch)
    ahead = 90  # the laser looks to the left and counts clockwise
    for away, used in ((0.7 * floor, True), (floor, False)):
        made = reader()
        made.tilted(Imu.of(roll=0.0, pitch=pitch), 1.0)
        scan = read(made, readings({"laser": away}))
        place = made.beams.groups["laser"]
        beam = place.start + 180 + ahead
        assert abs(math.remainder(made.beams.bearing[beam], math.tau)) < 0.02
        assert bool(scan.fresh[beam]) is used
        assert scan.fresh[beam - 180], "behind it looks up"


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
def test_the_way_to_the_floor_ends_on_it(roll: float, pitch: float) -> None:
    beams = beams_of(LONG)
    reach = beams.to_floor(roll, pitch)
    met = np.isfinite(reach) & (reach > 0.0)
    turn = rotation(roll, pitch, 0.0)
    flat = np.cos(beams.elevation)
    rays = np.stack(
        (flat * np.cos(beams.bearing), flat * np.sin(beams.bearing), np.sin(beams.elevation))
    )
    ends = turn @ (np.stack((beams.x, beams.y, beams.z)) + rays * np.where(met, reach, 0.0))
    assert np.abs(ends[2][met]).max(initial=0.0) < 1e-6
    assert ((turn @ rays)[2][~np.isfinite(reach)] > -1e-6).all()


def test_an_old_attitude_is_not_known() -> None:
    made = reader()
    made.tilted(Imu.of(roll=1.0, pitch=0.0), 0.9 - ATTITUDE_S)
    assert made.read(readings({}), 1.0) is not None


def test_beams_to_the_floor_own_parts_and_zeros_are_unknown() -> None:
    made = reader()
    scan = read(made, readings({"floor": 0.4, "laser": HALF_WIDTH / 2.0, "rear": 0.0}))
    for name in ("floor", "laser", "rear"):
        assert np.isnan(scan.ranges[made.beams.groups[name]]).all()
        assert not scan.fresh[made.beams.groups[name]].any()
    assert np.isinf(scan.ranges[made.beams.groups["left"]]).all()


@pytest.mark.parametrize("said", [0.06, 0.02, -math.inf])
def test_what_is_nearer_than_a_sensor_can_measure_is_no_own_part(said: float) -> None:
    made = reader()
    scan = read(made, readings({"laser": said, "left": said}))
    laser, left = (made.beams.groups[name] for name in ("laser", "left"))
    assert (scan.ranges[laser] == 0.0).all()
    assert scan.fresh[laser].all()
    assert scan.ranges[left] == pytest.approx([0.06 if said == 0.06 else 0.0])


def test_a_body_without_sensors_has_no_scans() -> None:
    made = ScanReader(RobotBody(name="a", kind="b", radius=0.2))
    made.moved(drive_state(), 1.0)
    assert made.read(readings({"laser": 1.0}), 1.0) is None
    assert made.read(RangeReadings(scans=()), 1.0) is None
