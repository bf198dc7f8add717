"""`rune-hub fleet router`: the place where a fleet meets, until Ctrl-C."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hub.command_output import print_error, put
from hub.doors.fleet.access import access_table
from hub.doors.fleet.certificates import Certificates
from hub.errors import HubError
from hub.plain_text import counted
from hub.zenoh.fleet_keys import KeyKind, pattern
from hub.zenoh.fleet_session import FleetSession, open_fleet_session
from hub.zenoh.settings import CertificateFiles, RouterPlace, router_settings

_LOOK_S = 1.0
"""Time between two looks at the list of certificates [s]."""
_TOKENS_S = 2.0


class _RouterCertificates:
    """The certificates that count at the router, and those that are listed now.

    Attributes:
        lacks_one: Whether one that counts is no longer listed.
    """

    def __init__(self, folder: Path | None, fleet: str) -> None:
        """Read the list.

        Raises:
            KeyFileError: It cannot be used.
        """
        self._folder = None if folder is None else Certificates(folder)
        self._fleet = fleet
        self._seen = self._folder.changed() if self._folder else 0
        self._newest = self._folder.holders() if self._folder else ()
        self._counting = self._newest
        self._announced: tuple[str, ...] = ()
        self.lacks_one = False

    def look(self) -> bool:
        """Whether others are listed than those that count."""
        if self._folder is None:
            return False
        if (now := self._folder.changed()) != self._seen:
            self._seen = now
            try:
                self._newest = self._folder.holders()
            except HubError as error:
                print_error(f"the certificates of before still count: {error}")
        self.lacks_one = not {*self._newest} >= {*self._counting}
        return self._newest != self._counting

    def announce(self, sessions: int) -> None:
        """Say once why the new ones do not count yet."""
        if self._announced == self._newest:
            return
        self._announced = self._newest
        more = ", ".join(sorted({*self._newest} - {*self._counting}))
        wait = f"waits until no operator is in the fleet ({counted(sessions, 'session')} now)"
        put(f"{more} {wait}, because all robots stop for it; at once: kill -USR1 {os.getpid()}")

    def use(self) -> tuple[CertificateFiles | None, dict[str, Any] | None]:
        """The router's own files, and the table with those that are listed now; they count then.

        Raises:
            HubError: A file cannot be used.
        """
        if self._folder is None:
            return None, None
        self._counting = self._newest
        return self._folder.of_router(), access_table(self._fleet, self._counting)


def run_router(
    places: Sequence[RouterPlace],
    folder: Path | None,
    fleet: str,
    *,
    others: Sequence[RouterPlace] = (),
) -> int:
    """Be the router of a fleet until a signal.

    A change of the certificates ends all sessions, because Zenoh reads its table at the start only.
    So robots that are driven stop.

    | the list | the new one counts |
    | --- | --- |
    | lacks a certificate of before | within a second |
    | has more certificates | when no operator is in the fleet, or after a signal USR1 |
    | cannot be read | when it can; the old one counts until then |

    Args:
        places: Where it listens.
        folder: Of the certificates; None: without any.
        fleet: Name of the fleet.
        others: Routers to join with.

    Raises:
        HubError: It cannot listen there, or a file cannot be used.
    """
    ended, forced = threading.Event(), threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    signal.signal(signal.SIGUSR1, lambda *_: forced.set())
    certificates = _RouterCertificates(folder, fleet)
    session = _open(places, certificates, others)
    joined = f", joined with {', '.join(map(str, others))}" if others else ""
    put(f"router of the fleet {fleet} at {', '.join(map(str, places))}{joined}; Ctrl-C ends it")
    while not ended.wait(_LOOK_S):
        if not certificates.look():
            continue
        if not (certificates.lacks_one or forced.is_set()):
            operators = session.tokens(pattern(fleet, KeyKind.OPERATOR), timeout=_TOKENS_S)
            if operators:
                certificates.announce(len(operators))
                continue
        forced.clear()
        session.close()
        session = _open(places, certificates, others)
        put("the list of certificates has changed, and counts now")
    session.close()
    return 0


def _open(
    places: Sequence[RouterPlace],
    certificates: _RouterCertificates,
    others: Sequence[RouterPlace],
) -> FleetSession:
    files, access = certificates.use()
    settings = router_settings(places, certificates=files, access=access, others=others)
    return open_fleet_session(places[0], settings, mode="router")
