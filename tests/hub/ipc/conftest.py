"""Real centrals and clients, each client with the thread that serves it; all closed at the end."""

from __future__ import annotations

import concurrent.futures
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import pytest

from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.client_keys import ClientKeys
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

T = TypeVar("T")


class Peer:
    """A client, served by a thread of its own; faults of its handlers are collected."""

    def __init__(
        self, name: str, endpoint: str, keys: ClientKeys | None = None, *, near: bool = True
    ) -> None:
        self.client = Client(name, endpoint, keys=keys, near=near)
        self.faults: list[Exception] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._serve, name=f"peer-{name}", daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while not self._stop.is_set():
            try:
                self.client.listen(0.5)
            except Exception as error:  # noqa: BLE001 - whatever a handler raises
                self.faults.append(error)
        self.client.close()

    def call(self, work: Callable[[], T], timeout: float = 10.0) -> T:
        """What `work` returns or raises in the client's own thread."""
        result: concurrent.futures.Future[T] = concurrent.futures.Future()

        def run() -> None:
            try:
                result.set_result(work())
            except Exception as error:  # noqa: BLE001 - told to who called
                result.set_exception(error)

        self.client.post(run)
        return result.result(timeout)

    def connect(self) -> Peer:
        self.call(lambda: self.client.wait_connected(5.0))
        return self

    def collect(self, definition: MessageDefinition[Any]) -> list[tuple[Any, MessageInfo]]:
        """Subscribe; what comes is appended to the list."""
        received: list[tuple[Any, MessageInfo]] = []
        self.call(
            lambda: self.client.subscribe(
                definition, lambda value, how: received.append((value, how))
            )
        )
        return received

    def publish(self, definition: MessageDefinition[T], value: T, age: float = 0.0) -> None:
        def send() -> None:
            measured = self.client.loop.clock() - age
            self.client.publish(definition, value, measured=measured)

        self.call(send)

    def publish_until(
        self, definition: MessageDefinition[Number], received: list[tuple[Any, MessageInfo]]
    ) -> None:
        """Publish -1 until it is received: from then on the way is open."""
        until(
            lambda: any(value.value == -1 for value, _ in received),
            10.0,
            lambda: f"no {definition.name} came",
            meanwhile=lambda: self._send_one(definition),
        )

    def _send_one(self, definition: MessageDefinition[Number]) -> None:
        self.publish(definition, Number(value=-1))
        threading.Event().wait(0.005)

    def stands(self) -> None:
        """Wait until nothing is missed any more of what was subscribed to."""
        self.call(lambda: self.client.wait_subscribed(5.0))

    def open(self, *definitions: Any) -> None:
        """Publish -1 of each, and wait until it has left."""
        for each in definitions:
            self.publish(each, Number(value=-1))
        self.call(lambda: self.client.wait_published(5.0))

    def direct(self, definition: MessageDefinition[Any]) -> int:
        """How many neighbours take a message of ours."""
        return len(self.client.session.publishers.of(definition).direct)

    def close(self) -> None:
        self._stop.set()
        self.client.post(lambda: None)
        self._thread.join(10.0)


Make = Callable[..., Peer]


def values(received: list[Any]) -> list[int]:
    """The numbers that came."""
    return [value.value for value, _ in received]


@pytest.fixture(params=["tcp", "ipc"])
def wanted_endpoint(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where central shall listen."""
    return "tcp://127.0.0.1:0" if request.param == "tcp" else f"ipc://{tmp_path}/central"


on_one_transport = pytest.mark.parametrize("wanted_endpoint", ["ipc"], indirect=True)
"""For what no transport has a part in: timers, formats, callbacks."""


@pytest.fixture
def central(wanted_endpoint: str) -> Iterator[Central]:
    """A running central."""
    running = Central([wanted_endpoint])
    yield running
    running.close()


@pytest.fixture
def peers() -> Iterator[Callable[[str, str], Peer]]:
    """Makes peers: name, endpoint.

    Over ipc:// their messages pass central by, as they do by default; over tcp:// all goes through.
    """
    made: list[Peer] = []

    def make(name: str, endpoint: str) -> Peer:
        made.append(Peer(name, endpoint, near=endpoint.startswith("ipc")))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


@pytest.fixture
def connect(central: Central, peers: Callable[[str, str], Peer]) -> Callable[[str], Peer]:
    """Makes peers that are connected to `central`: name."""
    return lambda name: peers(name, central.endpoints[0]).connect()


@pytest.fixture
def make(central: Central) -> Iterator[Make]:
    """Makes connected peers: name, and whether they are near."""
    made: list[Peer] = []

    def make(name: str, *, near: bool = True) -> Peer:
        made.append(Peer(name, central.endpoints[0], near=near))
        return made[-1].connect()

    yield make
    for peer in made:
        peer.close()
