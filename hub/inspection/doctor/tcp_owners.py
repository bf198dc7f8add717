"""The process that listens at a TCP port of this machine, as far as Linux shows it."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

from hub.values import dataclass

_TABLES = ("/proc/net/tcp", "/proc/net/tcp6")
_LISTENS = "0A"
_SOCKET = re.compile(r"socket:\[(\d+)\]")
_LONGEST_NAME = 80


@dataclass(frozen=True, slots=True, kw_only=True)
class SocketOwner:
    """A process: its id, and its name and first arguments."""

    pid: int
    name: str


def listening_inodes(table: str, port: int) -> set[int]:
    """The sockets that listen at a port, by their inodes.

    Args:
        table: What proc_net_tcp(5) describes: after a heading a line a connection, with local
            address:port (hexadecimal), remote one, state, ..., and in the tenth column the inode.
        port: The TCP port.
    """
    inodes = set()
    for line in table.splitlines()[1:]:
        columns = line.split()
        if len(columns) < 10 or columns[3] != _LISTENS or not columns[9].isdigit():
            continue
        with contextlib.suppress(ValueError):
            if int(columns[1].rpartition(":")[2], 16) == port:
                inodes.add(int(columns[9]))
    return inodes


def owner(port: int) -> SocketOwner | None:
    """The process that listens at a TCP port; None: there is none, or the system hides it."""
    wanted: set[int] = set()
    for table in _TABLES:
        with contextlib.suppress(OSError):
            wanted |= listening_inodes(Path(table).read_text(), port)
    if not wanted:
        return None
    for pid in _processes():
        if wanted & set(_sockets(pid)):
            return SocketOwner(pid=pid, name=_name(pid))
    return None


def _processes() -> Iterator[int]:
    with contextlib.suppress(OSError):
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                yield int(entry.name)


def _sockets(pid: int) -> Iterator[int]:
    """Inodes of the open sockets of a process; none if it belongs to another user."""
    with contextlib.suppress(OSError):
        for file in Path(f"/proc/{pid}/fd").iterdir():
            with contextlib.suppress(OSError):  # it was closed meanwhile
                if found := _SOCKET.fullmatch(str(file.readlink())):
                    yield int(found[1])


def _name(pid: int) -> str:
    with contextlib.suppress(OSError):
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
        return b" ".join(words).decode(errors="replace").strip()[:_LONGEST_NAME]
    return ""
