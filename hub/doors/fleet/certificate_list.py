"""`rune-hub fleet keys list`: the certificates of a fleet, and how long they count."""

from __future__ import annotations

from typing import Any

from hub.command_output import print_error, put
from hub.doors.fleet.certificates import Certificates
from hub.errors import KeyFileError
from hub.table_text import json_text
from hub.zenoh.certificate_facts import SOON_DAYS, CertificateFacts


def list_certificates(certificates: Certificates, *, as_json: bool) -> None:
    """Show those of the list and of routers, each with its last day.

    Raises:
        KeyFileError: The list is damaged or open to others.
    """
    names = (*certificates.holders(), *certificates.routers())
    if not names:
        where = certificates.folder
        print_error(f"no certificates in {where}; `rune-hub fleet keys make` makes one")
    width = max(map(len, names), default=0)
    for name in names:
        found: CertificateFacts | KeyFileError
        try:
            found = certificates.facts(name)
        except KeyFileError as error:
            found = error
        put(json_text(_values(name, found)) if as_json else f"{name:<{width}}  {_words(found)}")


def _words(found: CertificateFacts | KeyFileError) -> str:
    if isinstance(found, KeyFileError):
        return f"last day not known: {found}"
    if found.ended:
        return f"ended on {found.last_day}"
    soon = f": ends within {SOON_DAYS:.0f} days" if found.ends_soon else ""
    return f"until {found.last_day}{soon}"


def _values(name: str, found: CertificateFacts | KeyFileError) -> dict[str, Any]:
    if isinstance(found, KeyFileError):
        unknown = dict.fromkeys(("last_day", "ended", "ends_soon"))
        return {"name": name, **unknown, "fault": str(found)}
    return {
        "name": name,
        "last_day": found.last_day,
        "ended": found.ended,
        "ends_soon": found.ends_soon,
    }
