"""What the doctor says of ports, with real sockets and a real hub at them."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gateways.curve.curve_gateway import curve_gateway
from hub.hub_sockets import HubFolder
from hub.inspection.doctor import port_checks
from hub.inspection.doctor.finding import Level, ok
from hub.inspection.doctor.tcp_owners import listening_inodes, owner
from hub.ipc.broker.central import Central
from hub.ipc.security.keyring import Keyring
from hub.robots.description import RobotDescription
from tests.hub.inspection.robots import robot
from tests.support.ports import free_port


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as opened:
        yield opened


def listening(folder: Path, port: int) -> RobotDescription:
    return robot(folder, f'[hub]\nlisten = "127.0.0.1:{port}"')


def listen(stack: ExitStack, port: int, host: str = "127.0.0.1") -> None:
    other = stack.enter_context(socket.socket())
    other.bind((host, port))
    other.listen()


def test_free_ports_are_well(tmp_path: Path) -> None:
    port = free_port()
    (said,) = port_checks.tcp(listening(tmp_path, port))
    assert said == ok(f"ports {port} to {port + 6} of 127.0.0.1 are free")
    (said,) = port_checks.tcp(robot(tmp_path))
    assert said == ok("the hub opens no TCP port for clients of this machine")


@pytest.mark.parametrize("place", ["192.0.2.1:1381", "127.0.0.1", "127.0.0.1:65530"])
def test_a_place_where_no_hub_may_listen_is_a_problem(tmp_path: Path, place: str) -> None:
    (said,) = port_checks.tcp(robot(tmp_path, f'[hub]\nlisten = "{place}"'))
    assert said.level is Level.PROBLEM


def test_each_port_that_another_program_has_is_told_with_its_process(
    tmp_path: Path, stack: ExitStack
) -> None:
    port = free_port()
    for taken in (port + 2, port + 6):
        listen(stack, taken)
    listen(stack, port + 7)  # no longer ours
    said = port_checks.tcp(listening(tmp_path, port))
    assert [finding.level for finding in said] == [Level.PROBLEM] * 2
    for finding, taken in zip(said, (port + 2, port + 6), strict=True):
        assert (
            f"port {taken} of 127.0.0.1 is used by another program (pid {os.getpid()}: "
            in finding.text
        )
        assert "choose another port" in finding.advice


def test_what_answers_like_no_hub_is_another_program(tmp_path: Path, stack: ExitStack) -> None:
    port = free_port()
    listen(stack, port)
    (said,) = port_checks.tcp(listening(tmp_path, port))
    assert said.level is Level.PROBLEM


def test_ports_that_connections_may_take_are_a_warning(tmp_path: Path) -> None:
    low = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    said = port_checks.tcp(listening(tmp_path, low + 5000))
    assert Level.OK not in [finding.level for finding in said]


@pytest.mark.parametrize(
    ("gateway", "text"),
    [
        ("tcp://192.0.2.1:{port}", "192.0.2.1 is no address of this machine"),
        ("tcp://robot.example:{port}", "write an address"),
        ("udp://0.0.0.0:{port}", "cannot be used"),
        ("ipc:///tmp/x", "is no tcp:// address"),
        ("tcp://0.0.0.0:65530", "above 65529"),
        ("tcp://0.0.0.0:{beside}", "want the same ports"),
    ],
)
def test_a_gateway_that_cannot_be_is_told(tmp_path: Path, gateway: str, text: str) -> None:
    port = free_port()
    place = gateway.format(port=port + 20, beside=port + 6)
    (said,) = port_checks.gateway(
        robot(tmp_path, f'[hub]\nlisten = "127.0.0.1:{port}"\ngateway = "{place}"')
    )
    assert said.level is Level.PROBLEM
    assert text in said.text


def test_a_gateway_port_of_another_program_is_told(tmp_path: Path, stack: ExitStack) -> None:
    port = free_port()
    tables = f'[hub]\ngateway = "tcp://127.0.0.1:{port}"'
    (said,) = port_checks.gateway(robot(tmp_path, tables))
    assert said.level is Level.OK
    listen(stack, port + 3)
    (said,) = port_checks.gateway(robot(tmp_path, tables))
    assert said.level is Level.PROBLEM
    assert f"port {port + 3} of 127.0.0.1 is used" in said.text


def test_the_gateway_of_the_hub_that_runs_is_well(tmp_path: Path, stack: ExitStack) -> None:
    port = free_port()
    keyring = Keyring(tmp_path / "keys")
    folder = stack.enter_context(closing(HubFolder("magellan")))
    gateway = curve_gateway(f"tcp://127.0.0.1:{port}", keyring)
    stack.enter_context(closing(Central([folder.endpoint], gateways=[gateway])))
    place = f"tcp://127.0.0.1:{port}"
    (said,) = port_checks.gateway(robot(tmp_path, f'[hub]\ngateway = "{place}"'))
    assert said.level is Level.OK
    assert "the hub that runs" in said.text


def test_without_a_gateway_there_is_nothing_to_look_at(tmp_path: Path) -> None:
    (said,) = port_checks.gateway(robot(tmp_path))
    assert said.level is Level.OK


TABLE = """  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retr uid timeout inode
   0: 0100007F:0565 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000  0 111 1 0 100
   1: 0100007F:0565 0100007F:9999 01 00000000:00000000 00:00000000 00000000  1000  0 222 1 0 100
   2: 0100007F:0566 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000  0 333 1 0 100
   3: nonsense:zz   00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000  0 444 1 0 100
cut off
"""


def test_only_listening_sockets_of_the_port_are_found() -> None:
    assert listening_inodes(TABLE, 1381) == {111}
    assert listening_inodes(TABLE, 1382) == {333}
    assert listening_inodes("", 1381) == set()


def test_nobody_owns_a_free_port() -> None:
    assert owner(free_port()) is None
