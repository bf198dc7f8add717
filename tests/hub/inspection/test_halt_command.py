"""`rune-hub halt`: it stops the robot, and says whether it stands."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.command_line import ExitCode
from hub.errors import CentralUnreachableError
from hub.gcm.control import CONTROL_STATE, PLAYED, ControlState
from hub.gcm.navigation import ROBOT_STATE, STOP, MotionState
from hub.hub_sockets import HubFolder, RunningHub
from hub.inspection import halt_command
from hub.inspection.halt_command import Halt
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.publish_rights import ROBOMON
from tests.hub.ipc.conftest import Peer
from tests.support.cases import for_each
from tests.support.command_line import rune_hub
from tests.support.messages import robot_state

DRIVEN = {"motion": MotionState.MOVING, "commanded_linear": 0.5, "linear": 0.5}
BRAKES = {"motion": MotionState.STOPPED, "linear": 0.3}
STOPPED = {"motion": MotionState.STOPPED}


@for_each(
    ("reports", "stands"),
    [
        ([], False),
        ([DRIVEN], False),
        ([DRIVEN, BRAKES], False),
        ([DRIVEN, BRAKES, STOPPED], True),
        ([STOPPED], True),
        # It stands, but a stop may still be on its way, and before it a command to drive.
        ([{"motion": MotionState.STANDING}], False),
        # A console that sends neutral ends the state STOPPED before it is reported.
        ([{**DRIVEN, "stops": 7}, {"motion": MotionState.STANDING, "stops": 8}], True),
        ([{**DRIVEN, "stops": 7}, {**DRIVEN, "stops": 8}], False),
        ([{**STOPPED, "angular": 0.5}], False),
        ([{**STOPPED, "commanded_angular": 0.5}], False),
        ([STOPPED, {"motion": MotionState.NO_DRIVER}], False),
        ([STOPPED, {"motion": MotionState.GOING}], False),
    ],
)
def test_robot_stands_once_it_reports_a_stop_and_rest(
    reports: list[dict[str, Any]], *, stands: bool
) -> None:
    course = Halt()
    for report in reports:
        course.take(robot_state(**report))
    assert course.stands == stands


class Robot(Peer):
    """Drives until enough stops came; then it brakes, if it can."""

    def __init__(self, endpoint: str, *, obeys_after: int = 1, brakes: bool = True) -> None:
        super().__init__("navigation", endpoint)
        self.stops = 0
        self.obeys_after, self.brakes = obeys_after, brakes
        self.connect()
        self.call(self._begin)

    def _begin(self) -> None:
        self.client.define(ROBOT_STATE)
        self.client.subscribe(STOP, self._stopped)
        self.client.every(0.02, self._report)

    def _stopped(self, *_: object) -> None:
        self.stops += 1

    def _report(self) -> None:
        stopped = self.stops >= self.obeys_after
        state = (STOPPED if self.brakes else BRAKES) if stopped else DRIVEN
        self.client.publish(ROBOT_STATE, robot_state(**state))


@pytest.fixture
def central(tmp_path: Path) -> Iterator[Central]:
    with closing(Central([f"ipc://{tmp_path}/central"])) as central:
        yield central


@pytest.fixture
def client(central: Central) -> Iterator[Client]:
    with closing(Client("rune-hub-halt", central.endpoints[0])) as client:
        client.wait_connected(10.0)
        yield client


def test_it_sends_stops_until_the_robot_reports_one(
    central: Central, client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(Robot(central.endpoints[0], obeys_after=3)) as robot:
        assert halt_command.halt(client, as_json=False) == 0
        assert robot.stops >= 3
    said = capsys.readouterr()
    assert said.out.startswith("the robot stands, ")
    assert said.err == ""


def test_robot_that_rolls_on_is_a_fault(
    central: Central,
    client: Client,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(halt_command, "LIMIT_S", 0.5)
    with closing(Robot(central.endpoints[0], brakes=False)):
        assert halt_command.halt(client, as_json=True) == 1
    said = capsys.readouterr()
    report = json.loads(said.out)
    assert "still moves" in report.pop("problem")
    assert report | {"seconds": 0.5} == {
        "stands": False, "seconds": 0.5, "linear": 0.3, "angular": 0.0,
    }  # fmt: skip
    assert "still moves" in said.err
    assert "0.30 m/s" in said.err


def test_robot_that_reports_nothing_is_not_taken_for_one_that_stands(
    client: Client, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(halt_command, "LIMIT_S", 0.2)
    assert halt_command.halt(client, as_json=False) == 1
    assert "may still move" in capsys.readouterr().err


class Owner(Peer):
    """A hub that says who has control."""

    def __init__(self, endpoint: str, owner: int | None) -> None:
        super().__init__(ROBOMON, endpoint)
        self.owner = owner
        self.connect()
        self.call(self._begin)

    def _begin(self) -> None:
        self.client.define(CONTROL_STATE)
        self.client.every(0.05, self._report)

    def _report(self) -> None:
        owner = self.client.number if self.owner is None else self.owner
        self.client.publish(CONTROL_STATE, ControlState(owner=owner, owner_name=PLAYED))


def test_a_played_recording_is_no_robot_that_still_moves(
    central: Central,
    client: Client,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(halt_command, "LIMIT_S", 0.5)
    endpoint = central.endpoints[0]
    with closing(Owner(endpoint, None)), closing(Robot(endpoint, brakes=False)):
        assert halt_command.halt(client, as_json=False) == 1
    assert "this hub plays a recording" in capsys.readouterr().err


def test_a_console_of_that_name_makes_no_recording_of_a_robot(
    central: Central,
    client: Client,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(halt_command, "LIMIT_S", 0.5)
    endpoint = central.endpoints[0]
    with closing(Owner(endpoint, client.number)), closing(Robot(endpoint, brakes=False)):
        assert halt_command.halt(client, as_json=False) == 1
    assert "still moves" in capsys.readouterr().err


def test_without_a_hub_the_code_is_3() -> None:
    done = rune_hub("halt", "--hub", "tcp://127.0.0.1:1")
    assert done.returncode == 3
    assert "the robot was NOT stopped; use its emergency stop: no hub answers" in done.stderr
    assert done.stdout == ""


def test_without_a_hub_json_says_that_the_robot_was_not_stopped() -> None:
    done = rune_hub("halt", "--json", "--hub", "tcp://127.0.0.1:1")
    assert done.returncode == ExitCode.NO_HUB
    report = json.loads(done.stdout)
    assert report["problem"].startswith("the robot was NOT stopped; use its emergency stop: no hub")
    assert (report["stands"], report["linear"], report["angular"]) == (False, None, None)


def test_a_stop_that_is_interrupted_does_not_end_as_one_that_succeeded() -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "hub", "halt", "--hub", "tcp://127.0.0.1:1"],
        stderr=subprocess.PIPE,
        text=True,
    ) as halting:
        assert halting.stderr is not None
        assert "NOT stopped yet" in halting.stderr.readline()
        halting.send_signal(signal.SIGINT)
        assert "may still move; use its emergency stop" in halting.stderr.readline()
    assert halting.returncode == ExitCode.FAULT


def test_who_wants_to_stop_the_robot_by_stop_learns_of_halt() -> None:
    done = rune_hub("stop")
    assert done.returncode == 2
    assert "`rune-hub halt` stops the robot" in done.stderr


def test_without_a_name_the_robots_of_all_hubs_stop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "run").mkdir(mode=0o700)
    monkeypatch.setenv("RUNE_RUNTIME_DIR", str(tmp_path / "run"))
    with ExitStack() as stack:
        for name in ("magellan", "blimp"):
            folder = stack.enter_context(closing(HubFolder(name)))
            stack.enter_context(closing(Central([folder.endpoint])))
            stack.enter_context(closing(Robot(folder.endpoint)))
        done = rune_hub("halt")
    assert done.returncode == 0
    assert sorted(line.split(" stands")[0] for line in done.stdout.splitlines()) == [
        "blimp: the robot",
        "magellan: the robot",
    ]


def test_a_hub_that_does_not_answer_delays_no_stop_of_another_robot(
    capsys: pytest.CaptureFixture[str],
) -> None:
    stopped = threading.Event()

    def stop(hub: RunningHub) -> int:
        if hub.name == "a":
            assert stopped.wait(10.0), "b waited for a"
            text = "no hub answers"
            raise CentralUnreachableError(text)
        stopped.set()
        return 0

    hubs = [RunningHub(name=name, path=Path(name)) for name in ("a", "b")]
    assert halt_command.halt_each(hubs, stop) == ExitCode.NO_HUB
    assert "a: no hub answers" in capsys.readouterr().err


def test_a_frozen_hub_is_said_early_and_not_called_absent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "run").mkdir(mode=0o700)
    monkeypatch.setenv("RUNE_RUNTIME_DIR", str(tmp_path / "run"))
    with closing(HubFolder("magellan")) as folder, closing(socket.socket(socket.AF_UNIX)) as hub:
        hub.bind(folder.endpoint.removeprefix("ipc://"))
        hub.listen()
        done = rune_hub("halt")
    assert done.returncode == ExitCode.NO_HUB
    first, last = done.stderr.splitlines()
    assert "the robot is NOT stopped yet; use its emergency stop: the hub runs" in first
    assert "the robot was NOT stopped; use its emergency stop: the hub runs and does not" in last
    assert f"process {os.getpid()}" in last
    assert "start it with" not in last
