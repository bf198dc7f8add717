"""`rune drive ws://...`: one command from a robot's bridge to the console, also through ssh."""

from __future__ import annotations

import os
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from tests.support.ports import free_port
from tests.support.ros_robot import SimulatedRos
from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, family, gone
from tests.system.ssh_server import SshServer, missing


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[SimulatedRos]:
    with closing(SimulatedRos(tmp_path)) as running:
        yield running


def opened(stack: ExitStack, *words: str) -> ConsoleProcess:
    return stack.enter_context(closing(ConsoleProcess(["drive", *words], columns=120, rows=40)))


def said(console: ConsoleProcess) -> str:
    return " ".join(console.text.split())


def drives_and_ends(console: ConsoleProcess, robot: SimulatedRos) -> None:
    """It drives while W is held, and leaves nothing behind, the robot at a stop."""
    console.wait_for_picture()
    console.hold_until("w", lambda: any(each["twist"][0] > 0.0 for each in robot.commands()))
    processes = family(console.process.pid)
    assert console.quit() == ExitCode.OK
    until(lambda: gone(processes), 10.0, "processes are left")
    assert robot.commands()[-1]["twist"] == [0.0, 0.0, 0.0]


def test_it_adopts_drives_and_ends(robot: SimulatedRos, stack: ExitStack, tmp_path: Path) -> None:
    path = tmp_path / "found.toml"
    console = opened(stack, robot.address, "-o", str(path))
    drives_and_ends(console, robot)
    assert tomllib.loads(path.read_text())["ros"]["address"] == robot.address


def test_a_robot_that_never_stops_is_opened_after_enter(stack: ExitStack, tmp_path: Path) -> None:
    robot = stack.enter_context(closing(SimulatedRos(tmp_path, "--no-timeout", "--twist")))
    console = opened(stack, robot.address)
    console.wait(lambda: "Enter opens the console" in said(console), 30.0)
    assert "unsafe: the robot keeps the last command for ever" in said(console)
    console.type("\r")
    drives_and_ends(console, robot)


def test_without_a_bridge_it_says_so(stack: ExitStack) -> None:
    console = opened(stack, f"ws://127.0.0.1:{free_port()}")
    assert console.wait_ended(30.0) == ExitCode.NO_HUB
    assert "no robot with ROS answers at" in said(console)


@pytest.fixture
def reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stack: ExitStack
) -> Callable[..., SshServer]:
    if why := missing():
        pytest.skip(f"NOT TESTED: {why}")

    def made(programs: str = "") -> SshServer:
        server = stack.enter_context(closing(SshServer(tmp_path / "ssh", programs=programs)))
        monkeypatch.setenv("PATH", f"{server.path}:{os.environ['PATH']}")
        return server

    return made


@pytest.mark.soak
def test_the_hub_runs_on_the_robot_where_rune_is_installed(
    robot: SimulatedRos, reached: Callable[..., SshServer], stack: ExitStack, tmp_path: Path
) -> None:
    server, path = reached(str(Path(sys.executable).parent)), tmp_path / "found.toml"
    console = opened(stack, "--ssh", server.target, robot.address, "-o", str(path))
    console.wait(lambda: f"the hub runs on {server.target}" in said(console), 60.0)
    assert "it stops the robot within 0.3 s" in said(console)
    drives_and_ends(console, robot)
    until(lambda: not server.running(), 10.0, "ssh is left")
    until(lambda: not hubs_of(path), 10.0, "the hub is left on the robot")
    assert tomllib.loads(path.read_text())["ros"]["address"] == robot.address


def hubs_of(_: Path) -> list[str]:
    """Hubs that were started by ssh."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            if any(word.startswith("/tmp/tmp.") and word.endswith("robot.toml") for word in words):
                found.append(entry.name)
    return found


@pytest.mark.soak
def test_otherwise_the_bridge_comes_through_ssh(
    robot: SimulatedRos, reached: Callable[..., SshServer], stack: ExitStack, tmp_path: Path
) -> None:
    server, path = reached(), tmp_path / "found.toml"
    console = opened(stack, "--ssh", server.target, robot.address, "-o", str(path))
    console.wait(lambda: "Rune is not installed on" in said(console), 60.0)
    assert "When ssh ends, the robot stops by itself after 0.5 s" in said(console)
    drives_and_ends(console, robot)
    until(lambda: not server.running(), 10.0, "ssh is left")
    assert tomllib.loads(path.read_text())["ros"]["address"] == robot.address


def test_ssh_that_fails_says_why(reached: Callable[..., SshServer], stack: ExitStack) -> None:
    server = reached()
    server.use_key("other")
    console = opened(stack, "--ssh", server.target, "ws://127.0.0.1:8765")
    assert console.wait_ended(30.0) == ExitCode.NO_HUB
    assert "Permission denied (publickey)" in said(console)


def test_certificates_that_are_missing_are_said(stack: ExitStack, tmp_path: Path) -> None:
    console = opened(stack, "zenoh+tls://localhost:7447", "--tls", str(tmp_path))
    assert console.wait_ended(30.0) == ExitCode.USAGE
    assert "authority.pem cannot be used" in said(console)


def test_ssh_is_for_robots_with_ros(stack: ExitStack) -> None:
    console = opened(stack, "--ssh", "robot", "mavlink:udp://:14550")
    assert console.wait_ended() == ExitCode.USAGE
    assert "--ssh is for robots with ROS" in said(console)
