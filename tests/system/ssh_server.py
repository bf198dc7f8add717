"""A real sshd on loopback with its own keys, and an `ssh` that goes to it."""

from __future__ import annotations

import getpass
import os
import shutil
import socket
import subprocess
from contextlib import suppress
from pathlib import Path

from tests.support.ports import free_port
from tests.support.waiting import until

_CONFIG = """
Port {port}
ListenAddress 127.0.0.1
HostKey {folder}/host
AuthorizedKeysFile {folder}/authorized
StrictModes no
UsePAM no
PasswordAuthentication no
KbdInteractiveAuthentication no
PermitRootLogin prohibit-password
PidFile {folder}/pid
AllowTcpForwarding {forwarding}
"""
_SSH = """#!/bin/sh
echo "$$ $(echo "$*" | tr "\\n" " ")" >> {folder}/calls
exec {ssh} -F none -oUserKnownHostsFile={folder}/known -oStrictHostKeyChecking=accept-new \\
    -oIdentityFile={folder}/{key} -oIdentitiesOnly=yes -oIdentityAgent=none "$@"
"""


_PROGRAMS = ("sshd", "ssh", "ssh-keygen")


def _found(program: str) -> str | None:
    return shutil.which(program, path=f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin")


def missing() -> str:
    """Why there can be none here; empty if there can."""
    lacking = ", ".join(program for program in _PROGRAMS if _found(program) is None)
    return f"there is no {lacking} here; apt-get install openssh-server" if lacking else ""


class SshServer:
    """It lets in whoever has the key in `folder`; `ssh` on `path` has it."""

    def __init__(self, folder: Path, *, forwarding: str = "yes", programs: str = "") -> None:
        self._sshd = _found("sshd")
        self._ssh = _found("ssh")  # before `path` may come first
        self.folder = folder
        folder.mkdir()
        self.port = free_port()
        for name in ("host", "key", "other"):
            command = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name)]
            subprocess.run(command, check=True)
        (folder / "authorized").write_text((folder / "key.pub").read_text())
        config = _CONFIG.format(port=self.port, folder=folder, forwarding=forwarding)
        # What commands there find: hubs, and programs besides the system's.
        paths = f" PATH={programs}:/usr/bin:/bin" if programs else ""
        config += f"SetEnv RUNE_RUNTIME_DIR={os.environ['RUNE_RUNTIME_DIR']}{paths}\n"
        (folder / "config").write_text(config)
        self.path = folder / "bin"
        self.path.mkdir()
        self.use_key("key")
        self.target = f"{getpass.getuser()}@127.0.0.1:{self.port}"
        self._process: subprocess.Popen[bytes] | None = None
        self.start()

    def use_key(self, key: str) -> None:
        """Have `ssh` show "key", which is known, or "other"."""
        program = self.path / "ssh"
        program.write_text(_SSH.format(folder=self.folder, ssh=self._ssh, key=key))
        program.chmod(0o755)

    def start(self) -> None:
        if os.getuid() == 0:
            with suppress(OSError):
                Path("/run/sshd").mkdir(exist_ok=True)  # sshd wants it when it is root
        with (self.folder / "log").open("ab") as log:
            self._process = subprocess.Popen(
                [self._sshd, "-D", "-e", "-f", str(self.folder / "config")],
                stdin=subprocess.DEVNULL,
                stderr=log,
            )
        until(self._listens, 10.0, (self.folder / "log").read_text)

    def _listens(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def pids(self) -> list[int]:
        """Every ssh that was started, the first first; they may have ended."""
        calls = self.folder / "calls"
        lines = calls.read_text().splitlines() if calls.exists() else []
        return [int(line.split()[0]) for line in lines]

    def running(self) -> list[int]:
        """Every ssh that runs."""
        return [pid for pid in self.pids() if _runs(pid)]

    def close(self) -> None:
        """End it, with its connections."""
        if self._process is not None:
            for pid in self.running():
                with suppress(OSError):
                    os.kill(pid, 9)
            self._process.kill()
            self._process.wait()
            self._process = None


def _runs(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"
