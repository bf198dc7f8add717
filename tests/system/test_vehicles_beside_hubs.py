"""Commands about a vehicle beside the hub that drives it: real processes, with the stand-in."""

from __future__ import annotations

import dataclasses
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil

from hub.command_line import ExitCode
from hub.gcm.autopilot import AUTOPILOT_STATE, AutopilotPhase
from hub.inspection.doctor.autopilot_checks import autopilot
from hub.robots.mavlink.wire.frames import FramePacker, MavlinkFrame
from hub.robots.mavlink.wire.signing import SigningClock
from hub.robots.robot_file import read_description
from tests.hub.inspection.test_sim_autopilot_command import simulated_autopilot
from tests.support import warm_start
from tests.support.command_line import rune_hub
from tests.support.waiting import exit_code
from tests.system.autopilot_site import AutopilotSite, Operator, SimulatedVehicle, vehicle_tables
from tests.system.harness import HubProcess, Observer

LOITER = 5
POSITION, SET_INTERVAL, SET_MODE = 32, 511, 176


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[AutopilotSite]:
    parameters = ("SIM_RC_FAIL=1", "FS_TIMEOUT=1.5", "FS_GCS_ENABLE=0")
    with closing(AutopilotSite(tmp_path_factory.mktemp("hub"), "rover", parameters)) as site:
        yield site


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    return tmp_path / "vehicle-parameters"


@contextmanager
def station(site: AutopilotSite, *options: str) -> Iterator[Any]:
    """A ground station that `rune-hub vehicle forward` sends to, once it is heard."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    heard = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", source_system=254)
    address = f"tcp://127.0.0.1:{site.relay.port}"
    to = ("--to", f"udp://127.0.0.1:{port}", "--hub", site.hub.endpoint, *options)
    process = warm_start.start(
        [sys.executable, "-m", "hub", "vehicle", "forward", address, *to, "--stop-with-stdin"],
        environment={},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    try:
        site.wait(lambda: heard.recv_match(type="HEARTBEAT"), why="the station hears nothing:")
        yield heard
    finally:
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            pipe.close()
        exit_code(process, 10.0)
        heard.close()


def of_station(site: AutopilotSite, since: float) -> list[MavlinkFrame]:
    """Frames of the station that the hub passed on to the vehicle."""
    frames = list(site.relay.frames)
    return [each for at, hub, each in frames if hub and at >= since and each.system == 254]


def send_all(heard: Any) -> None:
    """Sticks, a heartbeat, a question and an order."""
    heard.mav.heartbeat_send(6, 8, 0, 0, 4)
    heard.mav.manual_control_send(1, 500, 0, 500, 0, 0)
    heard.mav.param_request_read_send(1, 1, b"WP_SPEED", -1)
    heard.mav.command_long_send(1, 1, SET_MODE, 0, 1, LOITER, 0, 0, 0, 0, 0)


def test_the_doctor_asks_the_hub_that_has_the_link(site: AutopilotSite) -> None:
    site.wait(lambda: site.autopilot.unsafe)
    robot, problems = read_description(site.hub.log.with_name("robot.toml"))
    assert problems == []
    name = Path(site.hub.endpoint).parent.name
    said = "\n".join(str(each) for each in autopilot(dataclasses.replace(robot, name=name)))
    assert "has the link to a rover with ArduPilot 4.7.0: " in said
    assert "FS_GCS_ENABLE is 0 in place of 1" in said
    assert "--write FS_TIMEOUT=0.1" in said
    assert "at the limits of the robot file it stops" in said


def test_a_place_that_comes_no_more_is_not_kept(site: AutopilotSite) -> None:
    site.wait(lambda: site.robot.linear is not None and site.autopilot.position)
    command = {"command": SET_INTERVAL, "param1": POSITION, "param2": -1.0}
    target = {"target_system": 1, "target_component": 1}
    site.relay.add(FramePacker(255, 190).pack("COMMAND_LONG", **command, **target))
    site.wait(lambda: any("LOCAL_POSITION_NED no more" in each for each in site.problems))
    site.relay.add(
        FramePacker(255, 190).pack("COMMAND_LONG", **(command | {"param2": 5e4}), **target)
    )
    site.wait(lambda: not any("no more" in each for each in site.problems))


def test_another_station_watches_beside_the_hub_and_no_more(site: AutopilotSite) -> None:
    since = time.monotonic()
    with station(site) as heard:
        names = set()
        for _ in range(3):
            send_all(heard)
            site.go_on(0.2)
            while frame := heard.recv_match():
                names.add(frame.get_type())
    assert {"ATTITUDE", "LOCAL_POSITION_NED"} <= names
    assert of_station(site, since) == []


def test_its_commands_pass_while_nobody_has_control(site: AutopilotSite) -> None:
    since = time.monotonic()
    with station(site, "--commands") as heard:

        def passed() -> bool:
            send_all(heard)
            return len({each.name for each in of_station(site, since)}) >= 2

        site.wait(passed, why="nothing passes:")
        site.go_on(0.3)
        names = {each.name for each in of_station(site, since)}
        assert names == {"PARAM_REQUEST_READ", "COMMAND_LONG"}
        site.wait(lambda: site.autopilot.mode == "loiter")
        driver = Operator(site.hub.endpoint, "rival")
        with closing(driver.client):
            driver.takes_control()
            site.go_on(0.3)
            since = time.monotonic()
            for _ in range(5):
                send_all(heard)
                driver.client.listen(0.1)
                site.go_on(0.1)
            assert of_station(site, since) == []


def test_parameters_are_not_changed_beside_a_hub_at_another_port(
    site: AutopilotSite, state: Path
) -> None:
    """As that of `rune drive`, whose robot file is a temporary one."""
    site.wait(lambda: site.phase is AutopilotPhase.DISARMED)
    address = f"tcp://127.0.0.1:{site.relay.port}"
    done = rune_hub("vehicle", "parameters", address, "--write-safe")
    assert done.returncode == ExitCode.FAULT
    assert f"process {site.hub.pids['driver']} of this machine has this vehicle" in done.stderr
    assert not state.exists()
    shown = rune_hub("vehicle", "parameters", address, "--unsafe", "--json")
    assert shown.returncode == ExitCode.OK
    assert "FS_GCS_ENABLE" in shown.stdout
    assert site.phase is AutopilotPhase.DISARMED


@pytest.mark.soak
def test_parameters_go_full_circle(state: Path) -> None:
    unsafe = {"FS_GCS_ENABLE": 0.0, "FS_TIMEOUT": 1.5, "RC_OVERRIDE_TIME": 3.0}
    settings = [f"{name}={value}" for name, value in unsafe.items()]
    with closing(SimulatedVehicle("rover", settings)) as vehicle:
        address = f"tcp://127.0.0.1:{vehicle.port}"

        def run(*options: str) -> dict[str, float]:
            done = rune_hub("vehicle", "parameters", address, *options)
            assert (done.returncode, done.stderr) == (ExitCode.OK, "")
            if "--json" not in options:
                return {}
            facts = [json.loads(line) for line in done.stdout.splitlines()]
            return {each["name"]: each["value"] for each in facts}

        before = run("--json")
        assert before.items() >= unsafe.items()
        run("--write-safe")
        (kept,) = state.iterdir()
        assert run("--json").items().isdisjoint(unsafe.items())
        run("--restore", str(kept))
        assert run("--json") == before


@contextmanager
def signed_hub(folder: Path, address: str, key: Path) -> Iterator[tuple[HubProcess, Observer]]:
    tables = vehicle_tables("rover", 0).replace('"tcp://127.0.0.1:0"', f'"{address}"')
    tables = tables.replace("[limits]", f'key_file = "{key}"\n[limits]')
    folder.mkdir()
    modules = ("driver", "navigation")
    with (
        closing(HubProcess(folder, kind="mavlink", modules=modules, tables=tables)) as hub,
        closing(Observer(hub.endpoint, AUTOPILOT_STATE)) as observer,
    ):
        yield hub, observer


def hears(observer: Observer) -> bool:
    """Whether the vehicle answers the hub."""
    states = observer.seen[AUTOPILOT_STATE.name]
    return bool(states) and states[-1][1].phase is AutopilotPhase.DISARMED


@pytest.mark.soak
def test_a_killed_hub_whose_clock_is_behind_is_heard_again(tmp_path: Path) -> None:
    """Its stamps are an hour ahead of the clock, as after a clock that went back an hour."""
    key, stamp = tmp_path / "key", tmp_path / "key.stamp"
    with simulated_autopilot("rover", "--tcp", "0", "--tcp", "0", "--fast-boot") as (_, address):
        done = rune_hub("vehicle", "key", str(key), "--setup", address)
        assert (done.returncode, done.stderr) == (ExitCode.OK, "")
        stamp.write_text(f"{SigningClock().next() + 3600 * 100_000}\n")
        for run in range(3):
            if run == 2:
                stamp.unlink()  # the frames of the vehicle say how late it is
            with signed_hub(tmp_path / f"run {run}", address, key) as (hub, observer):
                observer.wait(lambda: hears(observer), 20.0, f"run {run} is not heard")
                asked = rune_hub("vehicle", "mission", address, "--key", str(key))
                assert asked.returncode == ExitCode.OK, asked.stderr
                end = time.monotonic() + 1.5
                observer.wait(lambda: time.monotonic() > end, 5.0)  # noqa: B023
                assert hears(observer), "a signed question made it deaf to the hub"
                hub.process.send_signal(signal.SIGKILL)
