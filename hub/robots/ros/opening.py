"""Makes the line to an address."""

from __future__ import annotations

from hub.robots.ros.address import RosAddress, RosLineKind
from hub.robots.ros.line import RosLine


def line_to(address: RosAddress) -> RosLine:
    """The line to a robot; its first `advance` connects."""
    if address.kind is RosLineKind.ZENOH:
        from hub.robots.ros.zenoh.line import ZenohLine

        return ZenohLine(address)
    from hub.robots.ros.foxglove.line import FoxgloveLine

    return FoxgloveLine(address)
