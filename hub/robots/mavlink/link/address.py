"""Addresses of vehicles; pure.

| address | link |
| --- | --- |
| `udp://:14550` | wait on loopback for a vehicle that sends first |
| `udp://0.0.0.0:14550` | the same on all networks |
| `udp://HOST:14555` | send to the vehicle first |
| `tcp://HOST:5760` | connect to it |
| `/dev/ttyACM0`, `COM3` | a serial port with 115200 baud |
| `serial:///dev/ttyUSB0?baud=57600` | one with another rate |
"""

from __future__ import annotations

import enum
import ipaddress
from typing import Final
from urllib.parse import SplitResult, parse_qs, urlsplit

from hub.errors import VehicleAddressError
from hub.values import dataclass

DEFAULT_BAUD: Final = 115_200
_LARGEST_BAUD: Final = 4_000_000
_LOOPBACK: Final = "127.0.0.1"
ADDRESS_FORMS: Final = "udp://:14550, udp://HOST:PORT, tcp://HOST:PORT or /dev/ttyACM0"
"""The usual addresses, for people."""


class VehicleLinkKind(enum.Enum):
    """How the bytes travel.

    Attributes:
        UDP_LISTEN: Datagrams of a vehicle that sends first.
        UDP: Datagrams to a vehicle.
        TCP: A connection to it.
        SERIAL: A serial port.
    """

    UDP_LISTEN = "udp listen"
    UDP = "udp"
    TCP = "tcp"
    SERIAL = "serial"


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleAddress:
    """The address of a vehicle.

    Attributes:
        kind: How the bytes travel.
        host: Name or address of the vehicle, or of this machine to listen at; of a serial port,
            its path.
        port: UDP or TCP port; 0: a serial port, or to listen at any.
        baud: Rate of a serial port [baud].
        text: The address as it was written.
    """

    kind: VehicleLinkKind
    host: str
    port: int = 0
    baud: int = DEFAULT_BAUD
    text: str


def vehicle_address(text: str) -> VehicleAddress:
    """The address in a text.

    Raises:
        VehicleAddressError: It is none.
    """
    text = text.strip()
    if "://" not in text:
        if not text.startswith(("/", "COM")):
            raise VehicleAddressError(text, f"give {ADDRESS_FORMS}")
        return VehicleAddress(kind=VehicleLinkKind.SERIAL, host=text, text=text)
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError as fault:
        raise VehicleAddressError(text, f"{fault}; give {ADDRESS_FORMS}") from fault
    if parts.scheme == "serial":
        return _serial(text, parts)
    if parts.scheme not in ("tcp", "udp"):
        raise VehicleAddressError(
            text, f"{parts.scheme!r} is no kind of link; give {ADDRESS_FORMS}"
        )
    if parts.path or parts.query or parts.username or parts.fragment:
        raise VehicleAddressError(text, f"there is more than host and port; give {ADDRESS_FORMS}")
    return _network(text, parts.scheme, parts.hostname or "", port)


def _network(text: str, scheme: str, host: str, port: int | None) -> VehicleAddress:
    """An address of UDP or TCP."""
    if scheme == "udp" and port is not None and (not host or _is_unspecified(host)):
        kind = VehicleLinkKind.UDP_LISTEN
        return VehicleAddress(kind=kind, host=host or _LOOPBACK, port=port, text=text)
    if not host or not port:
        example = "tcp://HOST:5760" if scheme == "tcp" else "udp://:14550"
        raise VehicleAddressError(text, f"host or port is missing: {example}")
    kind = VehicleLinkKind.TCP if scheme == "tcp" else VehicleLinkKind.UDP
    return VehicleAddress(kind=kind, host=host, port=port, text=text)


def _is_unspecified(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False


def _serial(text: str, parts: SplitResult) -> VehicleAddress:
    path = parts.netloc + parts.path
    baud = DEFAULT_BAUD
    for name, values in parse_qs(parts.query, keep_blank_values=True).items():
        number = values[-1]
        if name != "baud" or not number.isascii() or not number.isdecimal():
            raise VehicleAddressError(text, "after the path only ?baud=57600 is known")
        baud = int(number[:9])
    if not path:
        raise VehicleAddressError(text, "the path is missing: serial:///dev/ttyUSB0?baud=57600")
    if not 300 <= baud <= _LARGEST_BAUD:
        raise VehicleAddressError(text, f"{baud} baud is not within 300 and {_LARGEST_BAUD}")
    return VehicleAddress(kind=VehicleLinkKind.SERIAL, host=path, baud=baud, text=text)
