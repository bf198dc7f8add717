"""The settings with which a client of any Zenoh router uses TLS, from a folder with certificates.

| file | holds | without it |
| --- | --- | --- |
| `authority.pem` | certificate of the authority that made the router's | it is refused |
| `NAME.pem`, `NAME.key` | the own certificate and its key | the client shows none |

`NAME` is any name, but not that of a router. These are also the names of the files of a fleet.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from hub.errors import KeyFileError
from hub.zenoh.certificate_facts import read_certificate
from hub.zenoh.settings import CertificateFiles

_AUTHORITY: Final = "authority"
_ROUTER: Final = "router"
_MOST_NAMED: Final = 3


def tls_settings(folder: Path) -> dict[str, Any]:
    """Settings of Zenoh by their path; checks the certificates as the other side would.

    Raises:
        KeyFileError: A file is missing, open to others or damaged, or there are several names.
    """
    names = sorted(
        path.stem
        for path in folder.glob("*.pem")
        if path.stem.partition("-")[0] not in (_AUTHORITY, _ROUTER)
        and path.with_suffix(".key").is_file()
    )
    if len(names) > 1:
        reason = (
            f"it has the certificates {', '.join(names[:_MOST_NAMED])}; leave one of them there"
        )
        raise KeyFileError(folder, reason)
    files = CertificateFiles.of(folder, names[0] if names else _AUTHORITY)
    tls: dict[str, Any] = {"root_ca_certificate": str(files.authority)}
    if names:
        read_certificate(files)
        tls |= {
            "enable_mtls": True,
            "connect_certificate": str(files.certificate),
            "connect_private_key": str(files.key),
        }
    else:
        try:
            files.authority.read_bytes()
        except OSError as error:
            reason = f"it cannot be read ({error.strerror}); copy the authority's certificate here"
            raise KeyFileError(files.authority, reason) from error
    return {"transport/link/tls": tls}
