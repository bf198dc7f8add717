"""Reports the daemon's state to systemd by sd_notify(3): datagrams on a Unix socket."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Mapping

_PART = 0.5
"""Part of the watchdog's time between two reports, as sd_watchdog_enabled(3) advises."""
_LONGEST_STATUS = 500
_READY_WAIT_S = 1.0
"""Longest wait of `ready` for room: systemd would end a service without this report [s]."""


class Notifier:
    """Reports to the daemon's supervisor; without one, it does nothing.

    No method raises, and only `ready` may wait, for `_READY_WAIT_S`: a robot must not stop because
    its supervisor does not listen.

    Attributes:
        period: Period for `alive` [s]; None: no watchdog.
    """

    def __init__(self, address: str = "", period: float | None = None) -> None:
        """Notify at `address`: a path, or @ and an abstract name; empty: no listener."""
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self.period = period if address else None

    @staticmethod
    def from_environment(environment: Mapping[str, str], pid: int) -> Notifier:
        """The notifier that systemd's variables describe.

        Args:
            environment: `NOTIFY_SOCKET`, `WATCHDOG_USEC` [us] and `WATCHDOG_PID`; a missing or
                malformed one switches the report off.
            pid: Of this process; the watchdog may be another one's.
        """
        address = environment.get("NOTIFY_SOCKET", "")
        if address[:1] not in ("/", "@"):
            return Notifier()
        wanted, meant = environment.get("WATCHDOG_USEC", ""), environment.get("WATCHDOG_PID", "")
        period = None
        if _is_number(wanted) and int(wanted) > 0 and meant in ("", str(pid)):
            period = int(wanted) * 1e-6 * _PART
        return Notifier(address, period)

    def ready(self, status: str) -> None:
        """Report that the hub is reachable.

        This does not wait for the modules. systemd ends a service that is not ready in time, and a
        broken camera must not end the robot.
        """
        self._send("READY=1", f"STATUS={_one_line(status)}", longest_wait=_READY_WAIT_S)

    def stopping(self) -> None:
        """Report the start of the end."""
        self._send("STOPPING=1")

    def status(self, text: str) -> None:
        """Report one line for `systemctl status`."""
        self._send(f"STATUS={_one_line(text)}")

    def alive(self) -> None:
        """Restart the watchdog's time."""
        self._send("WATCHDOG=1")

    def _send(self, *lines: str, longest_wait: float = 0.0) -> None:
        if not self._address:
            return
        # ValueError: an address may hold what a path cannot.
        with contextlib.suppress(OSError, ValueError):
            kind = socket.SOCK_DGRAM | socket.SOCK_CLOEXEC
            with socket.socket(socket.AF_UNIX, kind) as notify:
                notify.settimeout(longest_wait)
                notify.sendto("\n".join(lines).encode(errors="backslashreplace"), self._address)


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 20


def _one_line(text: str) -> str:
    """The text without line ends: another message would start behind one."""
    return " ".join(text.split())[:_LONGEST_STATUS]
