"""`rune-hub vehicle parameters`, as a person types it, with a vehicle that answers over UDP."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.robots.mavlink.wire.signing import Signer, SigningClock
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
        assert "it has no parameter NOPE, or did not answer; nothing was changed" in refused


def test_what_was_not_read_is_not_known_and_no_success(blimp: FakeVehicle, state: Path) -> None:
    del blimp.parameters["FS_THR_ENABLE"]
    with served(blimp) as address:
        blimp.parameters["RC_OVERRIDE_TIME"] = (0.5, 9)
        said, unknown = parameters(address, "--unsafe", code=ExitCode.FAULT)
        assert said == ""
        assert "not known whether safe: FS_THR_ENABLE was not read" in unknown
        said, unknown = parameters(address, "--write-safe", code=ExitCode.FAULT)
        assert "already" not in said
        assert "FS_THR_ENABLE was not read, so it was not set" in unknown
        _, unknown = parameters(address, code=ExitCode.FAULT)
        assert "FS_THR_ENABLE" in unknown
    assert not state.exists()


def test_the_older_name_of_a_parameter_counts(blimp: FakeVehicle) -> None:
    blimp.parameters["RC_OVERRIDE_TIME"] = (0.5, 9)
    blimp.parameters["SYSID_MYGCS"] = blimp.parameters.pop("MAV_GCS_SYSID")
    with served(blimp) as address:
        said, unknown = parameters(address, "--unsafe")
        assert said == "no parameter that Rune knows is unsafe\n"
        assert "SYSID" not in unknown
        blimp.parameters["SYSID_MYGCS"] = (1.0, 4)
        said, _ = parameters(address, "--write-safe")
    assert "SYSID_MYGCS: 1 -> 255" in said


def test_a_vehicle_that_wants_a_key_is_named_with_the_command_that_gives_it(
    blimp: FakeVehicle, tmp_path: Path
) -> None:
    blimp.deaf = True
    signer = Signer(bytes(range(32)), SigningClock())
    with served(blimp, signer=signer) as address:
        for task in (("parameters", "--unsafe"), ("mission",), ("parameters", "--write-safe")):
            done = rune_hub("vehicle", task[0], address, *task[1:])
            assert done.returncode == ExitCode.NO_HUB
            for words in ("it signs its frames", "--key", "rune-hub vehicle key FILE --setup"):
                assert words in done.stderr
            assert done.stdout == ""
        path = tmp_path / "blimp.toml"
        adopted = rune_hub("adopt", "mavlink", address, "-o", str(path))
        assert adopted.returncode == ExitCode.FAULT
        assert "not known: FS_THR_ENABLE was not read" in adopted.stdout + adopted.stderr
        found = rune_hub("doctor", str(path), "--json").stdout.splitlines()
    said = [each for each in map(json.loads, found) if each["check"] == "autopilot"]
    assert [each["level"] for each in said] == ["problem"]
    assert "it signs its frames" in said[0]["text"]


def test_the_doctor_calls_what_was_not_read_no_success(blimp: FakeVehicle, tmp_path: Path) -> None:
    path = tmp_path / "blimp.toml"
    with served(blimp) as address:
        assert rune_hub("adopt", "mavlink", address, "-o", str(path)).returncode == ExitCode.OK
        del blimp.parameters["FS_THR_ENABLE"]
        found = rune_hub("doctor", str(path), "--json").stdout.splitlines()
    said = [each for each in map(json.loads, found) if each["check"] == "autopilot"]
    (unknown,) = (each for each in said if "FS_THR_ENABLE was not read" in each["text"])
    assert unknown["level"] == "problem"
    (times,) = (each for each in said if "times to stop are not known" in each["text"])
    assert times["level"] == "warning"
    assert not any("s after zero" in each["text"] for each in said)


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
