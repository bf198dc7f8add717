"""Whether a program may connect to the door: the key in the address, the Host and the Origin; pure.

Pages in a browser reach ports of this machine too. They cannot read the key, and a browser says
which page connects (Origin) and by which name (Host).

| part of the request | is allowed |
| --- | --- |
| path | the key of this door, which is new with each start |
| Host | an address in numbers, `localhost`, where the door listens, names that were given |
| Origin | none (a program), a page of this machine or of a given name, Foxglove; `null` if given |
"""

from __future__ import annotations

import hmac
import ipaddress
from collections.abc import Sequence
from typing import Final
from urllib.parse import urlsplit

from hub.values import dataclass

_THIS_MACHINE: Final = frozenset({"localhost", "127.0.0.1", "::1"})
_APPS: Final = frozenset({"https://app.foxglove.dev", "file://"})
"""Origins of Foxglove in a browser, and of Foxglove and Lichtblick as programs."""
_NO_ORIGIN: Final = "null"
"""What browsers say of files and of parts of pages; allowed only where it was given as a name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DoorRules:
    """Which requests for a connection are allowed.

    Attributes:
        key: The path of the address, without slashes.
        names: Names of hosts that may be asked for, and whose pages may connect.
    """

    key: str
    names: frozenset[str] = frozenset()

    def refusal(self, path: str, hosts: Sequence[str], origins: Sequence[str]) -> str:
        """Why a request is refused, in a sentence; empty: it is not.

        Args:
            path: What it asks for: "/KEY".
            hosts: All its headers `Host`.
            origins: All its headers `Origin`.
        """
        given = path.partition("?")[0].strip("/").encode("utf-8", "replace")
        if not hmac.compare_digest(given, self.key.encode()):
            return "the address lacks the key of this door: open the address that it printed"
        if len(hosts) != 1 or not self._is_host(hosts[0]):
            return f"the name of the host is none of this door's: {_shown(hosts)}; see --allow"
        if origins and (len(origins) > 1 or not self._is_origin(origins[0])):
            return f"pages of this origin may not connect: {_shown(origins)}; see --allow"
        return ""

    def _is_host(self, host: str) -> bool:
        name = _host_of(f"//{host}")
        return name in self.names or name in _THIS_MACHINE or _is_address(name)

    def _is_origin(self, origin: str) -> bool:
        if origin in _APPS or (origin == _NO_ORIGIN and _NO_ORIGIN in self.names):
            return True
        if not origin.startswith(("http://", "https://")):
            return False
        name = _host_of(origin)
        return name in self.names or name in _THIS_MACHINE


def _host_of(url: str) -> str:
    """The name of the host in a URL, in small letters; empty: it has none, or more than that."""
    try:
        parts = urlsplit(url)
        more = (parts.username, parts.password, parts.path, parts.query, parts.port == 0)
        return "" if any(more) else parts.hostname or ""
    except ValueError:  # its port is none, or its brackets
        return ""


def _is_address(name: str) -> bool:
    """Whether a host is given in numbers: no name that another can make point here."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _shown(values: Sequence[str]) -> str:
    return ", ".join(each[:80] for each in values[:2]) or "none"
