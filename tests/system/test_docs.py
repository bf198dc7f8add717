"""Every command in the documentation works as it is written."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm import pad
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring, default_folder
from rune_tui.commands.arguments import parser
from rune_tui.commands.demo import ARENAS, AUTO
from rune_tui.startup.opening import open_layout
from tests.console.replay.logged_session import logged_session
from tests.support import warm_start
from tests.support.command_line import rune, rune_hub
from tests.support.recorded_drive import write_drive
from tests.support.ros_robot import SimulatedRos
from tests.support.waiting import exit_code, until
from tests.support.zenoh_router import zenoh_router
from tests.system.autopilot_site import SimulatedVehicle
from tests.system.harness import ConsoleProcess, HubProcess
from tests.system.ssh_server import SshServer, missing

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
HUB = {
    "modules": ("driver", "navigation", "vision", "mapping", "autonomy"),
    "options": ("--listen", "0"),
}
MODULES = {"rune": "rune_tui", "rune-hub": "hub"}


def commands(page: Path) -> Iterator[str]:
    """Lines after a $ in the page's console blocks."""
    for block in re.findall(r"^```console\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE):
        for line in block.splitlines():
            if line.startswith("$ "):
                yield line[2:].partition("  #")[0].strip()


EVERY = {command: page.name for page in reversed(PAGES) for command in commands(page)}
"""Each command once, however many pages have it, and the first of them."""
CHANGING = [
    command
    for command in EVERY
    if command.startswith(("rune-hub start ", "rune-hub stop ", "rune-hub restart "))
]
"""After these, a hub has other processes than before."""
MISSION = [command for command in EVERY if command.startswith("rune-hub mission ")]
"""These are about one mission, and come in the order of the page."""
LOG = [command for command in EVERY if command.startswith("rune-hub log ")]
"""These are about one recording, and come in the order of the page."""
RECORDING = [
    command for command in EVERY if command.startswith(("rune-hub record ", "rune-hub play "))
]
"""These are about one recorder, and come in the order of the page."""
STUDY = [command for command in EVERY if command.startswith("rune study ")]
"""These are about one study, and come in the order of the page."""
AUTOPILOT = [*commands(ROOT / "docs" / "autopilots.md")]
"""These are about one vehicle, and come in the order of the page."""
ROS = [*commands(ROOT / "docs" / "ros.md")]
"""These are about one robot, and come in the order of the page."""
ALONE = ("run", "keys", "check", "doctor", "service", "arena", "completion")
"""Commands of `rune-hub` that ask no hub."""


def asks_a_hub(command: str) -> bool:
    """Whether a command goes to a hub that runs already."""
    words = shlex.split(command)
    return (
        (words[0] == "rune-hub" and words[1] not in ALONE) or "--hub" in words or "--ssh" in words
    )


def named(found: Iterable[str]) -> list[Any]:
    return [pytest.param(command, id=f"{EVERY[command]}: {command}") for command in found]


_IN_ORDER = [*CHANGING, *MISSION, *RECORDING, *LOG, *STUDY, *AUTOPILOT, *ROS]
ON_A_HUB = [each for each in EVERY if each not in _IN_ORDER and asks_a_hub(each)]
BY_ITSELF = [each for each in EVERY if not (each in (*STUDY, *AUTOPILOT, *ROS) or asks_a_hub(each))]


def test_there_are_commands() -> None:
    assert len(BY_ITSELF) > 10
    assert len(ON_A_HUB) > 10
    assert sorted([*BY_ITSELF, *ON_A_HUB, *_IN_ORDER]) == sorted(EVERY)
    assert set(EVERY) == {command for page in PAGES for command in commands(page)}


def test_commands_that_change_processes_work(start_hub: Callable[..., HubProcess]) -> None:
    hub = start_hub(modules=("driver", *{shlex.split(command)[2] for command in CHANGING}))
    for command in CHANGING:
        done = rune_hub(*shlex.split(command)[1:], "--hub", hub.endpoint)
        assert done.returncode == 0, f"{command}: {done.stderr}"


def test_commands_of_missions_work(
    start_hub: Callable[..., HubProcess], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hub = start_hub(modules=("driver", "navigation", "mapping"))
    kept = str(hub.log.parent / "missions")
    for command in MISSION:
        words = shlex.split(command)[1:]
        reads = words[1] in ("list", "show", "export", "score")
        where = ("--folder", kept) if reads else ("--hub", hub.endpoint)
        done = rune_hub(*words, *where)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        if reads and words[1] != "export":
            assert "cellar, east" in done.stdout


def test_commands_of_recordings_work(
    start_hub: Callable[..., HubProcess], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    hub = start_hub(modules=("driver", "navigation", "recorder"))
    for command in RECORDING:
        words = shlex.split(command)[1:]
        done = rune_hub(*words, *(["--hub", hub.endpoint] if words[0] == "record" else []))
        assert done.returncode == 0, f"{command}: {done.stderr}"
    assert (tmp_path / "motion.mcap").stat().st_size > 0


def test_commands_on_recordings_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_drive(tmp_path / "drive.mcap")
    for command in LOG:
        done = rune_hub(*shlex.split(command)[1:])
        assert done.returncode == 0, f"{command}: {done.stderr}"
    assert (tmp_path / "tables/scout-GCM_Battery.csv").stat().st_size > 0


def test_commands_of_studies_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "studies", tmp_path / "studies")
    for command in STUDY:
        words = shlex.split(command)[1:]
        if words[1] not in ("run", "watch"):
            done = rune(*words)
            assert done.returncode == 0, f"{command}: {done.stderr}"
            continue
        _takes_a_session(words)


def test_commands_of_autopilots_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stack: contextlib.ExitStack
) -> None:
    monkeypatch.chdir(tmp_path)
    address = ""
    for command in AUTOPILOT:
        words = shlex.split(command.replace("tcp://127.0.0.1:5760", address))
        if words[:2] == ["rune-hub", "sim-autopilot"]:
            assert words[3:] == ["--fast-boot"], "as below"
            vehicle = stack.enter_context(closing(SimulatedVehicle(words[2])))
            address = f"tcp://127.0.0.1:{vehicle.port}"
        elif words[:2] == ["rune", "drive"]:
            _drives(words)
        elif words[:2] == ["rune-hub", "run"]:
            _starts_and_ends([*words[:2], str(tmp_path / words[2])], tmp_path)
        elif words[0] != "pip":
            done = rune_hub(*words[1:])
            assert done.returncode == 0, f"{command}: {done.stderr}"


def test_commands_of_robots_with_ros_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stack: contextlib.ExitStack
) -> None:
    monkeypatch.chdir(tmp_path)
    address = ""
    for command in ROS:
        words = shlex.split(command.replace("ws://127.0.0.1:8765", address))
        if words[:2] == ["rune-hub", "sim-ros"]:
            address = stack.enter_context(closing(SimulatedRos(tmp_path, *words[2:]))).address
        elif words[:2] == ["rune", "drive"]:
            with closing(ConsoleProcess(words[1:], columns=120, rows=40)) as console:
                console.wait_for_picture()
                assert console.quit() == 0
        elif words[:2] == ["rune-hub", "run"]:
            _starts_and_ends([*words[:2], str(tmp_path / words[2])], tmp_path)
        else:
            done = rune_hub(*words[1:])
            assert done.returncode == 0, f"{command}: {done.stderr}"


def _drives(words: list[str]) -> None:
    with closing(ConsoleProcess(words[1:], columns=120, rows=40)) as console:
        console.wait(lambda: "Enter opens the console" in console.text, 30.0)
        console.type("\r")
        console.wait(lambda: "DISARMED" in console.text, 20.0)
        assert console.quit() == 0


@pytest.mark.parametrize("command", named(BY_ITSELF))
def test_command_works(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = shlex.split(command)
    if words[0] == "make":
        targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
        assert words[1] in targets
    elif words[0] in ("git", "cd", "pip"):
        pass  # getting Rune is the business of a fresh machine, not of this test
    elif words[:2] == ["rune-hub", "run"]:
        _starts_and_ends(words, tmp_path)
    elif words[:2] == ["rune", "pad"]:
        _goes_in_by_a_key(words, tmp_path)
    elif words[:2] in (["rune", "demo"], ["rune", "run"]):
        _can_be_opened(words)
    elif words[:2] == ["rune", "replay"]:
        logged_session(tmp_path, 4.0).rename(tmp_path / words[2])
        monkeypatch.chdir(tmp_path)
        _replays(words)
    elif words[:2] == ["rune", "terminal"]:
        with closing(ConsoleProcess(words[1:])) as asking:
            assert asking.wait_ended() == 0
            assert "acknowledges  yes" in asking.text
    elif "--demo" in words:
        _succeeds(words, tmp_path)
    else:
        if words[:3] == ["rune-hub", "keys", "remove"]:
            Keyring(default_folder()).make(words[3], Role.OBSERVE)
        monkeypatch.chdir(tmp_path)
        done = (rune if words[0] == "rune" else rune_hub)(*_arguments(words))
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("command", named(ON_A_HUB))
def test_command_works_on_a_hub(
    command: str,
    lasting_hub: HubProcess,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words = shlex.split(command)
    if "--ssh" in words:
        _goes_through_ssh(words, lasting_hub, tmp_path, monkeypatch)
    elif words[0] == "rune-hub":
        _asks(words, lasting_hub, tmp_path, monkeypatch)
    else:
        assert words[:2] == ["rune", "run"]
        words[words.index("--hub") + 1] = lasting_hub.endpoint
        if "--set" in words:  # one for all; the others differ in what is read
            _shows_a_picture(words)
        else:
            _can_be_opened(words)


def _starts_and_ends(words: list[str], folder: Path) -> None:
    arguments = words[1:]
    log = folder / "log"
    with log.open("wb") as file:
        hub = warm_start.start(
            [sys.executable, "-m", "hub", *arguments],
            environment=os.environ,
            stdout=file.fileno(),
            stderr=file.fileno(),
            folder=ROOT,
        )
    until(lambda: "ready; Ctrl-C ends it" in log.read_text(), 20.0, log.read_text)
    hub.send_signal(signal.SIGINT)
    assert exit_code(hub, 15.0) == 0


def _arguments(words: list[str]) -> list[str]:
    """What follows the command, with the layouts where they are."""
    return [str(ROOT / word) if word.endswith(".xml") else word for word in words[1:]]


def _can_be_opened(words: list[str]) -> None:
    """The command is understood, and its layouts are good; consoles run in other tests."""
    options = parser().parse_args(_arguments(words))
    for layout in getattr(options, "layouts", None) or [options.layout]:
        if layout in (None, AUTO, *ARENAS):  # made for a robot, or the demo's own
            continue
        open_layout(layout, dict(options.set))


def _shows_a_picture(words: list[str]) -> None:
    """Started by another program, the console is an interpreter of its own from start to end."""
    arguments = _arguments(words)
    with closing(ConsoleProcess(arguments, within=["env"])) as console:
        console.wait_for_picture()
        assert console.quit() == 0


def _takes_a_session(words: list[str]) -> None:
    """It begins, or is watched, until it is left."""
    shown, key, code = ("Consent", "\x03", 1) if words[1] == "run" else ("b begin", "q", 0)
    with closing(ConsoleProcess(words, columns=80, rows=24)) as session:
        session.wait(lambda: shown in session.text, 20.0, "the session does not begin")
        session.type(key)
        assert session.wait_ended() == code


def _replays(words: list[str]) -> None:
    if "--export" in words:
        done = rune(*words[1:])
        assert done.returncode == 0, done.stderr
        return
    with closing(ConsoleProcess(words[1:], columns=80, rows=24)) as replay:
        replay.wait(lambda: "RECORDING" in replay.text, 20.0, "it shows nothing")
        assert replay.quit() == 0


def _goes_through_ssh(
    words: list[str], hub: HubProcess, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if why := missing():
        pytest.skip(f"NOT TESTED: {why}")
    with closing(SshServer(folder / "ssh")) as server:
        monkeypatch.setenv("PATH", f"{server.path}:{os.environ['PATH']}")
        place = words.index("--ssh") + 1
        words[place] = server.target
        # The robot's hub has another port here than the usual one.
        words[place + 1 : place + 1] = [*(["--hub"] if words[1] != "pad" else []), hub.endpoint]
        if words[1] == "run":  # `test_ssh` has a console drive through it
            _can_be_opened(words)
            return
        if words[1] == "pad":
            _connects_until_ended(words)
        else:
            _succeeds(words, folder)
        assert server.pids()


def _goes_in_by_a_key(words: list[str], folder: Path) -> None:
    keyring = Keyring(folder / "keys")
    gateway = curve_gateway("tcp://127.0.0.1:0", keyring)
    central = Central([f"ipc://{folder}/c"], gateways=[gateway])
    with closing(central), closing(Client("robot", central.endpoints[0])) as robot:
        robot.define(*pad.MESSAGES)  # as the daemon does
        robot.wait_connected(10.0)
        robot.wait_defined(10.0)
        words[2] = central.endpoints[1]
        words[words.index("--keys") + 1] = str(keyring.make("alice", Role.OPERATE))
        _connects_until_ended(words)


def _connects_until_ended(words: list[str]) -> None:
    with closing(ConsoleProcess(words[1:], columns=200)) as agent:
        agent.wait(lambda: "; connected to " in agent.text, 20.0, "it does not connect")
        agent.type("\x03")
        assert agent.wait_ended() == 0


def _asks(words: list[str], hub: HubProcess, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It says something of the hub, until Ctrl-C if it repeats."""
    words += ["--hub", hub.endpoint]
    if words[1:3] == ["serve", "foxglove"]:
        words += ["--port", "0"]
    if words[1:3] == ["serve", "ros2"]:
        with zenoh_router() as router:
            _repeats_until_ended([*words, "--connect", router.endpoint], folder)
        return
    if "-r" in words or words[1] == "serve" or words[1:3] == ["shape", "--profile"]:
        _repeats_until_ended(words, folder)
        return
    monkeypatch.chdir(folder)
    if "order=LOAD" in words:
        rune_hub(*(word.replace("order=LOAD", "order=SAVE") for word in words[1:]))
    done = rune_hub(*words[1:])
    assert done.returncode == 0, done.stderr


def _command(words: list[str]) -> list[str]:
    return [sys.executable, "-m", MODULES[words[0]], *_arguments(words)]


def _succeeds(words: list[str], folder: Path) -> None:
    done = warm_start.run(_command(words), folder=folder)
    assert done.returncode == 0, done.stderr


def _repeats_until_ended(words: list[str], folder: Path) -> None:
    """It goes on until Ctrl-C."""
    complaints = folder / "complaints"
    with complaints.open("wb") as file:
        process = warm_start.start(
            _command(words), environment=os.environ, stderr=file.fileno(), folder=folder
        )
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(1.5)
    process.send_signal(signal.SIGINT)
    assert exit_code(process, 10.0) == 0, complaints.read_text()
