"""The daemon: starts everything, keeps it alive, ends it in order, leaves nothing behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from hub.gcm import navigation, vision
from tests.system.harness import HubProcess, Observer, family, gone
from tests.waiting import until


def _nothing_left(hub: HubProcess, processes: list[psutil.Process]) -> None:
    until(lambda: gone(processes), 10.0, "processes are left")
    host, _, port = hub.endpoint.removeprefix("tcp://").partition(":")
    with socket.socket() as probe:
        assert probe.connect_ex((host, int(port))) != 0


def test_starts_a_process_for_each_module(hub: HubProcess) -> None:
    assert set(hub.pids) == {"driver", "navigation", "vision"}
    assert len({hub.process.pid, *hub.pids.values()}) == 4


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ends_in_order_on_a_signal(hub: HubProcess, number: signal.Signals) -> None:
    processes = family(hub.process.pid)
    hub.process.send_signal(number)
    assert hub.process.wait(15.0) == 0
    _nothing_left(hub, processes)
    log = hub.log.read_text()
    stops = [line.split()[2] for line in log.splitlines() if "INFO stopped" in line]
    assert stops == ["vision", "navigation", "driver"]
    assert "Traceback" not in log


def test_socket_files_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runtime = tmp_path / "run"
    runtime.mkdir()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    hub = HubProcess(tmp_path)
    assert list(runtime.rglob("central*"))
    hub.close()
    assert not list(runtime.iterdir())


def test_modules_end_when_the_daemon_is_killed(hub: HubProcess) -> None:
    processes = family(hub.process.pid)
    hub.process.kill()
    _nothing_left(hub, processes)


@pytest.mark.parametrize("module", ["driver", "navigation", "vision"])
def test_a_killed_module_is_started_again_and_works(
    hub: HubProcess, observer: Observer, module: str
) -> None:
    os.kill(hub.pids[module], signal.SIGKILL)
    until(lambda: f"{module} was ended by signal 9" in hub.log.read_text(), 5.0)
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


def test_a_module_that_always_crashes_is_given_up(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    misbehaving = Path(__file__).parents[1] / "misbehaving" / "crash_on_start.py"
    robot.write_text(
        'name = "x"\nkind = "simulated-magellan"\n[hub]\nport = 0\n[modules.bad]\n'
        f'command = ["{sys.executable}", "{misbehaving}"]\nrestart_limit = 2\n'
    )
    daemon = subprocess.Popen(
        [sys.executable, "-m", "hub", "run", str(robot)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert daemon.stderr is not None
    lines: list[str] = []
    for line in daemon.stderr:
        lines.append(line)
        if "given up" in line:
            break
    daemon.send_signal(signal.SIGINT)
    _, rest = daemon.communicate(timeout=10.0)
    assert sum("started (pid" in line for line in lines) == 3
    assert daemon.returncode == 1
    assert "Traceback" not in rest


def test_a_module_that_ignores_sigterm_is_killed(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    misbehaving = Path(__file__).parents[1] / "misbehaving" / "ignores_sigterm.py"
    robot.write_text(
        'name = "x"\nkind = "simulated-magellan"\n[hub]\nport = 0\n[modules.stubborn]\n'
        f'command = ["{sys.executable}", "{misbehaving}"]\nstop_timeout_s = 0.5\n'
    )
    daemon = subprocess.Popen(
        [sys.executable, "-m", "hub", "run", str(robot)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert daemon.stderr is not None
    for line in daemon.stderr:
        if "stubborn is ready" in line:
            break
    started = time.monotonic()
    processes = family(daemon.pid)
    daemon.send_signal(signal.SIGINT)
    daemon.communicate(timeout=10.0)
    assert time.monotonic() - started >= 0.5
    until(lambda: gone(processes), 5.0, "it lives on")


def test_state_comes_at_its_nominal_rate(start_hub: Callable[..., HubProcess]) -> None:
    hub = start_hub()
    watch = Observer(hub.endpoint, navigation.ROBOT_STATE)
    seen = watch.seen[navigation.ROBOT_STATE.name]
    seen.clear()
    watch.wait(lambda: len(seen) >= 20, 10.0)
    watch.close()
    gaps = [later[0] - earlier[0] for earlier, later in zip(seen, list(seen)[1:], strict=False)]
    # A loose bound: this machine may be busy. `rune-hub rate` shows the real figure.
    assert sorted(gaps)[len(gaps) // 2] < 3.0 / navigation.ROBOT_STATE.rate_hz
