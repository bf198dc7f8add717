"""Makes the link to an address."""

from __future__ import annotations

from hub.robots.mavlink.link.address import VehicleAddress, VehicleLinkKind
from hub.robots.mavlink.link.byte_link import ByteLink
from hub.robots.mavlink.link.serial_port import SerialLink
from hub.robots.mavlink.link.sockets import TcpLink, UdpLink


def link_to(address: VehicleAddress) -> ByteLink:
    """The link to a vehicle; its first `read` opens it."""
    match address.kind:
        case VehicleLinkKind.SERIAL:
            return SerialLink(address.host, address.baud)
        case VehicleLinkKind.TCP:
            return TcpLink(address.host, address.port)
        case kind:
            listen = kind is VehicleLinkKind.UDP_LISTEN
            return UdpLink(address.host, address.port, listen=listen)
