"""Addresses of robots with ROS."""

from __future__ import annotations

import pytest

from hub.errors import RosAddressError
from hub.robots.ros.address import RosLineKind, ros_address


@pytest.mark.parametrize(
    ("text", "kind", "url", "domain"),
    [
        ("ws://robot:9000", RosLineKind.FOXGLOVE, "ws://robot:9000", 0),
        ("ws://robot", RosLineKind.FOXGLOVE, "ws://robot:8765", 0),
        (" wss://robot/ ", RosLineKind.FOXGLOVE, "wss://robot:8765", 0),
        ("ws://[::1]:8765", RosLineKind.FOXGLOVE, "ws://[::1]:8765", 0),
        ("zenoh+tcp://robot", RosLineKind.ZENOH, "tcp/robot:7447", 0),
        ("zenoh+tls://robot:7448?domain=42", RosLineKind.ZENOH, "tls/robot:7448", 42),
    ],
)
def test_an_address_names_a_line(text: str, kind: RosLineKind, url: str, domain: int) -> None:
    address = ros_address(text)
    assert (address.kind, address.url, address.domain) == (kind, url, domain)
    assert address.secure is url.startswith(("wss", "tls"))
    assert address.text == text.strip()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "robot:8765",
        "http://robot:8765",
        "ws://",
        "ws://:8765",
        "ws://robot:99999",
        "ws://robot:8765/topic",
        "ws://robot:8765?domain=1",
        "ws://robot#part",
        "ws://[::1:8765",
        "zenoh+tcp://robot?domain=x",
        "zenoh+tcp://robot?domain=233",
        "ws://" + 300 * "a",
    ],
)
def test_what_is_no_address_is_refused_with_the_forms(text: str) -> None:
    with pytest.raises(RosAddressError, match=r"write ws://HOST:8765|the longest has"):
        ros_address(text)
