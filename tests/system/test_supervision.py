"""The daemon with modules that misbehave, real processes all; and the commands that talk to it."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import psutil
import pytest

from hub.gcm import supervision
from hub.gcm.common import (
    COMMON_COMMAND,
    COMMON_RESULT,
    CommonCommand,
    CommonCommandKind,
    CommonResult,
)
from hub.gcm.supervision import CapabilityPhase, ModulePhase
from hub.ipc.client import Client
from tests.support import warm_start
from tests.support.command_line import rune_hub
from tests.support.waiting import exit_code, until
from tests.system.harness import family, gone

ROOT = Path(__file__).parents[2]

_numbers = itertools.count(1)


class Robot:
    """A daemon with modules of `tests.misbehaving.module`, and a client that sees its reports."""

    def __init__(self, folder: Path, modules: str, *, whole: bool = False) -> None:
        """Start it; `modules` is the end of the robot file, or the `whole` file."""
        self.folder = folder
        path = folder / "robot.toml"
        head = (
            'name = "test"\nkind = "simulated-magellan"\n[simulation]\narena = "empty"\n'
            '[hub]\nlogs = "logs"\n'
        )
        path.write_text(modules if whole else head + modules)
        self.log = folder / "hub.log"
        with self.log.open("wb") as log:
            self.process = warm_start.start(
                [
                    *(sys.executable, "-m", "hub", "run", str(path), "--json"),
                    *("--stop-with-stdin", "--as", f"supervised-{os.getpid()}-{next(_numbers)}"),
                ],
                environment=os.environ,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log.fileno(),
                folder=ROOT,
            )
        assert self.process.stdout is not None
        self.endpoint = json.loads(self.process.stdout.readline())["hub"]
        self.connect()

    def connect(self) -> None:
        """Connect a client, and wait for its first report."""
        self.client = Client("test", self.endpoint)
        self.client.wait_connected(10.0)
        self.modules: dict[str, supervision.ModuleReport] = {}
        self.capabilities: dict[str, supervision.CapabilityReport] = {}
        self.client.subscribe(supervision.MODULE_REPORTS, self._note_modules)
        self.client.subscribe(supervision.CAPABILITY_REPORTS, self._note_capabilities)
        self.until(lambda: self.modules)

    def _note_modules(self, reports: supervision.ModuleReports, _: object) -> None:
        self.modules = {each.name: each for each in reports.modules}

    def _note_capabilities(self, reports: supervision.CapabilityReports, _: object) -> None:
        self.capabilities = {each.name: each for each in reports.capabilities}

    def until(self, condition: Callable[[], object], timeout: float = 20.0) -> None:
        until(
            condition,
            timeout,
            lambda: f"{self.modules}\n{self.capabilities}\n{self.log.read_text()}",
            meanwhile=lambda: self.client.listen(0.02),
        )

    def phase(self, name: str) -> ModulePhase:
        return self.modules[name].phase

    def order(self, name: str, order: supervision.ModuleOrder) -> CommonResult:
        command = supervision.ModuleCommand(module=name, order=order)
        return self.client.query_response(
            supervision.MODULE_COMMAND, command, COMMON_RESULT, timeout=5.0
        )

    def close(self) -> None:
        self.client.close()
        self.end()

    def end(self) -> None:
        """End the daemon."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.close()
        exit_code(self.process, 15.0)
        self.process.stdout.close()


Start = Callable[[str], Robot]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    with ExitStack() as stack:
        yield lambda modules: stack.enter_context(closing(Robot(tmp_path, modules)))


def module(name: str, way: str, **keys: Any) -> str:
    command = [sys.executable, "-m", "tests.misbehaving.module", way, name]
    lines = [f"{key} = {json.dumps(value)}" for key, value in keys.items()]
    return "\n".join([f"[modules.{name}]", f"command = {json.dumps(command)}", *lines, ""])


CRASHES = f"""[modules.bad]
command = {json.dumps([sys.executable, "-c", "import sys; sys.exit(7)"])}
start = "on demand"
restart_limit = 2
backoff_s = 0.1
"""


@pytest.fixture(scope="module")
def lasting_workshop(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """A daemon whose modules misbehave each in its way, once somebody starts them."""
    folder = tmp_path_factory.mktemp("workshop")
    modules = [
        module("hang", "hang", start="on demand", keep_alive_s=2.0),
        module("deaf", "deaf", start="on demand", ask_timeout_s=0.2, stop_timeout_s=0.6),
        module("leak", "leak", start="on demand", memory_limit_mb=150),
        module("fork", "fork", start="on demand"),
        module("undescribed", "no_description", start="on demand", capabilities=["VIS_VID"]),
        CRASHES,
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(folder))
        robot = Robot(folder, "".join(modules))
        robot.client.close()
        try:
            yield robot
        finally:
            robot.end()


@pytest.fixture
def workshop(lasting_workshop: Robot) -> Iterator[Robot]:
    """The daemon with a new client: central drops one that rests between two tests."""
    lasting_workshop.connect()
    yield lasting_workshop
    lasting_workshop.client.close()


@contextlib.contextmanager
def running(robot: Robot, name: str) -> Iterator[None]:
    """Start this module, and stop it at the end."""
    assert robot.order(name, supervision.ModuleOrder.START).done
    try:
        yield
    finally:
        assert robot.order(name, supervision.ModuleOrder.STOP).done
        robot.until(lambda: robot.phase(name) is ModulePhase.STOPPED)


def test_capability_runs_while_somebody_wants_it(start: Start) -> None:
    robot = start(module("one", "well", start="on demand", linger_s=0.5))
    robot.until(lambda: robot.modules["one"].asked)
    robot.until(lambda: "X_well" in robot.capabilities)
    assert robot.capabilities["X_well"].phase is CapabilityPhase.AVAILABLE
    assert robot.modules["one"].starts == 0
    with closing(Client("console", robot.endpoint)) as console:
        console.wait_connected(5.0)
        wants = supervision.CapabilityWants(holder="console", capabilities="X_well")
        console.publish(supervision.CAPABILITY_WANTS, wants)
        console.every(0.5, lambda: console.publish(supervision.CAPABILITY_WANTS, wants))

        def running() -> bool:
            console.listen(0.01)
            return robot.phase("one") is ModulePhase.RUNNING

        robot.until(running)
        assert robot.capabilities["X_well"].wanted_by == "console"
    left = time.monotonic()
    robot.until(lambda: robot.phase("one") is ModulePhase.STOPPED)
    assert time.monotonic() - left < supervision.LEASE_S + 5.0
    assert robot.modules["one"].why == "is wanted by nobody"


def test_module_that_crashes_is_replaced_and_its_capability_stays(start: Start) -> None:
    """The second module says that it can do what the first can, and does it well."""
    spare = module("spare", "crash_soon", start="on demand")
    spare += 'environment = { MISBEHAVE = "no" }\n'
    robot = start(module("bad", "crash_soon", start="always") + spare)
    robot.until(lambda: robot.phase("spare") is ModulePhase.RUNNING)
    robot.until(lambda: robot.capabilities["X_crash_soon"].module == "spare")
    assert robot.modules["bad"].starts >= 2  # more, where the other takes its time to start
    assert "spare does its work" in robot.modules["bad"].why
    assert "was ended by signal 11" in robot.log.read_text()


def test_module_that_crashes_at_every_start_is_reported_without_a_storm(workshop: Robot) -> None:
    with running(workshop, "bad"):
        workshop.until(lambda: workshop.phase("bad") is ModulePhase.FAILED)
        assert workshop.modules["bad"].starts == 3
        assert "exit code 7" in workshop.modules["bad"].why
        assert workshop.order("bad", supervision.ModuleOrder.START).done
        workshop.until(lambda: workshop.modules["bad"].starts == 6)


def test_module_that_hangs_is_started_anew(workshop: Robot) -> None:
    with running(workshop, "hang"):
        workshop.until(lambda: workshop.modules["hang"].starts >= 2)
        assert "hung: silent for 2 s" in workshop.log.read_text()


def test_module_that_is_deaf_is_killed(workshop: Robot) -> None:
    with running(workshop, "deaf"):
        workshop.until(lambda: workshop.phase("deaf") is ModulePhase.RUNNING)
        deaf_from = time.monotonic() + 0.7
        workshop.until(lambda: time.monotonic() > deaf_from)
        pid = workshop.modules["deaf"].pid
        assert workshop.order("deaf", supervision.ModuleOrder.RESTART).done
        workshop.until(lambda: workshop.modules["deaf"].starts == 2)
        assert not psutil.pid_exists(pid)


@pytest.mark.soak
def test_module_that_grows_is_started_anew(workshop: Robot) -> None:
    with running(workshop, "leak"):
        workshop.until(lambda: workshop.modules["leak"].starts >= 2)
        assert "MB and may take 150" in workshop.log.read_text()


def test_flood_of_output_is_cut_and_kept_within_bounds(start: Start) -> None:
    robot = start(module("one", "flood") + module("two", "well"))
    robot.until(lambda: "bytes were left out" in robot.log.read_text())
    request = supervision.LogRequest(module="one", most=5)
    lines = robot.client.query_response(
        supervision.LOG_REQUEST, request, supervision.LOG_LINES, timeout=5.0
    )
    assert lines.text.count("\n") == 5
    robot.until(lambda: robot.phase("two") is ModulePhase.RUNNING)
    assert robot.modules["one"].starts == 1
    assert (robot.folder / "logs" / "test" / "one.log").stat().st_size > 0


def test_what_a_module_has_forked_ends_with_it(workshop: Robot) -> None:
    """Also what has made itself a session of its own."""
    with running(workshop, "fork"):
        workshop.until(lambda: workshop.log.read_text().count("child ") == 2)
        words = workshop.log.read_text().split()
        pids = [int(words[place + 1]) for place, word in enumerate(words) if word == "child"]
        children = [psutil.Process(pid) for pid in pids]
    workshop.until(lambda: gone(children))


def test_deaf_module_ends_when_the_daemon_is_killed(start: Start) -> None:
    robot = start(module("one", "deaf"))
    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)
    deaf_from = time.monotonic() + 0.7
    robot.until(lambda: time.monotonic() > deaf_from)
    processes = family(robot.process.pid)
    robot.process.kill()
    until(lambda: gone(processes), 10.0, "it lives on")


def test_module_without_a_description_counts_for_what_the_file_says(workshop: Robot) -> None:
    until(lambda: "does not say what it can do" in workshop.log.read_text(), 20.0)
    assert "with --describe, but '{ no answer';" in workshop.log.read_text()
    assert workshop.modules["undescribed"].capabilities == "VIS_VID"
    assert not workshop.modules["undescribed"].asked


def test_common_commands_are_obeyed(start: Start) -> None:
    robot = start(module("one", "well"))

    def tell(command: CommonCommandKind, argument: str = "") -> None:
        value = CommonCommand(module="one", command=command, argument=argument)
        robot.client.publish(COMMON_COMMAND, value)

    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)
    pid, before = robot.modules["one"].pid, psutil.Process(robot.modules["one"].pid)
    tell(CommonCommandKind.LOG_LEVEL, "warning")
    tell(CommonCommandKind.RESTART)
    # It executes itself again: the same process, but anew.
    robot.until(lambda: robot.log.read_text().count("one connected") == 2)
    assert robot.modules["one"].pid == pid
    assert before.is_running()
    robot.client.wait_subscribed(5.0)
    tell(CommonCommandKind.STOP)
    robot.until(lambda: robot.phase("one") is ModulePhase.STOPPED)
    assert robot.modules["one"].why == "was stopped by order"
    tell(CommonCommandKind.START)
    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)


def test_systemd_is_told_and_modules_do_not_answer_for_the_daemon(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(tmp_path / "notify"))
        systemd.settimeout(0.0)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "400000")
        said: list[str] = []

        def listen() -> None:
            with contextlib.suppress(BlockingIOError):
                while True:
                    said.append(systemd.recv(4096).decode())

        robot = start(module("one", "well"))
        robot.until(lambda: listen() or any("one running" in text for text in said))
        robot.until(lambda: listen() or "WATCHDOG=1" in said)
        assert said[0].startswith("READY=1\n")
        environment = Path(f"/proc/{robot.modules['one'].pid}/environ").read_bytes()
        assert b"NOTIFY_SOCKET" not in environment
        robot.process.send_signal(signal.SIGTERM)
        until(lambda: listen() or "STOPPING=1" in said, 10.0)


def run(robot: Robot, *arguments: str) -> subprocess.CompletedProcess[str]:
    return rune_hub(*arguments, "--hub", robot.endpoint.removeprefix("tcp://"))


def test_commands_for_people(start: Start) -> None:
    robot = start(module("one", "well", start="on demand", linger_s=0.0))
    robot.until(lambda: robot.modules["one"].asked)
    assert "on demand" in run(robot, "modules").stdout
    assert "one has written nothing" in run(robot, "logs", "one").stderr
    shown = json.loads(run(robot, "capabilities", "--json").stdout)
    assert [each["name"] for each in shown["capabilities"]] == ["X_well"]
    wanted = run(robot, "want", "X_well", "NOTHING", "--seconds", "2.5")
    assert "X_well is running: one" in wanted.stdout
    assert "NOTHING: no module of this robot has it" in wanted.stdout
    assert wanted.returncode == 1
    asking = run(robot, "query", "GCM_Map_Request")
    assert (asking.returncode, "`rune-hub modules` shows" in asking.stderr) == (3, True)
    sent = run(robot, "send", "GCM_Night_Command", "on=1")
    assert (sent.returncode, "nobody listens to GCM_Night_Command" in sent.stderr) == (1, True)
    heard = run(robot, "send", "GCM_Common_Command", "module=nobody", "command=START")
    assert (heard.returncode, heard.stderr) == (0, "")
    assert run(robot, "start", "one").stdout == "one is started\n"
    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)
    assert "INFO ready" in run(robot, "logs", "one").stdout
    assert len(run(robot, "modules").stdout.splitlines()) == 2, "of one that runs nothing is told"
    for command in ("stop", "logs"):
        nobody = run(robot, command, "ome")
        assert "this robot has one; did you mean 'one'?" in nobody.stderr
        assert nobody.returncode == 2
    starts = robot.modules["one"].starts
    os.kill(robot.modules["one"].pid, signal.SIGKILL)
    robot.until(lambda: robot.modules["one"].starts > starts)
    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)
    said = "one runs again; it was ended by signal 9"
    assert run(robot, "modules").stdout.splitlines()[2:] == [said]
    assert run(robot, "stop", "one").returncode == 0
    robot.until(lambda: robot.phase("one") is ModulePhase.STOPPED)


def test_a_console_is_listed_as_a_visitor(start: Start) -> None:
    robot = start(module("one", "well"))
    info = supervision.ModuleInfo(
        name="rune-1-robot", pid=1, state="running", capabilities="CON_REAL"
    )
    robot.client.define(supervision.MODULE_INFO)
    robot.client.publish(supervision.MODULE_INFO, info)
    robot.until(lambda: "rune-1-robot" in robot.modules)
    robot.client.publish(supervision.MODULE_INFO, info)
    shown = run(robot, "modules").stdout
    assert "rune-1-robot is a console, a visitor" in shown
    (row,) = (line for line in shown.splitlines() if line.startswith("rune-1-robot  "))
    assert row.split()[1:4] == ["running", "visitor", "CON_REAL"]


def test_logs_are_followed(start: Start) -> None:
    robot = start(module("one", "well"))
    robot.until(lambda: robot.phase("one") is ModulePhase.RUNNING)
    hub = robot.endpoint.removeprefix("tcp://")
    follower = subprocess.Popen(
        [sys.executable, "-m", "hub", "logs", "one", "-f", "--hub", hub],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert follower.stdout is not None
    assert "INFO ready" in follower.stdout.readline()
    os.kill(robot.modules["one"].pid, signal.SIGKILL)
    assert "INFO ready" in follower.stdout.readline()
    follower.send_signal(signal.SIGINT)
    assert exit_code(follower, 10.0) == 0
    follower.stdout.close()


def test_many_signals_end_it_as_one_does(start: Start) -> None:
    robot = start(module("one", "well"))
    robot.until(lambda: robot.modules["one"].pid)
    for number in (signal.SIGINT, signal.SIGTERM) * 1500:
        robot.process.send_signal(number)
    exit_code(robot.process, 10.0)
    assert "robomon is gone: it said goodbye" in robot.log.read_text()
