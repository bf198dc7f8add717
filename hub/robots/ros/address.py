"""Addresses of robots with ROS; pure.

| address | line |
| --- | --- |
| `ws://HOST:8765` | a bridge for Foxglove |
| `wss://HOST:8765` | the same with TLS |
| `zenoh+tcp://HOST:7447?domain=0` | a Zenoh router to which nodes are joined by rmw_zenoh |
| `zenoh+tls://HOST:7447?domain=0` | the same with TLS |
"""

from __future__ import annotations

import enum
from typing import Final
from urllib.parse import parse_qs, urlsplit

from hub.errors import RosAddressError
from hub.values import dataclass

ADDRESS_FORMS: Final = "ws://HOST:8765, wss://HOST:8765 or zenoh+tcp://HOST:7447?domain=0"
"""The usual addresses, for people."""
_PORTS: Final = {"ws": 8765, "wss": 8765, "zenoh+tcp": 7447, "zenoh+tls": 7447}
_MOST_TEXT: Final = 200
_MOST_DOMAIN: Final = 232


class RosLineKind(enum.Enum):
    """How the messages travel.

    Attributes:
        FOXGLOVE: By a bridge's WebSocket.
        ZENOH: By a Zenoh router.
    """

    FOXGLOVE = "foxglove"
    ZENOH = "zenoh"


@dataclass(frozen=True, slots=True, kw_only=True)
class RosAddress:
    """The address of a robot.

    Attributes:
        kind: How the messages travel.
        host: Name or address of the bridge or router.
        port: Its TCP port.
        secure: Whether by TLS.
        domain: ROS domain; only of Zenoh.
        text: The address as it was written.
    """

    kind: RosLineKind
    host: str
    port: int
    secure: bool
    domain: int
    text: str

    @property
    def url(self) -> str:
        """The address in the form of its line's library."""
        if self.kind is RosLineKind.ZENOH:
            return f"{'tls' if self.secure else 'tcp'}/{self._host}:{self.port}"
        return f"{'wss' if self.secure else 'ws'}://{self._host}:{self.port}"

    @property
    def takes_certificates(self) -> bool:
        """Whether certificates of a folder count there."""
        return self.kind is RosLineKind.ZENOH and self.secure

    @property
    def _host(self) -> str:
        return f"[{self.host}]" if ":" in self.host else self.host


def ros_address(text: str) -> RosAddress:
    """An address.

    Raises:
        RosAddressError: It is none.
    """
    if len(text) > _MOST_TEXT:
        refusal = f"an address has {len(text)} characters; the longest has {_MOST_TEXT}"
        raise RosAddressError(refusal)
    try:
        parts = urlsplit(text.strip())
        port = parts.port if parts.port is not None else _PORTS.get(parts.scheme, 0)
        domain = int(parse_qs(parts.query).get("domain", ["0"])[0])
    except ValueError as fault:
        refusal = f"{text!r} is no address of a robot with ROS: write {ADDRESS_FORMS}"
        raise RosAddressError(refusal) from fault
    known = parts.scheme in _PORTS
    zenoh = parts.scheme.startswith("zenoh+")
    odd = port == 0 or bool(parts.path.strip("/") or parts.fragment or (parts.query and not zenoh))
    if not known or not parts.hostname or odd or not 0 <= domain <= _MOST_DOMAIN:
        refusal = f"{text!r} is no address of a robot with ROS: write {ADDRESS_FORMS}"
        raise RosAddressError(refusal)
    return RosAddress(
        kind=RosLineKind.ZENOH if zenoh else RosLineKind.FOXGLOVE,
        host=parts.hostname,
        port=port,
        secure=parts.scheme in ("wss", "zenoh+tls"),
        domain=domain,
        text=text.strip(),
    )
