"""`rune-hub doctor` on the vehicle of a robot file, with one that answers over UDP."""

from __future__ import annotations

from pathlib import Path

from hub.inspection.doctor.autopilot_checks import autopilot
from hub.robots.robot_file import read_description
from tests.support.fake_vehicle import FakeVehicle, served

FILE = """
name = "airship"
kind = "mavlink"
[mavlink]
address = "{address}"
[limits]
linear = 0.2
[body]
arming = "disarmed"
"""


def findings(folder: Path, **parameters: float) -> str:
    vehicle = FakeVehicle(kind=7)
    vehicle.parameters = {name: (value, 9) for name, value in parameters.items()}
    path = folder / "robot.toml"
    with served(vehicle) as address:
        path.write_text(FILE.format(address=address))
        robot, problems = read_description(path)
        assert problems == []
        return "\n".join(str(each) for each in autopilot(robot))


def test_it_names_the_vehicle_its_unsafe_parameters_and_its_times_to_stop(tmp_path: Path) -> None:
    said = findings(tmp_path, RC_OVERRIDE_TIME=3.0, FS_THR_ENABLE=1.0, MAV_GCS_SYSID=255.0)
    assert "system 1, a blimp with ArduPilot" in said
    assert "RC_OVERRIDE_TIME is 3 in place of 0.5" in said
    assert "after zero" in said
    assert "after the link is cut" in said


def test_a_vehicle_that_never_stops_is_a_problem(tmp_path: Path) -> None:
    said = findings(tmp_path, RC_OVERRIDE_TIME=0.5, FS_THR_ENABLE=0.0, MAV_GCS_SYSID=255.0)
    assert "it never stops after the link is cut" in said
    assert "--write-safe" in said
