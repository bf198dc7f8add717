"""Where the hubs of this machine have their sockets, and which of them a client means.

Each hub has a folder of its name in a folder of its user (`paths.for_hubs`, mode 0700). It holds
the socket for control messages, those of the planes, and a file with the process id. So other
users of the machine do not reach it, and neither does a page in a browser.

| a client asks for | it gets |
| --- | --- |
| the hub NAME | that of this name |
| any hub | the only one |
| any hub, preferably NAME | the only one, or of several that of this name |
"""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path
from typing import IO

from hub import paths
from hub.errors import EndpointError
from hub.values import dataclass

NAMED = "hub://"
"""Prefix of the name of a hub of this machine; without a name: the only one."""
PREFERRED = "?"
"""Mark before the name of a hub where the only one will do as well."""
SOCKET = "hub"
"""File name of the control socket; those of the planes have a number behind it."""
SOCKETS = (SOCKET, *(f"{SOCKET}.{number}" for number in range(1, 7)))
"""File names of all sockets: for control, and in and out of three planes (docs/protocol.md)."""
LONGEST_NAME = 32
"""Longest name of a hub [characters]."""
PROCESS = "pid"
"""File name of the process id."""
TCP = "tcp"
"""File name of the hub's address for clients with its token, if it has one."""
_RUN = Path("/run")
NOWHERE = f"ipc://{os.devnull}/{SOCKET}"
"""Address at which no hub can listen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningHub:
    """A hub of this machine and user.

    Attributes:
        name: Name of the robot, or the one given at its start.
        path: Its control socket.
    """

    name: str
    path: Path

    @property
    def endpoint(self) -> str:
        """Its address for clients."""
        return f"ipc://{self.path}"


def running() -> list[RunningHub]:
    """The hubs that run here as this user, by name."""
    found: dict[str, RunningHub] = {}
    for folder in paths.for_hubs():
        if not _is_own(folder):
            continue
        for path in sorted(folder.glob(f"*/{SOCKET}")):
            if path.parent.name not in found and runs(path.parent):
                found[path.parent.name] = RunningHub(name=path.parent.name, path=path)
    return sorted(found.values(), key=lambda hub: hub.name)


def address_of(endpoint: str) -> str:
    """The address behind an endpoint now; where its hub will be if it does not run yet.

    Args:
        endpoint: `hub://NAME`, `hub://?NAME`, `hub://`; or any other, which is its own address.

    Raises:
        EndpointError: Several hubs run, and none of them is meant.
    """
    if not endpoint.startswith(NAMED):
        return endpoint
    wanted = endpoint.removeprefix(NAMED)
    name = wanted.removeprefix(PREFERRED)
    hubs = running()
    for hub in hubs:
        if hub.name == folder_name(name):
            return hub.endpoint
    if wanted == name != "":
        return f"ipc://{paths.for_hubs()[0] / folder_name(name) / SOCKET}"
    if len(hubs) > 1:
        names = ", ".join(hub.name for hub in hubs[:8])
        text = f"{len(hubs)} hubs run on this machine ({names}); choose one with --hub NAME"
        raise EndpointError(text)
    return hubs[0].endpoint if hubs else NOWHERE


def tcp_of(endpoint: str) -> str:
    """The TCP address of the hub at an ipc:// address of this machine; empty: it has none."""
    path = Path(endpoint.removeprefix("ipc://"))
    try:
        return path.with_name(TCP).read_text()[:100].strip()
    except OSError:
        return ""


def folder_name(name: str) -> str:
    """The name of a hub as the name of its folder; short, as addresses of sockets are."""
    return paths.as_file_name(name[:LONGEST_NAME])


def runs(folder: Path) -> bool:
    """Whether the hub of a folder runs: it holds a lock on its file, also while it is stopped.

    A connection would tell the same, but a hub without processor time may not accept it, and counts
    one that says nothing.
    """
    try:
        import fcntl

        with (folder / PROCESS).open() as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except (OSError, ImportError):
        return False
    return False


class HubFolder:
    """The folder of one hub, from its start to its end.

    Attributes:
        path: The folder.
        tcp: The hub's address for clients with its token; empty: none.
    """

    def __init__(self, name: str) -> None:
        """Make it.

        Args:
            name: Of the robot.

        Raises:
            EndpointError: A hub of this name runs, or the folder cannot be made safely.
        """
        self.path = paths.for_hubs()[0] / folder_name(name)
        self.tcp = ""
        self._lock: IO[str] | None = None
        if process := process_at(NAMED + name):
            text = (
                f"a hub of the name {name} runs already (process {process}); end it, or give "
                "this one another name with --as"
            )
            raise EndpointError(text)
        for old in self.path.parent.glob(f"*/{PROCESS}"):
            if not runs(old.parent):  # of a hub that was killed
                _remove(old.parent)
        self._make()

    @property
    def endpoint(self) -> str:
        """Where clients of this machine connect, an ipc:// address."""
        return f"ipc://{self.path / SOCKET}"

    def publish_tcp(self, endpoint: str) -> None:
        """Tell clients of this machine the hub's address at TCP."""
        self.tcp = endpoint
        with contextlib.suppress(OSError):  # an argument can still name it
            (self.path / TCP).write_text(f"{endpoint}\n")

    def lost(self) -> bool:
        """Whether a file is gone: a cleaner, or the end of a login, removed it."""
        return not all((self.path / each).exists() for each in (PROCESS, *SOCKETS))

    def make_again(self) -> bool:
        """Make the folder again after it was removed; whether that can be done now."""
        try:
            self._make()
        except EndpointError:
            return False
        return True

    def close(self) -> None:
        """Remove the folder, after the hub's sockets are closed."""
        if self._lock is not None:
            self._lock.close()
        _remove(self.path)

    def _hold(self) -> None:
        """Write the process id into a file that is locked until this process ends."""
        import fcntl

        if self._lock is not None:
            self._lock.close()
        self._lock = (self.path / PROCESS).open("w")
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self._lock.write(f"{os.getpid()}\n")
        self._lock.flush()

    def _make(self) -> None:
        parent = self.path.parent
        try:
            parent.mkdir(mode=0o700, exist_ok=True)
        except OSError as error:
            text = f"no folder for sockets can be made in {parent.parent}: {error.strerror}"
            raise EndpointError(text) from error
        if not _is_own(parent):
            text = (
                f"{parent} must belong to this user and have mode 0700; see to that, or name "
                "another folder with RUNE_RUNTIME_DIR"
            )
            raise EndpointError(text)
        try:
            _remove(self.path)  # of a hub that was killed
            self.path.mkdir(mode=0o700)
            self._hold()
            if self.tcp:
                (self.path / TCP).write_text(f"{self.tcp}\n")
        except FileExistsError as error:
            text = f"{self.path} holds other files than a hub's; give another name with --as"
            raise EndpointError(text) from error
        except OSError as error:
            text = f"no folder for sockets can be made in {parent}: {error.strerror}"
            raise EndpointError(text) from error


def _remove(folder: Path) -> None:
    """Remove the folder of a hub that ended; a folder that holds other files stays as it is."""
    with contextlib.suppress(OSError):
        files = [] if folder.is_symlink() else list(folder.iterdir())
        if {each.name for each in files} <= {PROCESS, TCP, *SOCKETS}:
            for each in files:
                each.unlink(missing_ok=True)
            folder.rmdir()


def _is_own(folder: Path) -> bool:
    """Whether a folder is this user's, which others may not enter.

    Root may use those of others in /run, where the system makes them: in /tmp any user could.
    """
    try:
        found = folder.lstat()
    except OSError:
        return False
    user, others = os.geteuid(), stat.S_IRWXG | stat.S_IRWXO
    own = found.st_uid == user or (user == 0 and _RUN in folder.parents)
    return own and stat.S_ISDIR(found.st_mode) and not found.st_mode & others


def process_at(endpoint: str) -> str:
    """The process id of the running hub that an endpoint means; empty: none runs here.

    Raises:
        EndpointError: Several hubs run, and none of them is meant.
    """
    folder = Path(address_of(endpoint).removeprefix("ipc://")).parent
    if not runs(folder):
        return ""
    try:
        return (folder / PROCESS).read_text()[:10].strip()
    except OSError:
        return "not known"
