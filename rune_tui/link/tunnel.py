"""Tunnels to a robot through ssh, restarted when ssh ends, closed with the console.

A hub's sockets appear as files in a folder that only this user may enter, without a port. So no
other user of this machine can drive the robot. A bridge's port appears as a port of loopback.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from hub.plain_text import plain
from rune_tui.errors import TunnelError

OPEN_WITHIN_S: Final = 60.0
"""Time for a connection, and for the operator to type a password [s]."""
_END_WITHIN_S: Final = 3.0
_LOOK_S: Final = 0.05
_LOOPBACK: Final = "127.0.0.1"
_RETRY_S, _LONGEST_RETRY_S = 1.0, 15.0
SSH_OPTIONS: Final = {
    # A connection of its own: a shared one would end with, and outlive, another program's.
    "ControlMaster": "no",
    "ControlPath": "none",
    "ExitOnForwardFailure": "yes",
    "StreamLocalBindUnlink": "yes",
    "StreamLocalBindMask": "0177",
    "ConnectTimeout": "10",
    # ssh detects a dead link within 9 s; the console itself within 1.5 s.
    "ServerAliveInterval": "3",
    "ServerAliveCountMax": "3",
    "TCPKeepAlive": "yes",
    "ForwardAgent": "no",
    "ForwardX11": "no",
    "PermitLocalCommand": "no",
    "LogLevel": "ERROR",
}
_GUARD: Final = """
trap '' HUP INT
exec 3<&0
"$@" 3<&- </dev/null &
child=$!
trap 'kill $child 2>/dev/null' TERM
{ read -r _ <&3 || rm -rf -- "$0"; kill $child; } 2>/dev/null &
guard=$!
exec 3<&-
wait $child
code=$?
kill $guard 2>/dev/null
exit $code
"""
"""Runs ssh, and ends it after a line on standard input, or when that ends, as it does when the
console is killed; then the folder, which is the script's name, goes too.
"""
MOST_WORDS: Final = 500
"""Longest excerpt of ssh's last words [characters]."""
_DESTINATION: Final = re.compile(r"([^\s:@-][^\s:]*?)(?::([0-9]{1,5}))?")


def ssh_command(destination: str, *options: str, shared: Path | None = None) -> list[str]:
    """The command that goes to a robot, without what it does there.

    Args:
        destination: Destination of ssh, [USER@]HOST[:PORT].
        options: Of ssh.
        shared: Socket of a connection that this one shares, or makes; None: one of its own.

    Raises:
        TunnelError: This is no destination, or there is no ssh.
    """
    matched = _DESTINATION.fullmatch(destination)
    if matched is None:
        text = f"{destination!r} is no USER@HOST or USER@HOST:PORT to go to by ssh"
        raise TunnelError(text)
    if not (shutil.which("ssh") and shutil.which("sh")):
        text = "--ssh needs ssh, which is not installed here; install OpenSSH's client"
        raise TunnelError(text)
    host, port = matched.groups()
    own = {"ControlPath": str(shared)} if shared else {}
    return [
        *("ssh", "-T"),
        *(f"-o{name}={value}" for name, value in {**SSH_OPTIONS, **own}.items()),
        *options,
        *(("-p", port) if port else ()),
        *("--", host),
    ]


class SshTunnel:
    """Ends on this machine that lead to ends on a robot, kept open by a thread.

    Attributes:
        destination: As the operator wrote it: USER@HOST, HOST, with :PORT behind it if needed.
    """

    def __init__(self, destination: str, ends: Callable[[Path], Mapping[str, str]]) -> None:
        """Prepare.

        Args:
            destination: Destination of ssh, [USER@]HOST[:PORT].
            ends: The ends here, as files in a folder or as PORT, and where each leads.

        Raises:
            TunnelError: This is no destination, or there is no ssh.
        """
        ssh_command(destination)
        self.destination = destination
        self._folder = Path(tempfile.mkdtemp(prefix="rune-"))  # mkdtemp admits only this user
        self._ends = ends(self._folder)
        self._process: subprocess.Popen[bytes] | None = None
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="ssh", daemon=True)
        self._trouble = ""

    @property
    def shown(self) -> str:
        """What it is, for people."""
        return f"ssh {self.destination}"

    @property
    def trouble(self) -> str:
        """Why the tunnel is closed now, in one sentence; empty: it is open."""
        return self._trouble

    @property
    def may_command(self) -> bool:
        """It does; the robot's hub sees a client of its own machine."""
        return True

    def next_notice(self) -> str:
        """None: the console itself sees how slow a tunnel is."""
        return ""

    def open(self) -> None:
        """Open it and keep it open; ssh may ask for a password, on the terminal.

        Raises:
            TunnelError: It cannot be opened; the text has ssh's own last words.
        """
        try:
            self._start()
            self._wait(OPEN_WITHIN_S)
        except BaseException:
            self.close()
            raise
        self._thread.start()

    def close(self) -> None:
        """End it."""
        self._ending.set()
        self._stop()
        if self._thread.is_alive():
            self._thread.join()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start(self, *options: str) -> None:
        self._stop()
        for end in self._ends:
            if end.startswith("/"):
                Path(end).unlink(missing_ok=True)
        command = self._command(*options)
        with (self._folder / "ssh.log").open("wb") as log:
            # The shell has this thread's signals, and misses the end of ssh if they are blocked.
            if hasattr(signal, "pthread_sigmask"):
                signal.pthread_sigmask(signal.SIG_UNBLOCK, signal.valid_signals())
            self._process = subprocess.Popen(
                ["sh", "-c", _GUARD, str(self._folder), *command],
                stdin=subprocess.PIPE,
                bufsize=0,
                stdout=subprocess.DEVNULL,
                stderr=log,
            )

    def _command(self, *options: str) -> list[str]:
        """The ssh that makes the ends and keeps them."""
        forwards = [f"-L{_address(near)}:{far}" for near, far in self._ends.items()]
        return ssh_command(self.destination, "-N", *forwards, *options)

    def _prepare(self) -> None:
        """Do what has to come before the ends are there.

        Raises:
            TunnelError: It cannot be done.
        """

    def _stop(self) -> None:
        process = self._process
        if process is None or process.stdin is None:
            return
        with contextlib.suppress(OSError, ValueError):  # it has ended, or was stopped before
            process.stdin.write(b"\n")
        process.stdin.close()
        try:
            process.wait(_END_WITHIN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _wait(self, seconds: float) -> None:
        """Wait until all ends are there.

        Raises:
            TunnelError: Ssh ended, or it took too long.
        """
        end = time.monotonic() + seconds
        while not all(map(_is_there, self._ends)):
            if self._process is None or self._process.poll() is not None:
                text = f"ssh to {self.destination} failed: {self._last_words()}"
                raise TunnelError(text)
            self._prepare()
            if time.monotonic() > end:
                text = f"ssh to {self.destination} made no connection in {seconds:.0f} s"
                raise TunnelError(text)
            if self._ending.wait(_LOOK_S):
                return

    def _keep(self) -> None:
        """Reopen it each time that ssh ends, without questions."""
        pause = _RETRY_S
        while self._ended():
            self._trouble = f"ssh to {self.destination} ended: {self._last_words()}; trying again"
            while not self._ending.wait(pause):
                try:
                    self._start("-oBatchMode=yes")
                    self._wait(OPEN_WITHIN_S)
                except (TunnelError, OSError) as error:
                    self._trouble = str(error)
                    pause = min(_LONGEST_RETRY_S, 2.0 * pause)
                    self._stop()
                else:
                    self._trouble, pause = "", _RETRY_S
                    break
        self._stop()

    def _ended(self) -> bool:
        """Wait for ssh to end; whether it ended by itself."""
        if self._process is not None:
            self._process.wait()
        return not self._ending.is_set()

    def _last_words(self) -> str:
        try:
            said = (self._folder / "ssh.log").read_text(errors="replace").split("\n")
        except OSError:
            said = []
        words = [line.strip() for line in said if line.strip()]
        return plain(words[-1])[:MOST_WORDS].rstrip(".") if words else "it says nothing of why"


class PortTunnel(SshTunnel):
    """A tunnel to a port on a robot, or on a machine that the robot reaches.

    Attributes:
        port: The port of loopback on this machine.
    """

    def __init__(self, destination: str, host: str, port: int) -> None:
        """Prepare.

        Args:
            destination: Destination of ssh, [USER@]HOST[:PORT].
            host: Where the port is, as seen from the robot.
            port: The port.

        Raises:
            TunnelError: This is no destination, or there is no ssh.
        """
        with socket.socket() as probe:
            probe.bind((_LOOPBACK, 0))
            self.port: int = probe.getsockname()[1]
        far = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        super().__init__(destination, lambda _: {str(self.port): far})


def _address(end: str) -> str:
    """An end here as ssh has it."""
    return end if end.startswith("/") else f"{_LOOPBACK}:{end}"


def _is_there(end: str) -> bool:
    """Whether ssh has opened an end here."""
    if end.startswith("/"):
        return Path(end).exists()
    with socket.socket() as probe:
        return probe.connect_ex((_LOOPBACK, int(end))) == 0
