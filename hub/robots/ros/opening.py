"""Makes the line to an address."""

from __future__ import annotations

from hub.robots.ros.address import RosAddress, RosLineKind
from hub.robots.ros.line import RosLine


def line_to(address: RosAddress, certificates: str = "") -> RosLine:
    """The line to a robot; its first `advance` connects.

    Args:
        address: Where it is.
        certificates: Folder with certificates, for a Zenoh router; empty: none.
    """
    if address.kind is RosLineKind.ZENOH:
        from hub.robots.ros.zenoh.line import ZenohLine

        return ZenohLine(address, certificates=certificates)
    from hub.robots.ros.foxglove.line import FoxgloveLine

    return FoxgloveLine(address)
