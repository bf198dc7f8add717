"""The settings of the sessions of a fleet, besides those of every session; pure.

| setting | value | reason |
| --- | --- | --- |
| `transport/link/tx/lease` | 1 s | a silent peer is seen in 1 s; Zenoh's own 10 s are too long |
| `wait_before_drop` | 20 ms | 1 ms loses pictures on an idle line |
| two links, by priority | commands and states; pictures | on one link, states wait for pictures |
| `so_sndbuf` | 16 KiB | what waits in the system's buffer cannot be overtaken |
"""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hub.errors import EndpointError
from hub.ipc.roles import Role
from hub.values import dataclass

DEFAULT_PORT = 7447
DEFAULT_PLACE = f"tcp/127.0.0.1:{DEFAULT_PORT}"
_HOST_NAME = re.compile(r"[A-Za-z0-9]([A-Za-z0-9._-]{0,251}[A-Za-z0-9])?", re.ASCII)
UNLISTED = "the router's list lacks this certificate: see `rune-hub fleet keys list` there"
"""A reason for a fleet that looks empty."""
_OPERATORS = tuple(role.value for role in (Role.OBSERVE, Role.OPERATE, Role.SUPERVISE))
_LINKS = ("prio=1-4", "prio=5-7")
_SEND_BUFFER = 16384
_WAIT_BEFORE_DROP_US = 20_000
_LEASE_MS = 1000
_RETRY = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}


@dataclass(frozen=True, slots=True, kw_only=True)
class RouterPlace:
    """Where a router listens: tcp/HOST:PORT, or tls/HOST:PORT with certificates."""

    scheme: str
    host: str
    port: int

    def __str__(self) -> str:
        """Its text, as Zenoh has it."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}/{host}:{self.port}"

    @property
    def on_loopback(self) -> bool:
        """Whether only this machine reaches it."""
        return self.host == "localhost" or (
            _is_address(self.host) and ipaddress.ip_address(self.host).is_loopback
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class CertificateFiles:
    """The files with which one side of a TLS link shows who it is.

    Attributes:
        authority: Certificate of the fleet's authority (PEM).
        certificate: The own certificate (PEM).
        key: Its private key (PEM).
    """

    authority: Path
    certificate: Path
    key: Path

    @staticmethod
    def of(folder: Path, name: str) -> CertificateFiles:
        """The files of a name in a folder."""
        return CertificateFiles(
            authority=folder / "authority.pem",
            certificate=folder / f"{name}.pem",
            key=folder / f"{name}.key",
        )

    @staticmethod
    def only_operator(folder: Path) -> str:
        """The common name of an operator whose certificate is the only one in a folder.

        Empty: there are several or none.
        """
        names = [path.stem.partition("-") for path in folder.glob("*-*.pem")]
        operators = [f"{role}:{name}" for role, _, name in names if role in _OPERATORS]
        return operators[0] if len(operators) == 1 else ""


def parse_place(text: str) -> RouterPlace:
    """The place in a text such as tcp/127.0.0.1:7447.

    Raises:
        EndpointError: It is none.
    """
    scheme, _, rest = text.partition("/")
    host, colon, port = rest.rpartition(":")
    host = host.strip("[]")
    known = bool(_HOST_NAME.fullmatch(host)) or _is_address(host)
    digits = port.isascii() and port.isdecimal() and len(port) <= 5
    if scheme not in ("tcp", "tls") or not colon or not known or not digits:
        raise _refused(text, f"write tcp/HOST:PORT or tls/HOST:PORT, such as {DEFAULT_PLACE}")
    if not 0 < int(port) <= 65535:
        raise _refused(text, "a port is a number from 1 to 65535")
    return RouterPlace(scheme=scheme, host=host, port=int(port))


def client_settings(
    place: RouterPlace, *, certificates: CertificateFiles | None = None
) -> dict[str, Any]:
    """The settings of a client of a router: commands and states have a link of their own.

    Args:
        place: Where the router listens.
        certificates: For a place with TLS.

    Raises:
        EndpointError: TLS and certificates do not go together.
    """
    return _common([place], certificates, sides=["connect"]) | {
        "connect/endpoints": [_two_links(place)],
        "connect/timeout_ms": 0,
        "connect/retry": _RETRY,
    }


def router_settings(
    places: Sequence[RouterPlace],
    *,
    certificates: CertificateFiles | None = None,
    access: Mapping[str, Any] | None = None,
    others: Sequence[RouterPlace] = (),
) -> dict[str, Any]:
    """The settings of a router.

    Args:
        places: Where it listens.
        certificates: For places with TLS; every client has to show one of the same authority.
        access: Zenoh's table of access control; None: all may do everything.
        others: Routers to join with; those that are away are tried again all the time.

    Raises:
        EndpointError: It would be open to other machines, or TLS has no certificates.
    """
    for place in (*places, *others):
        if not place.on_loopback and (place.scheme != "tls" or access is None):
            reason = (
                "without certificates a router listens and connects on this machine only; make "
                "them with `rune-hub fleet keys`, and give --tls and the folder"
            )
            raise _refused(str(place), reason)
    sides = ["listen", "connect"] if others else ["listen"]
    settings = _common([*places, *others], certificates, sides=sides)
    if others:
        settings["connect/endpoints"] = [_two_links(other) for other in others]
    settings["listen/endpoints"] = [f"{place}#so_sndbuf={_SEND_BUFFER}" for place in places]
    if access is not None:
        settings["access_control"] = access
    return settings


def _common(
    places: Sequence[RouterPlace],
    certificates: CertificateFiles | None,
    *,
    sides: Sequence[str],
) -> dict[str, Any]:
    settings: dict[str, Any] = {
        "transport/link/tx/lease": _LEASE_MS,
        "transport/unicast/max_links": len(_LINKS),
        "transport/link/tx/queue/congestion_control/drop/wait_before_drop": _WAIT_BEFORE_DROP_US,
    }
    for place in places:
        if (place.scheme == "tls") != (certificates is not None):
            reason = "a place with tcp/ has no certificates; leave out their folder"
            if certificates is None:
                reason = (
                    "a place with tls/ needs certificates: name their folder with --tls, for rune "
                    "with --keys, in a robot file with [fleet] certificates"
                )
            raise _refused(str(place), reason)
    if certificates is not None:
        settings["transport/link/tls"] = {
            "root_ca_certificate": str(certificates.authority),
            "enable_mtls": True,
        }
        for side in sides:
            settings["transport/link/tls"] |= {
                f"{side}_certificate": str(certificates.certificate),
                f"{side}_private_key": str(certificates.key),
            }
    return settings


def _two_links(place: RouterPlace) -> dict[str, Any]:
    """A place to connect to by a link for each group of priorities."""
    each = [f"{place}?{link}#so_sndbuf={_SEND_BUFFER}" for link in _LINKS]
    return {"strategy": "allOf", "locators": each}


def _is_address(host: str) -> bool:
    try:
        return not ipaddress.ip_address(host).is_multicast
    except ValueError:
        return False


def _refused(text: str, reason: str) -> EndpointError:
    return EndpointError(f"{text[:80]!r} cannot be a place of a router: {reason}")
