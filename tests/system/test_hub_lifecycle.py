"""The daemon: starts everything, keeps it alive, ends it in order, leaves nothing behind."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from hub.gcm import navigation, vision
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.geometry import TwistStamped
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from tests.support.waiting import exit_code, until
from tests.system.harness import MODULES, HubProcess, Observer, family, gone, in_soak, robot_file


def _nothing_left(hub: HubProcess, processes: list[psutil.Process]) -> None:
    until(lambda: gone(processes), 10.0, "processes are left")
    with socket.socket(socket.AF_UNIX) as probe:
        assert probe.connect_ex(hub.endpoint.removeprefix("ipc://")) != 0


@pytest.mark.parametrize("number", [signal.SIGTERM, *in_soak(signal.SIGINT)])
def test_ends_in_order_on_a_signal(hub: HubProcess, number: signal.Signals) -> None:
    processes = family(hub.process.pid)
    hub.process.send_signal(number)
    assert exit_code(hub.process, 15.0) == 0
    _nothing_left(hub, processes)
    log = hub.log.read_text()
    told = [line.split()[-1] for line in log.splitlines() if " stopping " in line]
    ended = {line.split()[2] for line in log.splitlines() if "INFO stopped" in line}
    assert told == [*reversed(MODULES)]
    assert ended == set(MODULES)
    assert "Traceback" not in log


@pytest.fixture
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for socket files with a short name, as systems give one."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("RUNE_RUNTIME_DIR", folder)
        yield Path(folder)


def test_a_killed_module_is_started_again_and_works(hub: HubProcess, observer: Observer) -> None:
    for module in MODULES:
        os.kill(hub.pids[module], signal.SIGKILL)
        ended = f"{module} was ended by signal 9"
        observer.wait(lambda ended=ended: ended in hub.log.read_text(), 5.0)
        watch = Observer(hub.endpoint, navigation.ROBOT_STATE, vision.CAMERA_STATE)
        watch.close()
    picture = observer.client.query_response
    answers = []

    def works() -> bool:
        try:
            request = vision.ImageRequest(width_px=16, height_px=12)
            answers.append(picture(vision.IMAGE_REQUEST, request, vision.IMAGE, timeout=1.0))
        except Exception:  # noqa: BLE001 - not there yet
            return False
        return True

    until(works, 10.0, "no picture comes")
    assert answers[-1].width_px == 16


def _program(name: str) -> str:
    return f'command = ["{sys.executable}", "{Path(__file__).parents[1] / "misbehaving" / name}"]'


def test_it_gives_up_a_module_that_always_crashes_and_ends_those_that_do_not_want_to(
    tmp_path: Path,
) -> None:
    """One ignores SIGTERM, and one has started another program."""
    robot, log, pids = tmp_path / "robot.toml", tmp_path / "log", tmp_path / "pids"
    script = f"sleep 300 & echo $! > {pids}; exec sleep 300"
    robot.write_text(
        'name = "x"\nkind = "simulated-magellan"\n'
        f"[modules.bad]\n{_program('crash_on_start.py')}\nrestart_limit = 2\n"
        f"[modules.stubborn]\n{_program('ignores_sigterm.py')}\nstop_timeout_s = 0.5\n"
        f'[modules.parent]\ncommand = ["/bin/sh", "-c", "{script}"]\n'
    )
    with log.open("w") as said:
        daemon = subprocess.Popen(
            [sys.executable, "-m", "hub", "run", str(robot)], stdout=subprocess.DEVNULL, stderr=said
        )
    try:
        until(lambda: "given up" in log.read_text(), 20.0, log.read_text)
        until(lambda: "stubborn is ready" in log.read_text(), 10.0, log.read_text)
        until(lambda: pids.exists() and pids.read_text().strip(), 10.0)
        processes = family(daemon.pid)
        assert int(pids.read_text()) in [each.pid for each in processes]
        started = time.monotonic()
    finally:
        daemon.send_signal(signal.SIGINT)
        code = exit_code(daemon, 15.0)
    assert time.monotonic() - started >= 0.5
    until(lambda: gone(processes), 5.0, "some live on")
    assert code == 1
    lines = log.read_text().splitlines()
    assert sum("bad started (pid" in line for line in lines) == 3, lines
    assert "Traceback" not in log.read_text()


def test_a_module_that_hangs_does_not_keep_the_robot_driving(
    hub: HubProcess, observer: Observer
) -> None:
    driver = Observer(hub.endpoint, navigation.ROBOT_STATE)
    twist = TwistStamped.planar(0.4, 0.0)
    states = driver.seen[navigation.ROBOT_STATE.name]

    def send(value: TwistStamped) -> None:
        driver.client.publish(navigation.VELOCITY_COMMAND, value)
        driver.client.listen(0.02)

    def drive() -> None:
        send(twist)

    until(
        lambda: states[-1][1].motion is navigation.MotionState.STANDING,
        10.0,
        meanwhile=lambda: send(TwistStamped()),
    )

    until(lambda: observer.truth.linear > 0.3, 10.0, meanwhile=drive)
    os.kill(hub.pids["vision"], signal.SIGSTOP)
    hub.process.send_signal(signal.SIGINT)
    signalled = time.monotonic()
    until(
        lambda: observer.history[-1][1].commanded_linear == 0.0 or hub.process.poll() is not None,
        5.0,
        meanwhile=lambda: (drive(), observer.client.listen(0.0)),
    )
    assert time.monotonic() - signalled < 1.5  # 2 s is what the module that hangs may take
    exit_code(hub.process, 15.0)
    driver.close()


def test_a_log_that_nobody_reads_does_not_stop_the_hub(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(robot_file(modules=("driver",)))
    unread, log = os.pipe()
    os.set_blocking(log, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(log, bytes(4096))
    os.set_blocking(log, True)
    daemon = subprocess.Popen(
        [sys.executable, "-m", "hub", "run", str(robot), "--json"],
        stdout=subprocess.PIPE,
        stderr=log,
        text=True,
    )
    assert daemon.stdout is not None
    try:
        endpoint = json.loads(daemon.stdout.readline())["hub"]
        watch = Observer(endpoint)
        for _ in range(30):
            Observer(endpoint).close()  # each is worth two lines in the log
        assert watch.truth.time > 0.0
        watch.close()
        daemon.send_signal(signal.SIGINT)
        assert exit_code(daemon, 10.0) == 0
    finally:
        daemon.kill()
        daemon.stdout.close()
        os.close(unread)
        os.close(log)


def test_of_a_killed_daemon_modules_end_and_socket_folders_are_swept(
    tmp_path: Path, runtime: Path
) -> None:
    first = HubProcess(tmp_path)
    processes = family(first.process.pid)
    first.process.kill()
    _nothing_left(first, processes)
    first.close()
    (left,) = runtime.iterdir()
    second = HubProcess(tmp_path, modules=("driver",))
    assert left not in list(runtime.iterdir())
    second.close()


def _forked(pid: int) -> bool:
    return psutil.Process(pid).name().startswith("rune-")


def _killed(hub: HubProcess, observer: Observer, module: str) -> int:
    """Kill a module; the process id of the next one, when it is ready."""
    log = hub.log.read_text()
    before = log.count(f"{module} INFO ready")
    old = int(re.findall(rf"{module} started \(pid (\d+)\)", log)[-1])
    os.kill(old, signal.SIGKILL)
    observer.wait(lambda: hub.log.read_text().count(f"{module} INFO ready") > before, 20.0)
    return int(re.findall(rf"{module} started \(pid (\d+)\)", hub.log.read_text())[-1])


def test_a_killed_parent_takes_no_module_with_it_and_is_replaced(
    hub: HubProcess, observer: Observer
) -> None:
    children = {each.pid: each for each in psutil.Process(hub.process.pid).children()}
    (parent,) = (
        each
        for pid, each in children.items()
        if pid not in hub.pids.values() and "hub" in each.cmdline()
    )
    assert all(map(_forked, hub.pids.values()))
    parent.kill()
    spawned = _killed(hub, observer, "vision")
    assert not _forked(spawned)
    observer.wait(lambda: "another one is ready" in hub.log.read_text(), 20.0)
    forked = _killed(hub, observer, "navigation")
    assert _forked(forked)
    for pid in (hub.pids["driver"], spawned, forked):
        assert psutil.Process(pid).is_running()
    assert _killed(hub, observer, "driver") != hub.pids["driver"]


def test_a_hub_that_spawns_has_no_parent_of_modules(tmp_path: Path) -> None:
    hub = HubProcess(tmp_path, options=["--spawn"], modules=("driver",))
    try:
        assert not _forked(hub.pids["driver"])
        assert len(family(hub.process.pid)) == 3  # with the orphan reaper
    finally:
        hub.close()


def test_says_where_holders_of_keys_from_elsewhere_connect_and_removes_its_sockets(
    tmp_path: Path, runtime: Path
) -> None:
    keys = tmp_path / "keys"
    path = Keyring(keys).make("one", Role.OBSERVE)
    lines = f'gateway = "tcp://127.0.0.1:0"\nkeys = "{keys}"'
    hub = HubProcess(tmp_path, modules=("driver",), gateway=lines)
    try:
        assert len(list(runtime.rglob("hub*"))) == 7
        with contextlib.closing(
            Client("one", hub.listening["gateway"], keys=read_client_keys(path))
        ) as client:
            client.wait_connected(5.0)
    finally:
        hub.close()
    assert not list(runtime.iterdir())


def test_starts_a_process_for_each_module(lasting_hub: HubProcess) -> None:
    hub = lasting_hub
    assert set(hub.pids) == set(MODULES)
    assert len({hub.process.pid, *hub.pids.values()}) == 1 + len(MODULES)


def test_state_comes_at_its_nominal_rate(lasting_hub: HubProcess) -> None:
    watch = Observer(lasting_hub.endpoint, navigation.ROBOT_STATE)
    seen = watch.seen[navigation.ROBOT_STATE.name]
    seen.clear()
    watch.wait(lambda: len(seen) >= 20, 10.0)
    watch.close()
    gaps = [later[0] - earlier[0] for earlier, later in zip(seen, list(seen)[1:], strict=False)]
    # A loose bound: this machine may be busy. `rune-hub rate` shows the real figure.
    assert sorted(gaps)[len(gaps) // 2] < 3.0 / navigation.ROBOT_STATE.rate_hz


def test_who_comes_late_is_told_what_the_robot_is(lasting_hub: HubProcess) -> None:
    bodies: list[RobotBody] = []
    with contextlib.closing(Client("late", lasting_hub.endpoint)) as client:
        client.subscribe(ROBOT_DESCRIPTION, lambda body, _: bodies.append(body), last=True)
        until(lambda: bodies, 10.0, meanwhile=lambda: client.listen(0.05))
    assert bodies[0].kind == "simulated-magellan"
    assert bodies[0].radius == pytest.approx(0.203)
