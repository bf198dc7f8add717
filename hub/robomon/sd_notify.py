"""Tells systemd how the daemon fares: the protocol of sd_notify(3), datagrams on a Unix socket."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Mapping

_PART = 0.5
"""systemd advises to say that we live twice within the watchdog's time (sd_watchdog_enabled(3))."""
_LONGEST_STATUS = 500
_PATIENCE_S = 1.0
"""How long `ready` waits for room: systemd would end a service of which it never hears [s]."""


class Notifier:
    """The way to whoever supervises the daemon; without one, all it does is nothing.

    Nothing here raises, and only `ready` may wait, for a second: a robot must not stop because
    nobody listens.

    Attributes:
        period: How often `alive` has to be called [s]; None when no watchdog wants to hear it.
    """

    def __init__(self, address: str = "", period: float | None = None) -> None:
        """Notify at `address`: a path, or @ and an abstract name; empty where nobody listens."""
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self.period = period if address else None

    @staticmethod
    def from_environment(environment: Mapping[str, str], pid: int) -> Notifier:
        """The notifier that systemd's variables describe.

        Args:
            environment: `NOTIFY_SOCKET`, `WATCHDOG_USEC` [us] and `WATCHDOG_PID`; what is missing
                or malformed counts as not wanted.
            pid: Of this process: a watchdog of another one is not ours to feed.
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
        """The hub can be reached.

        Not: all modules run. systemd ends a service that takes long to be ready, and a robot whose
        camera is broken is not to be ended for that.
        """
        self._tell("READY=1", f"STATUS={_one_line(status)}", patience=_PATIENCE_S)

    def stopping(self) -> None:
        """The end has begun."""
        self._tell("STOPPING=1")

    def status(self, text: str) -> None:
        """One line for `systemctl status`."""
        self._tell(f"STATUS={_one_line(text)}")

    def alive(self) -> None:
        """The watchdog's time begins anew."""
        self._tell("WATCHDOG=1")

    def _tell(self, *lines: str, patience: float = 0.0) -> None:
        if not self._address:
            return
        # ValueError: an address may hold what no path can.
        with contextlib.suppress(OSError, ValueError):
            kind = socket.SOCK_DGRAM | socket.SOCK_CLOEXEC
            with socket.socket(socket.AF_UNIX, kind) as way:
                way.settimeout(patience)
                way.sendto("\n".join(lines).encode(errors="backslashreplace"), self._address)


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) < 20


def _one_line(text: str) -> str:
    """The text without line ends, behind which another message would begin."""
    return " ".join(text.split())[:_LONGEST_STATUS]
