"""A router, and lines of programs to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from hub.ipc.transport.loop import Loop
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.fleet_session import FleetSession, open_fleet_session
from hub.zenoh.settings import RouterPlace, client_settings, router_settings
from tests.support.ports import free_port
from tests.support.waiting import until


class FleetSide:
    """A program's line, and the loop that serves it."""

    def __init__(self, place: RouterPlace, loop: Loop) -> None:
        self.loop = loop
        self.line = ZenohFleetLine(place, client_settings(place), self.loop)

    def wait(self, condition: Callable[[], object], timeout: float = 10.0) -> None:
        until(condition, timeout, meanwhile=lambda: self.loop.listen(0.01))


@pytest.fixture
def place() -> RouterPlace:
    return RouterPlace(scheme="tcp", host="127.0.0.1", port=free_port())


def start_router(place: RouterPlace) -> FleetSession:
    return open_fleet_session(place, router_settings([place]), mode="router")


@pytest.fixture
def router(place: RouterPlace) -> Iterator[FleetSession]:
    session = start_router(place)
    yield session
    session.close()


@pytest.fixture
def sides(place: RouterPlace) -> Iterator[tuple[FleetSide, FleetSide]]:
    loop = Loop()  # of both, so that who waits for one serves the other
    both = FleetSide(place, loop), FleetSide(place, loop)
    yield both
    for side in both:
        side.line.close()
    loop.close()
