"""`rune-hub fleet router`: the place where a fleet meets, until Ctrl-C."""

from __future__ import annotations

import signal
import threading
from collections.abc import Sequence
from pathlib import Path

from hub.command_output import put
from hub.doors.fleet.access import access_table
from hub.doors.fleet.certificates import Certificates
from hub.zenoh.fleet_session import FleetSession, open_fleet_session
from hub.zenoh.settings import RouterPlace, router_settings

_LOOK_S = 1.0
"""Time between two looks at the list of certificates [s]."""


def run_router(places: Sequence[RouterPlace], folder: Path | None, fleet: str) -> int:
    """Be the router of a fleet until a signal; a change of the certificates counts in a second.

    Args:
        places: Where it listens.
        folder: Of the certificates; None: without any.
        fleet: Name of the fleet.

    Raises:
        HubError: It cannot listen there, or a file cannot be used.
    """
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    certificates = None if folder is None else Certificates(folder)
    seen = certificates.changed() if certificates else 0
    session = _open(places, certificates, fleet)
    put(f"router of the fleet {fleet} at {', '.join(map(str, places))}; Ctrl-C ends it")
    while not ended.wait(_LOOK_S):
        if certificates is not None and (now := certificates.changed()) != seen:
            seen = now
            session.close()
            session = _open(places, certificates, fleet)
            put("the list of certificates has changed, and counts now")
    session.close()
    return 0


def _open(
    places: Sequence[RouterPlace], certificates: Certificates | None, fleet: str
) -> FleetSession:
    files = None if certificates is None else certificates.of_router()
    settings = router_settings(
        places,
        certificates=files,
        access=None if certificates is None else access_table(fleet, certificates.holders()),
    )
    return open_fleet_session(places[0], settings, mode="router")
