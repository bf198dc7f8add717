"""A hub and a program of different protocol versions."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hub.ipc.broker.central import Central
from hub.ipc.wire import frames
from tests.hub.ipc.conftest import on_one_transport

_OTHER_VERSION = """
import sys
from hub.ipc.wire import frames
frames.VERSION = int(sys.argv[1])
from hub.errors import HubError
from hub.ipc.client import Client
try:
    Client("other", sys.argv[2]).wait_connected(20.0)
except HubError as error:
    print(error)
"""


@on_one_transport
@pytest.mark.parametrize("version", [frames.VERSION - 1, frames.VERSION + 1])
def test_client_of_another_version_learns_that(central: Central, version: int) -> None:
    said = subprocess.run(
        [sys.executable, "-c", _OTHER_VERSION, str(version), central.endpoints[0]],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert f"protocol {frames.VERSION}, this program {version}" in said
    assert "install the same version" in said
