"""`rune-hub adopt mavlink`, as a person types it, with vehicles that answer over UDP."""

from __future__ import annotations

import json
import socket
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.gcm.body import Freedom
from hub.gcm.vehicle import Arming
from hub.inspection.adopt_options import with_kind
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.robot_file import read_description
from tests.support.command_line import rune_hub
from tests.support.fake_vehicle import FakeVehicle, served

ROVER = {
    "FS_GCS_ENABLE": (0.0, 2),
    "FS_GCS_TIMEOUT": (2.0, 9),
    "FS_THR_ENABLE": (1.0, 2),
    "FS_TIMEOUT": (0.1, 9),
    "FS_ACTION": (2.0, 2),
    "RC_OVERRIDE_TIME": (0.5, 9),
    "MAV_GCS_SYSID": (255.0, 4),
    "WP_SPEED": (0.8, 9),
    "ACRO_TURN_RATE": (180.0, 9),
    "SPEED_MAX": (0.0, 9),
    "ATC_STR_RAT_MAX": (45.0, 9),
}


def rover() -> FakeVehicle:
    vehicle = FakeVehicle()
    vehicle.parameters = dict(ROVER)
    return vehicle


def adopt(*arguments: str, code: int = ExitCode.OK) -> tuple[str, str]:
    done = rune_hub("adopt", "mavlink", "--seconds", "2", *arguments)
    assert done.returncode == code, done.stderr
    return done.stdout, done.stderr


def test_a_rover_gets_a_robot_file_that_check_accepts(tmp_path: Path) -> None:
    path = tmp_path / "rover.toml"
    vehicle = rover()
    with served(vehicle) as address:
        said, _ = adopt(address, "-o", str(path))
    assert f"{address}: system 1, a rover with ArduPilot 4.7.0" in said
    assert "unsafe: FS_GCS_ENABLE is 0 in place of 1: it goes on" in said
    assert "FS_TIMEOUT" not in said
    robot, problems = read_description(path)
    assert problems == []
    assert (robot.name, robot.kind, robot.vehicle_address) == ("rover", "mavlink", address)
    assert (robot.vehicle_system, robot.arming) == (1, Arming.DISARMED)
    limits = {motion.freedom: motion.limit for motion in robot.body.motions}
    assert limits == {Freedom.SURGE: 0.8, Freedom.YAW: pytest.approx(0.78)}
    assert rune_hub("check", str(path)).returncode == ExitCode.OK


def test_json_and_no_file() -> None:
    with served(rover()) as address:
        said, _ = adopt(address, "--json")
        printed, remarks = adopt(address)
    facts = json.loads(said)
    assert (facts["vehicle"], facts["system"], facts["path"]) == ("rover", 1, None)
    assert [each["name"] for each in facts["unsafe"]] == ["FS_GCS_ENABLE"]
    assert facts["parameters"]["WP_SPEED"] == pytest.approx(0.8)
    assert 'kind = "mavlink"' in printed
    assert "unsafe: FS_GCS_ENABLE" in remarks


def test_a_file_stays_unless_forced(tmp_path: Path) -> None:
    path = tmp_path / "rover.toml"
    path.write_text("mine")
    with served(rover()) as address:
        _, refused = adopt(address, "-o", str(path), code=ExitCode.FAULT)
        assert "--force" in refused
        assert path.read_text() == "mine"
        adopt(address, "-o", str(path), "--force")
    assert read_description(path)[1] == []


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("udp://:{port}", "of loopback; loopback is within this machine only: give udp://0.0.0.0:"),
        ("udp://0.0.0.0:{port}", "see that it sends to the address of this machine"),
        ("udp://127.0.0.1:{port}", "where it sends them itself, give udp://0.0.0.0:"),
        ("tcp://127.0.0.1:{port}", "Connection refused; see that it runs there"),
        ("/dev/rune-has-no-such-port", "with 115200 baud: it is not there; plug it in"),
    ],
)
def test_where_it_listened_in_vain(address: str, words: str) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    _, refused = adopt(address.format(port=port), "--seconds", "0.2", code=ExitCode.NO_HUB)
    assert words in refused
    assert refused.count("\n") == 1


def test_a_signed_vehicle_needs_its_key(tmp_path: Path) -> None:
    key = bytes(range(32))
    file, other = tmp_path / "key", tmp_path / "other"
    for path, secret in ((file, key), (other, bytes(32))):
        path.write_text(secret.hex())
        path.chmod(0o600)
    with served(rover(), signer=Signer(key, SigningClock())) as address:
        said, _ = adopt(address, "--json")
        assert "its frames have signatures: give the file of its key" in said
        _, refused = adopt(address, "--key", str(other), "--seconds", "1", code=ExitCode.NO_HUB)
        assert "without a signature of this key" in refused
        said, _ = adopt(address, "--key", str(file))
        assert f'key_file = "{file}"' in said


@pytest.mark.parametrize(
    ("words", "kind", "address"),
    [
        (["mavlink:tcp://127.0.0.1:5760", "-o", "a.toml"], "mavlink", "tcp://127.0.0.1:5760"),
        (["-o", "a.toml", "mavlink:/dev/ttyACM0"], "mavlink", "/dev/ttyACM0"),
        (["ws://127.0.0.1:8765"], "ros", "ws://127.0.0.1:8765"),
        (["mavlink", "udp://:14550"], "mavlink", "udp://:14550"),
    ],
)
def test_addresses_as_a_drive_takes_them_need_no_kind(
    words: list[str], kind: str, address: str
) -> None:
    found = with_kind(["adopt", *words])
    assert found[:2] == ["adopt", kind]
    assert address in found[2:]
