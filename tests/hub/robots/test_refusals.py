"""A machine that refuses connections is left after 1.5 s, and one that only may be slow is not."""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable
from contextlib import closing

import pytest

from hub.errors import RosSilentError, VehicleSilentError
from hub.robots.host_lookup import HostLookup
from hub.robots.mavlink.asking import session as asking
from hub.robots.mavlink.asking.search import find_vehicle
from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.mavlink.link.sockets import TcpLink
from hub.robots.refusals import REFUSED_S, Refusals
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.survey import look_at
from hub.robots.ros.line import RosLine, RosLineState
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.opening import line_to
from tests.support.memory_ros_line import MemoryLine
from tests.support.ports import free_port
from tests.support.ros_findings import ADDRESS
from tests.support.waiting import until

LONG_S = 600.0
"""A question that is to end before [s]."""


@pytest.fixture
def port() -> int:
    """A port at which no program listens."""
    return free_port()


def test_refusals_count_from_the_first_and_until_another_outcome() -> None:
    found = Refusals()
    assert found.since == math.inf
    for now in (3.0, 4.0):
        found.attempt(now, refused=True)
    assert found.since == 3.0
    found.attempt(5.0, refused=False)
    assert found.since == math.inf
    found.attempt(6.0, refused=True)
    assert found.since == 6.0


def test_each_address_of_a_machine_has_to_refuse() -> None:
    found = Refusals()
    found.attempt(3.0, refused=True, addresses=2)
    assert found.since == math.inf
    found.attempt(4.0, refused=True, addresses=2)
    assert found.since == 3.0


def test_the_system_says_whether_a_port_refuses(port: int) -> None:
    assert HostLookup("127.0.0.1", port, socket.SOCK_STREAM).refuses(5.0)
    assert not HostLookup("no such name", port, socket.SOCK_STREAM).refuses(5.0)
    with socket.create_server(("127.0.0.1", port)):
        assert not HostLookup("127.0.0.1", port, socket.SOCK_STREAM).refuses(5.0)


@pytest.mark.parametrize("scheme", ["ws", "wss", "zenoh+tcp"])
def test_a_line_says_since_when_its_host_refuses(scheme: str, port: int) -> None:
    with closing(line_to(ros_address(f"{scheme}://127.0.0.1:{port}"))) as line:
        began = time.monotonic()
        assert line.state.refused_since == math.inf
        until(
            lambda: line.state.refused_since < math.inf,
            20.0,
            meanwhile=lambda: line.advance(time.monotonic()),
        )
        assert began <= line.state.refused_since <= time.monotonic()


def test_a_link_says_since_when_its_host_refuses_and_forgets_it_once_it_is_open(port: int) -> None:
    link = TcpLink("127.0.0.1", port)
    until(lambda: link.state.refused_since == 5.0, 20.0, meanwhile=lambda: link.read(5.0))
    with socket.create_server(("127.0.0.1", port)):
        link.read(6.5)
        assert link.state.up
        assert link.state.refused_since == math.inf
    link.close()


def looked_at(line: RosLine) -> Callable[[], object]:
    loop = LineLoop(line)
    return lambda: look_at(loop, ros_address(ADDRESS), LONG_S)


def down(refused_s: float) -> RosLineState:
    since = time.monotonic() - refused_s
    return RosLineState(up=False, heard=0.0, why="no program listens", refused_since=since)


def test_a_robot_whose_host_refuses_is_left_soon() -> None:
    with pytest.raises(RosSilentError, match="no program listens"):
        looked_at(MemoryLine(state=down(REFUSED_S)))()


class GoesOnError(Exception):
    """The question is not given up."""


def test_a_bridge_that_may_just_be_starting_is_waited_for() -> None:
    class RefusingLine(MemoryLine):
        turns = 0

        def advance(self, now: float) -> None:
            self.state = RosLineState(up=False, heard=0.0, refused_since=now - 0.9 * REFUSED_S)
            self.turns += 1
            if self.turns == 3:
                raise GoesOnError

    with pytest.raises(GoesOnError):
        looked_at(RefusingLine())()


def test_a_vehicle_whose_host_refuses_is_left_soon(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(asking, "REFUSED_S", 0.0)
    with (
        closing(VehicleSession(f"tcp://127.0.0.1:{port}")) as session,
        pytest.raises(VehicleSilentError, match="Connection refused"),
    ):
        find_vehicle(session, seconds=LONG_S)
