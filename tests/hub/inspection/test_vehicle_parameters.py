"""`rune-hub vehicle parameters`, as a person types it, with a vehicle that answers over UDP."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from tests.support.command_line import rune_hub
from tests.support.fake_vehicle import FakeVehicle, served


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    return tmp_path / "vehicle-parameters"


@pytest.fixture
def blimp() -> FakeVehicle:
    vehicle = FakeVehicle(kind=7)
    vehicle.parameters = {
        "RC_OVERRIDE_TIME": (3.0, 9),
        "FS_THR_ENABLE": (1.0, 2),
        "MAV_GCS_SYSID": (255.0, 4),
        "MAX_VEL_XY": (0.2, 9),
        **dict.fromkeys(("MAX_VEL_Z", "MAX_VEL_YAW"), (0.4, 9)),
        **dict.fromkeys(("RCMAP_ROLL", "RCMAP_PITCH", "RCMAP_THROTTLE", "RCMAP_YAW"), (1.0, 2)),
    }
    return vehicle


def parameters(address: str, *arguments: str, code: int = ExitCode.OK) -> tuple[str, str]:
    done = rune_hub("vehicle", "parameters", address, *arguments)
    assert done.returncode == code, done.stderr
    return done.stdout, done.stderr


def test_unsafe_ones_are_shown_set_and_set_back(blimp: FakeVehicle, state: Path) -> None:
    with served(blimp) as address:
        said, _ = parameters(address, "--write-safe")
        assert "RC_OVERRIDE_TIME: 3 -> 0.5" in said
        assert blimp.parameters["RC_OVERRIDE_TIME"][0] == 0.5
        (kept,) = state.iterdir()
        assert kept.read_text().splitlines()[1:] == ["RC_OVERRIDE_TIME,3"]
        said, _ = parameters(address, "--restore", str(kept))
        assert blimp.parameters["RC_OVERRIDE_TIME"][0] == 3.0
        assert len([*state.iterdir()]) == 2
        said, _ = parameters(address, "--unsafe", "--json")
    assert [json.loads(line)["name"] for line in said.splitlines()] == ["RC_OVERRIDE_TIME"]


def test_nothing_is_set_in_an_armed_vehicle_or_beside_a_hub(
    blimp: FakeVehicle, state: Path
) -> None:
    with served(blimp) as address:
        blimp.armed = True
        _, refused = parameters(address, "--write-safe", code=ExitCode.FAULT)
        assert "it is armed: disarm it first; nothing was changed" in refused
        blimp.armed = False
        blimp.others = [(255, 190, 6, 8)]
        _, refused = parameters(address, "--write", "MAX_VEL_XY=1", code=ExitCode.FAULT)
        assert "a ground station with the number 255, such as a hub" in refused
    assert "PARAM_SET" not in blimp.heard
    assert not state.exists()


def test_what_cannot_be_set_is_said(blimp: FakeVehicle) -> None:
    blimp.frozen = {"MAX_VEL_XY"}
    _, refused = parameters("udp://:1", "--write", "max", code=ExitCode.USAGE)
    assert "--write 'max' is no NAME=VALUE" in refused
    with served(blimp) as address:
        write = ("--write", "max_vel_xy=0.3", "RC_OVERRIDE_TIME=0.3")
        said, refused = parameters(address, *write, code=ExitCode.FAULT)
        assert "MAX_VEL_XY was not set: it keeps 0.2" in refused
        assert "RC_OVERRIDE_TIME: 3 -> 0.3" in said
        _, refused = parameters(address, "--write", "NOPE=1", code=ExitCode.FAULT)
        assert "the vehicle has no parameter NOPE; nothing was changed" in refused


def test_all_and_some_by_a_robot_file(blimp: FakeVehicle, tmp_path: Path) -> None:
    path = tmp_path / "blimp.toml"
    with served(blimp) as address:
        path.write_text(f'name = "b"\nkind = "mavlink"\n[mavlink]\naddress = "{address}"\n')
        said, _ = parameters(str(path), "--all")
        names = [line.split()[0] for line in said.splitlines()[1:]]
        assert names == sorted(blimp.parameters)
        said, _ = parameters(str(path), "max_vel_xy", "--json")
    assert json.loads(said) == {"name": "MAX_VEL_XY", "value": 0.2, "type": 9, "unsafe": False}


def test_a_robot_without_an_autopilot() -> None:
    done = rune_hub("vehicle", "parameters", "magellan.toml")
    assert done.returncode == ExitCode.USAGE
