"""Axes and signs, both ways, against recorded sessions of simulated vehicles.

What a station sent is compared with what Rune sends for the motion that the vehicle then had;
telemetry is compared with the simulator's own state of the same moment.
"""

import gzip
import json
import math
from pathlib import Path

import pytest

from hub.robots.mavlink.profiles.ardublimp import BLIMP
from hub.robots.mavlink.profiles.ardurover import ROVER
from hub.robots.mavlink.profiles.ardusub import SUB
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from hub.robots.simulated_autopilot.parameters import default_parameters

DATA = Path(__file__).parents[3] / "data" / "mavlink"
SUB_PARAMETERS = {"PILOT_SPEED": 200.0, "PILOT_SPEED_UP": 100.0, "ACRO_YAW_P": 3.375}
BLIMP_PARAMETERS = {"MAX_VEL_XY": 0.2, "MAX_VEL_Z": 0.2, "MAX_VEL_YAW": 0.4}
CASES = [
    (ROVER, {}, 43.23, 0.05),
    (ROVER, {}, 51.221, 0.05),
    (ROVER, {}, 60.24, 0.05),
    (ROVER, {}, 67.24, 0.05),
    (SUB, SUB_PARAMETERS, 62.427, 30.0),
    (SUB, SUB_PARAMETERS, 71.432, 30.0),
    (SUB, SUB_PARAMETERS, 80.433, 30.0),
    (SUB, SUB_PARAMETERS, 87.427, 30.0),
    (BLIMP, BLIMP_PARAMETERS, 43.728, 40.0),
    (BLIMP, BLIMP_PARAMETERS, 63.733, 40.0),
    (BLIMP, BLIMP_PARAMETERS, 79.733, 40.0),
]
FREEDOMS = ("x", "y", "z", "r", "vx", "yaw_rate", *(f"chan{place}_raw" for place in range(1, 5)))


def recorded(profile, began):
    """What was sent from a time on, and the mean motion of the last two seconds of it."""
    session = json.loads(gzip.decompress((DATA / f"{profile.name}.json.gz").read_bytes()))
    sent = next(
        stream for stream in session["streams"] if stream[0] == began and stream[2] != "HEARTBEAT"
    )
    _, ended, name, fields = sent
    rows = [row[1:5] for row in session["truth"] if max(began + 2.0, ended - 2.0) <= row[0] < ended]
    ahead, right, down, clockwise = (sum(column) / len(rows) for column in zip(*rows, strict=True))
    return name, fields, Setpoint(ahead=ahead, left=-right, up=-down, turn=-clockwise)


@pytest.mark.parametrize(
    ("profile", "parameters", "began", "near"),
    CASES,
    ids=[f"{case[0].name} at {case[2]:.0f} s" for case in CASES],
)
def test_the_motion_of_a_recorded_command_gives_that_command(profile, parameters, began, near):
    name, fields, motion = recorded(profile, began)
    parts = {part: getattr(motion, part) for part in ("ahead", "left", "up", "turn")}
    wanted = Setpoint(
        **{part: value if abs(value) > 0.05 else 0.0 for part, value in parts.items()}
    )
    sent = dict(profile.setpoint(wanted, parameters, 0.5))[name]
    for field in FREEDOMS:
        assert sent.get(field, 0) == pytest.approx(fields.get(field, 0), abs=near), field
    assert not wanted.neutral


def telemetry_of(case):
    """The telemetry of a set of frames that came together."""
    telemetry = Telemetry()
    for name in ("ATTITUDE", "LOCAL_POSITION_NED"):
        (frame,) = FrameParser().feed(FramePacker(1, 1).pack(name, **case[name]))
        telemetry.take(frame, 1.0)
    return telemetry


@pytest.mark.parametrize("name", ["rover", "sub", "blimp"])
def test_telemetry_has_the_axes_and_signs_of_the_simulators_own_state(name):
    cases = json.loads((DATA / f"signs_{name}.json").read_text())
    assert len(cases) >= 9
    for case in cases:
        read, truth = telemetry_of(case), case["SIM_STATE"]
        assert (read.east, read.north) == pytest.approx((truth["ve"], truth["vn"]), abs=0.1)
        assert read.climb == pytest.approx(-truth["vd"], abs=0.16)
        assert read.z == pytest.approx(truth["alt"], abs=0.2)
        assert read.rates.z == pytest.approx(-truth["zgyro"], abs=0.02)
        assert (read.roll, read.pitch) == pytest.approx((truth["roll"], -truth["pitch"]), abs=0.01)
        off = math.remainder(read.yaw - (math.pi / 2 - truth["yaw"]), math.tau)
        assert abs(off) < 0.04
        ahead = truth["vn"] * math.cos(truth["yaw"]) + truth["ve"] * math.sin(truth["yaw"])
        right = truth["ve"] * math.cos(truth["yaw"]) - truth["vn"] * math.sin(truth["yaw"])
        assert read.velocity.linear.x == pytest.approx(ahead, abs=0.1)
        assert read.velocity.linear.y == pytest.approx(-right, abs=0.1)


def test_a_vehicle_that_goes_north_faces_y_and_its_place_grows_along_y():
    case = {
        "ATTITUDE": {"yaw": 0.0, "pitch": 0.1, "roll": 0.2, "yawspeed": 0.3},
        "LOCAL_POSITION_NED": {"x": 3.0, "y": 4.0, "z": -5.0, "vx": 1.0},
    }
    read = telemetry_of(case)
    assert (read.x, read.y, read.z) == (4.0, 3.0, 5.0)
    assert read.yaw == pytest.approx(math.pi / 2)
    assert (read.roll, read.pitch) == pytest.approx((0.2, -0.1))
    assert read.velocity.linear.x == pytest.approx(1.0)
    assert read.velocity.angular.z == pytest.approx(-0.3)


@pytest.mark.parametrize("profile", [ROVER, SUB, BLIMP], ids=lambda each: each.name)
def test_all_parameters_that_are_read_are_there(profile):
    """Adopting calls the others missing, and asks for each of them four times."""
    assert set(profile.parameters) <= default_parameters(profile.name).keys()
