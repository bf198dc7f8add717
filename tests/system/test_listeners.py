"""Every socket at which a program of Rune listens stands in the table of docs/security.md."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, closing
from fnmatch import fnmatchcase
from pathlib import Path

import psutil
import pytest

from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from tests.support.ports import free_port
from tests.support.ros_robot import SimulatedRos
from tests.support.running_command import RunningCommand
from tests.support.waiting import until
from tests.system.autopilot_site import vehicle_tables
from tests.system.conftest import LAYOUT
from tests.system.fleet_site import Site
from tests.system.harness import ConsoleProcess, HubProcess, Observer, family
from tests.system.ssh_server import SshServer, missing
from tests.system.test_play import PlayProcess

PAGE = Path(__file__).parents[2] / "docs/security.md"
_ROW = re.compile(r"^\| `(?P<program>[^`]+)` \| `(?P<listener>[^`]+)` \|", re.M)
_LISTENS = "00010000"
"""Flag of a listening socket in proc_net_unix(5)."""


def table() -> dict[str, set[str]]:
    """The patterns of listeners of each program, as the page has them."""
    rows: dict[str, set[str]] = {}
    for found in _ROW.finditer(PAGE.read_text()):
        rows.setdefault(found["program"], set()).add(found["listener"])
    return rows


def listeners(pid: int) -> set[str]:
    """Where a program and all that it has started listen."""
    return set().union(*(_of(each) for each in (psutil.Process(pid), *family(pid))))


def _of(process: psutil.Process) -> set[str]:
    try:
        return set(_sockets(process))
    except (psutil.NoSuchProcess, FileNotFoundError):
        return set()  # it has just ended


def _sockets(process: psutil.Process) -> Iterator[str]:
    for each in process.net_connections("inet"):
        listens = each.status == psutil.CONN_LISTEN
        udp = each.type.name == "SOCK_DGRAM" and not each.raddr
        if listens or udp:
            yield f"{'udp' if udp else 'tcp'}:{each.laddr.ip}:{each.laddr.port}"
    inodes = set()
    for file in Path(f"/proc/{process.pid}/fd").iterdir():
        if (target := str(file.readlink())).startswith("socket:["):
            inodes.add(target[8:-1])
    for line in Path(f"/proc/{process.pid}/net/unix").read_text().splitlines()[1:]:
        columns = line.split(maxsplit=7)
        if columns[6] in inodes and columns[3] == _LISTENS and len(columns) == 8:
            path = columns[7]
            yield (
                f"unix:{path}" if path.startswith("@") else f"unix:{'/'.join(path.split('/')[-2:])}"
            )


def check(pid: int, *programs: str) -> None:
    """All its listeners stand in the rows of these programs, and all of these are seen."""
    rows = table()
    patterns = set().union(*(rows[each] for each in programs))
    until(
        lambda: (
            {p for p in patterns if any(fnmatchcase(at, p) for at in listeners(pid))} == patterns
        ),
        20.0,
        lambda: f"{programs} does not listen as the page says: {listeners(pid)}",
    )
    unknown = {at for at in listeners(pid) if not any(fnmatchcase(at, p) for p in patterns)}
    assert unknown == set(), f"{programs} listens where the page does not say"


ALONE = {
    "rune-hub run --listen": ("run", "magellan", "--as", "listens", "--listen", "0"),
    "rune-hub sim-ros": ("sim-ros", "--port", "0"),
    "rune-hub sim-autopilot": ("sim-autopilot", "rover", "--tcp", "0"),
}
BESIDE = {
    "rune-hub serve foxglove": ("serve", "foxglove", "--port", "0"),
    "rune-hub shape": ("shape", "--profile", "lan"),
    "rune-hub record": ("record", "-o", "a.mcap"),
}
OTHERS = {
    "rune-hub run", "gateway", "rune-hub play", "rune-hub fleet router", "fleet mirror",
    "mavlink udp", "camera udp", "rune run --ssh", "rune drive --ssh ws://",
}  # fmt: skip


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


def test_each_row_of_the_page_has_a_test() -> None:
    assert table().keys() == ALONE.keys() | BESIDE.keys() | OTHERS


def test_a_hub_listens_as_the_page_says(tmp_path: Path, stack: ExitStack) -> None:
    hub = stack.enter_context(closing(HubProcess(tmp_path)))
    check(hub.process.pid, "rune-hub run")


def test_a_hub_with_a_gateway_listens_as_the_page_says(tmp_path: Path, stack: ExitStack) -> None:
    keys = tmp_path / "keys"
    Keyring(keys).make("alice", Role.OPERATE)
    lines = f'gateway = "tcp://127.0.0.1:{free_port()}"\nkeys = "{keys}"'
    hub = stack.enter_context(closing(HubProcess(tmp_path, gateway=lines)))
    check(hub.process.pid, "rune-hub run", "gateway")


def test_hubs_that_wait_for_datagrams_listen_as_the_page_says(
    tmp_path: Path, stack: ExitStack
) -> None:
    pytest.importorskip("av", reason="PyAV is not installed")
    camera = '[camera]\nsource = "udp://127.0.0.1:{}"\nfov_deg = 90.0\nheight = 0.5'
    vehicle = vehicle_tables("rover", free_port()).replace("tcp://", "udp://")
    for name, program, keys in (
        ("seen", "camera udp", {"tables": camera.format(free_port())}),
        ("flown", "mavlink udp", {"tables": vehicle, "kind": "mavlink", "modules": ("driver",)}),
    ):
        folder = tmp_path / name
        folder.mkdir()
        hub = stack.enter_context(closing(HubProcess(folder, **keys)))
        check(hub.process.pid, "rune-hub run", program)


@pytest.mark.parametrize("program", ALONE)
def test_a_program_listens_as_the_page_says(program: str, stack: ExitStack) -> None:
    started = stack.enter_context(closing(RunningCommand(*ALONE[program])))
    check(started.process.pid, program)


def test_programs_beside_a_hub_listen_as_the_page_says(
    tmp_path: Path, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Abstract sockets begin with the sign in this folder's name; files are none for it.
    runtime = stack.enter_context(tempfile.TemporaryDirectory(prefix="r@", dir="/tmp"))
    monkeypatch.setenv("RUNE_RUNTIME_DIR", runtime)
    monkeypatch.chdir(tmp_path)
    hub = stack.enter_context(closing(HubProcess(tmp_path, options=("--listen", "0"))))
    for program, words in BESIDE.items():
        started = stack.enter_context(closing(RunningCommand(*words, "--hub", hub.endpoint)))
        check(started.process.pid, program)


def test_a_player_listens_as_the_page_says(tmp_path: Path, stack: ExitStack) -> None:
    file = tmp_path / "a.mcap"
    with ExitStack() as recording:
        hub = recording.enter_context(closing(HubProcess(tmp_path, modules=("driver",))))
        words = ("record", "-o", str(file), "--hub", hub.endpoint)
        recording.enter_context(closing(RunningCommand(*words)))
        observer = recording.enter_context(closing(Observer(hub.endpoint)))
        observer.wait(lambda: len(observer.history) > 50, 20.0)
    player = stack.enter_context(closing(PlayProcess(file, "--as", "played", "--paused")))
    check(player.process.pid, "rune-hub play")


def test_programs_of_a_fleet_listen_as_the_page_says(tmp_path: Path, stack: ExitStack) -> None:
    site = stack.enter_context(closing(Site(tmp_path)))
    check(site.router.pid, "rune-hub fleet router")
    words = ("--fleet", "rune/lab", "--connect", site.place, "--as", "operate:ann")
    mirror = stack.enter_context(closing(RunningCommand("fleet", "mirror", *words)))
    check(mirror.process.pid, "fleet mirror")


def test_consoles_through_ssh_listen_as_the_page_says(
    tmp_path: Path, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    if why := missing():
        pytest.skip(f"NOT TESTED: {why}")
    server = stack.enter_context(closing(SshServer(tmp_path / "ssh", programs="/nonexistent")))
    monkeypatch.setenv("PATH", f"{server.path}:{os.environ['PATH']}")
    stack.enter_context(closing(HubProcess(tmp_path, name="over-ssh")))
    layout = tmp_path / "layout.xml"
    layout.write_text(LAYOUT.format(hub="hub://over-ssh"))
    robot = stack.enter_context(closing(SimulatedRos(tmp_path)))
    for program, words in {
        "rune run --ssh": ("run", "--ssh", server.target, str(layout)),
        "rune drive --ssh ws://": ("drive", "--ssh", server.target, robot.address),
    }.items():
        with closing(ConsoleProcess(words, columns=120, rows=40)) as console:
            console.wait_for_picture()
            # Where Rune is not installed on the robot, the hub runs here.
            check(console.process.pid, program, *["rune-hub run"] * ("drive" in words))
            assert console.quit() == 0
