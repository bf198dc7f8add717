"""Looks up the addresses of a machine without waiting."""

from __future__ import annotations

import contextlib
import errno
import socket
import threading
from typing import Any


class HostLookup:
    """The addresses of a machine; a name is looked up in a thread, since that can take seconds."""

    def __init__(self, host: str, port: int, kind: socket.SocketKind) -> None:
        self._host, self._port, self._kind = host, port, kind
        self._thread: threading.Thread | None = None
        self._found: list[tuple[int, Any]] = []
        self._fault = ""

    @property
    def number(self) -> int:
        """How many addresses are known; at least 1."""
        return max(1, len(self._found))

    def address(self, turn: int = 0) -> tuple[int, Any]:
        """The family of one of its addresses, and the address.

        Each call with a name begins another lookup.

        Args:
            turn: Which one; after the last comes the first.

        Raises:
            OSError: None is known, or none yet.
        """
        with contextlib.suppress(OSError):
            return self._look_up(socket.AI_NUMERICHOST)[0]
        found = self._found
        if self._thread is None or not self._thread.is_alive():
            self._thread = threading.Thread(target=self._find, name="host lookup", daemon=True)
            self._thread.start()
        if not found:
            raise OSError(0, self._fault or f"the name {self._host!r} is being looked up")
        return found[turn % len(found)]

    def refuses(self, timeout: float) -> bool:
        """Whether each of its addresses refuses a connection; it waits.

        Args:
            timeout: Longest time for each address [s].
        """
        try:
            found = self._look_up()
        except OSError:
            return False
        return bool(found) and all(_refuses(family, each, timeout) for family, each in found)

    def _find(self) -> None:
        try:
            self._found = self._look_up()
        except OSError as fault:
            self._found = []
            self._fault = f"the name {self._host!r} is not known: {fault.strerror or fault}"

    def _look_up(self, flags: int = 0) -> list[tuple[int, Any]]:
        found = socket.getaddrinfo(self._host, self._port, type=self._kind, flags=flags)
        return [(family, address) for family, _, _, _, address in found]


def _refuses(family: int, address: Any, timeout: float) -> bool:  # noqa: ANN401 - of the system
    with socket.socket(family, socket.SOCK_STREAM) as tried:
        tried.settimeout(timeout)
        return tried.connect_ex(address) == errno.ECONNREFUSED
