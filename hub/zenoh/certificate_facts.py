"""What a certificate of a fleet says, and whether it fits its key and the authority.

Both ends of a TLS link are played in memory, so that the check is the one of a real link.
"""

from __future__ import annotations

import contextlib
import ssl
import time
from collections.abc import Iterator
from typing import Any

from hub.errors import KeyFileError
from hub.values import dataclass
from hub.zenoh.settings import CertificateFiles

_DAY_S = 86400.0
SOON_DAYS = 30.0
"""A certificate that counts for less time ends soon [days]."""
_ROUNDS = 10
"""Most turns of a handshake; three are enough."""
_MAKE = "make it with `rune-hub fleet keys make`, and copy its three files here"


@dataclass(frozen=True, slots=True, kw_only=True)
class CertificateFacts:
    """What a certificate says.

    Attributes:
        name: Its common name, such as "operate:alice".
        begins: When it begins to count [s since 1970].
        ends: When it counts no more [s since 1970].
    """

    name: str
    begins: float
    ends: float

    @classmethod
    def dated(cls, name: str, begins: str, ends: str) -> CertificateFacts:
        """Those with times as OpenSSL writes them, such as "May 31 12:00:00 2027 GMT"."""
        first, last = (float(ssl.cert_time_to_seconds(each)) for each in (begins, ends))
        return cls(name=name, begins=first, ends=last)

    @property
    def ended(self) -> bool:
        """Whether it counts no more."""
        return self.days_left <= 0.0

    @property
    def ends_soon(self) -> bool:
        """Whether it counts, for less than `SOON_DAYS`."""
        return 0.0 < self.days_left < SOON_DAYS

    @property
    def days_left(self) -> float:
        """Days for which it counts from now on."""
        return (self.ends - time.time()) / _DAY_S

    @property
    def last_day(self) -> str:
        """The last day on which it counts, such as 2027-05-31."""
        return time.strftime("%Y-%m-%d", time.gmtime(self.ends))


def read_certificate(files: CertificateFiles) -> CertificateFacts:
    """Check a certificate as the other side of a link would, and read it.

    Raises:
        KeyFileError: A file is missing or open to others, or the certificate does not count.
    """
    for path in (files.authority, files.certificate, files.key):
        try:
            path.read_bytes()
        except OSError as error:
            raise KeyFileError(path, f"it cannot be read ({error.strerror}); {_MAKE}") from error
    if files.key.stat().st_mode & 0o077:
        raise KeyFileError(files.key, "other users may read it; say chmod 600")
    own = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    other = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    other.check_hostname = False
    with _explained(files, "it does not fit its key, or is damaged"):
        own.load_cert_chain(files.certificate, files.key)
    with _explained(files, "its authority.pem is damaged"):
        other.load_verify_locations(files.authority)
    with _explained(files, "no link accepts it"):
        said = _shown(own, other)
    fields = {key: value for part in said["subject"] for key, value in part}
    return CertificateFacts.dated(fields.get("commonName", ""), said["notBefore"], said["notAfter"])


@contextlib.contextmanager
def _explained(files: CertificateFiles, why: str) -> Iterator[None]:
    try:
        yield
    except ssl.SSLCertVerificationError as error:
        reason = error.verify_message
        if "expired" not in reason and "not yet valid" not in reason:
            reason = f"the authority in {files.authority} has not made it ({reason})"
        raise KeyFileError(files.certificate, f"{reason}; {_MAKE}") from error
    except ssl.SSLError as error:
        raise KeyFileError(files.certificate, f"{why}; {_MAKE}") from error


def _shown(own: ssl.SSLContext, other: ssl.SSLContext) -> dict[str, Any]:
    """What the other side of a link sees of the own certificate.

    Raises:
        SSLError: It refuses it.
    """
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = (
        other.wrap_bio(back, there, server_side=False),
        own.wrap_bio(there, back, server_side=True),
    )
    for _ in range(_ROUNDS):
        for end in ends:
            with contextlib.suppress(ssl.SSLWantReadError):
                end.do_handshake()
    return dict(ends[0].getpeercert() or {})
