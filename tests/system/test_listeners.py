"""Every socket at which a program of Rune listens stands in the table of docs/security.md."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, closing
from fnmatch import fnmatchcase
from pathlib import Path

import psutil
import pytest

from tests.support.running_command import RunningCommand
from tests.support.waiting import until
from tests.system.harness import HubProcess, family

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


def check(program: str, pid: int) -> None:
    """All its listeners stand in the table, and all rows of it are seen."""
    patterns = table()[program]
    until(
        lambda: (
            {p for p in patterns if any(fnmatchcase(at, p) for at in listeners(pid))} == patterns
        ),
        10.0,
        lambda: f"{program} does not listen as the page says: {listeners(pid)}",
    )
    unknown = {at for at in listeners(pid) if not any(fnmatchcase(at, p) for p in patterns)}
    assert unknown == set(), f"{program} listens where the page does not say"


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


def test_a_hub_listens_as_the_page_says(tmp_path: Path, stack: ExitStack) -> None:
    hub = stack.enter_context(closing(HubProcess(tmp_path)))
    check("rune-hub run", hub.process.pid)


@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("rune-hub run --listen", ("run", "magellan", "--as", "listens", "--listen", "0")),
        ("rune-hub sim-ros", ("sim-ros", "--port", "0")),
        ("rune-hub sim-autopilot", ("sim-autopilot", "rover", "--tcp", "0")),
    ],
)
def test_a_program_listens_as_the_page_says(
    program: str, words: tuple[str, ...], stack: ExitStack
) -> None:
    started = stack.enter_context(closing(RunningCommand(*words)))
    check(program, started.process.pid)


def test_programs_beside_a_hub_listen_as_the_page_says(
    tmp_path: Path, stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Abstract sockets begin with the sign in this folder's name; files are none for it.
    runtime = stack.enter_context(tempfile.TemporaryDirectory(prefix="r@", dir="/tmp"))
    monkeypatch.setenv("RUNE_RUNTIME_DIR", runtime)
    hub = stack.enter_context(closing(HubProcess(tmp_path, options=("--listen", "0"))))
    for program, words in {
        "rune-hub serve foxglove": ("serve", "foxglove", "--port", "0"),
        "rune-hub shape": ("shape", "--profile", "lan"),
        "rune-hub record": ("record", "-o", str(tmp_path / "a.mcap")),
    }.items():
        started = stack.enter_context(closing(RunningCommand(*words, "--hub", hub.endpoint)))
        check(program, started.process.pid)
