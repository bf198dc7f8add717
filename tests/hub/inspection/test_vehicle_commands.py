"""`rune-hub vehicle mission` and `key`, as a person types them."""

from __future__ import annotations

import hashlib
import io
import json
import sys
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.mavlink.wire.signing_key import read_signing_key
from tests.support.command_line import rune_hub
from tests.support.fake_vehicle import FakeVehicle, served


def test_a_mission_is_shown() -> None:
    vehicle = FakeVehicle(kind=2)
    place = {"x": 338103130, "y": -1183938670, "z": 5.0, "frame": 3}
    vehicle.missions = {0: [{"command": 16, "current": 1, **place}, {"command": 60000, **place}]}
    with served(vehicle) as address:
        shown = rune_hub("vehicle", "mission", address)
        listed = rune_hub("vehicle", "mission", address, "--json")
    assert (shown.returncode, shown.stderr) == (ExitCode.OK, "")
    first, second = shown.stdout.splitlines()[1:]
    assert first.split()[:6] == ["mission", "0", "now", "waypoint", "33.8103130,", "-118.3938670"]
    assert "command 60000" in second
    facts = [json.loads(line) for line in listed.stdout.splitlines()]
    assert [(each["list"], each["number"], each["z"]) for each in facts] == [
        ("mission", 0, 5.0),
        ("mission", 1, 5.0),
    ]


def test_a_key_is_made_for_its_owner_only(tmp_path: Path) -> None:
    path = tmp_path / "key"
    assert rune_hub("vehicle", "key", str(path)).returncode == ExitCode.OK
    assert path.stat().st_mode & 0o777 == 0o600
    key = read_signing_key(path)
    again = rune_hub("vehicle", "key", str(path))
    assert again.returncode == ExitCode.USAGE
    assert "File exists" in again.stderr
    assert read_signing_key(path) == key


def test_a_phrase_gives_the_key_of_other_ground_stations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "key"
    monkeypatch.setattr(sys, "stdin", io.StringIO("schöner Satz\n"))
    assert rune_hub("vehicle", "key", str(path), "--phrase").returncode == ExitCode.OK
    assert read_signing_key(path) == hashlib.sha256("schöner Satz".encode()).digest()
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    done = rune_hub("vehicle", "key", str(tmp_path / "none"), "--phrase")
    assert done.returncode == ExitCode.USAGE
    assert not (tmp_path / "none").exists()


def test_a_key_goes_to_a_disarmed_vehicle_only(tmp_path: Path) -> None:
    path, vehicle = tmp_path / "key", FakeVehicle(kind=2)
    vehicle.armed = True
    with served(vehicle) as address:
        done = rune_hub("vehicle", "key", str(path), "--setup", address)
    assert done.returncode == ExitCode.FAULT
    assert "it is armed: disarm it first" in done.stderr
    assert vehicle.keys == []


def test_a_vehicle_that_signs_from_then_on_has_the_key(tmp_path: Path) -> None:
    path = tmp_path / "key"
    rune_hub("vehicle", "key", str(path))
    key = read_signing_key(path)
    vehicle = FakeVehicle(kind=2)
    with served(vehicle) as address:
        done = rune_hub("vehicle", "key", str(path), "--setup", address)
    assert done.returncode == ExitCode.FAULT
    assert "no frame with its signature came" in done.stderr
    assert set(vehicle.keys) == {key}
    with served(vehicle, signer=Signer(key, SigningClock())) as address:
        done = rune_hub("vehicle", "key", str(path), "--setup", address)
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    assert "signs its frames with this key now" in done.stdout


def test_the_doctor_names_unsafe_parameters_of_the_vehicle(tmp_path: Path) -> None:
    path, vehicle = tmp_path / "blimp.toml", FakeVehicle(kind=7)
    vehicle.parameters = {"RC_OVERRIDE_TIME": (3.0, 9), "FS_THR_ENABLE": (1.0, 2)}
    vehicle.parameters["MAV_GCS_SYSID"] = (255.0, 2)
    with served(vehicle) as address:
        path.write_text(f'name = "b"\nkind = "mavlink"\n[mavlink]\naddress = "{address}"\n')
        done = rune_hub("doctor", str(path), "--json")
    findings = [json.loads(line) for line in done.stdout.splitlines()]
    found = [each for each in findings if each["check"] == "autopilot"]
    assert [each["level"] for each in found] == ["ok", "warning", "ok"]
    assert "a blimp with ArduPilot 4.7.0" in found[0]["text"]
    assert "RC_OVERRIDE_TIME is 3 in place of 0.5" in found[1]["text"]
    assert found[1]["advice"].endswith("--write RC_OVERRIDE_TIME=0.5")
    assert "after the link is cut" in found[2]["text"]
