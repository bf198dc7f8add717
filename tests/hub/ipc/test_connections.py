"""Connections: names, outages, restarts, and that nothing is left when all is closed."""

from __future__ import annotations

import logging
import os
import socket
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from hub.errors import CentralUnreachableError, EndpointError, NameTakenError, QueryError
from hub.ipc import endpoints
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer, on_one_transport
from tests.hub.ipc.vocabulary import Number
from tests.support.cases import for_each
from tests.support.ports import free_port
from tests.support.waiting import until

Make = Callable[[str, str], Peer]


@pytest.fixture(params=["tcp", "ipc"])
def lasting_endpoint(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An endpoint that is the same after a restart."""
    if request.param == "tcp":
        return f"tcp://127.0.0.1:{free_port()}"
    return f"ipc://{tmp_path}/central"


def _values(received: list) -> list[int]:
    return [value.value for value, _ in received if value.value >= 0]


def test_second_client_of_a_name_is_refused_and_connects_when_the_first_leaves(
    central: Central, peers: Make
) -> None:
    first = peers("same", central.endpoints[0]).connect()
    second = peers("same", central.endpoints[0])
    with pytest.raises(NameTakenError, match=f"pid {os.getpid()}"):
        second.connect()
    assert first.client.connected
    first.close()
    until(lambda: second.client.connected, 5.0)
    assert second.client.refusal is None


@on_one_transport  # the busy thread is the one that looks at tokens
def test_newcomer_is_not_taken_for_who_had_its_descriptor_before(
    central: Central, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Central learns late of connections that came and went, and early of the one that follows."""
    passing = [_connect(central.endpoints[0]) for _ in range(40)]
    busy, go = threading.Event(), threading.Event()
    central.loop.post(lambda: (busy.set(), go.wait(10.0)))
    assert busy.wait(5.0)
    descriptors = psutil.Process().num_fds()
    for each in passing:
        each.shutdown(socket.SHUT_RDWR)  # central's end is closed, so only its descriptors are free
    until(lambda: psutil.Process().num_fds() <= descriptors - len(passing), 5.0)
    newcomer = Client("newcomer", central.endpoints[0])
    hello, said = newcomer.session.connection.hello, threading.Event()
    monkeypatch.setattr(newcomer.session.connection, "hello", lambda: hello() and said.set())
    until(said.is_set, 5.0, meanwhile=lambda: newcomer.listen(0.02))
    go.set()
    newcomer.wait_connected(5.0)
    number = newcomer.number
    for _ in range(3):
        newcomer.directory.listing(5.0)
    assert newcomer.number == number
    newcomer.close()
    for each in passing:
        each.close()


def _connect(endpoint: str) -> socket.socket:
    """A connection that says nothing, and that was accepted."""
    transport, _, address = endpoint.partition("://")
    made = socket.socket(socket.AF_UNIX if transport == "ipc" else socket.AF_INET)
    made.settimeout(5.0)
    made.connect(address if transport == "ipc" else ("127.0.0.1", int(address.split(":")[1])))
    assert made.recv(1), "ZeroMQ greets first"
    return made


def test_nobody_at_the_endpoint_is_told_with_what_to_do(peers: Make) -> None:
    lonely = peers("lonely", "tcp://127.0.0.1:9")
    with pytest.raises(CentralUnreachableError, match="is rune-hub running there"):
        lonely.call(lambda: lonely.client.wait_connected(0.05))
    with pytest.raises(CentralUnreachableError):
        lonely.call(lambda: lonely.client.directory.listing(0.05))
    lonely.call(lambda: lonely.client.define(v.LOG))
    with pytest.raises(CentralUnreachableError):
        lonely.call(lambda: lonely.client.wait_defined(0.05))


def test_client_that_starts_before_central_connects_when_it_comes(
    lasting_endpoint: str, peers: Make
) -> None:
    early = peers("early", lasting_endpoint)
    with pytest.raises(CentralUnreachableError):
        early.call(lambda: early.client.wait_connected(0.1))
    central = Central([lasting_endpoint])
    try:
        until(lambda: central.connected() == ("early",), 5.0)
        early.connect()
    finally:
        early.close()
        central.close()


def test_everything_works_again_after_central_was_started_again(
    lasting_endpoint: str, peers: Make
) -> None:
    """And nothing that was said while it was away arrives later."""
    central = Central([lasting_endpoint])
    one, other = (peers(name, lasting_endpoint).connect() for name in ("one", "other"))
    received, commands = other.collect(v.LOG), other.collect(v.EVENT)
    one.call(lambda: one.client.respond(v.ASK, v.ANSWER, lambda ask: ask))
    one.publish_until(v.LOG, received)
    one.publish_until(v.EVENT, commands)
    epoch = one.client.session.connection.joined
    central.close()
    # Both while it is not known yet that central is away, and when it is.
    for number in range(20):
        one.publish(v.EVENT, Number(value=number))
    until(lambda: not one.client.connected and not other.client.connected, 5.0)
    for number in range(20):
        one.publish(v.EVENT, Number(value=number))
    outcomes: list[QueryError] = []
    other.call(
        lambda: other.client.query_notify(
            v.ASK, Number(value=1), v.ANSWER, timeout=30.0, answered=print, failed=outcomes.append
        )
    )
    until(lambda: outcomes, 5.0)
    assert "was not sent" in str(outcomes[0])

    central = Central([lasting_endpoint])
    try:
        until(lambda: one.client.connected and other.client.connected, 5.0)
        assert one.client.session.connection.joined != epoch
        del received[:], commands[:]
        one.publish_until(v.LOG, received)
        one.publish_until(v.EVENT, commands)
        one.publish(v.EVENT, Number(value=100))
        until(lambda: 100 in _values(commands), 5.0)
        assert _values(commands) == [100]
        answer = other.call(
            lambda: other.client.query_response(v.ASK, Number(value=7), v.ANSWER, timeout=5.0)
        )
        assert answer == Number(value=7)
        listing = one.call(lambda: one.client.directory.listing(5.0))
        assert {entry.name for entry in listing.definitions} >= {"T_Log", "T_Event", "T_Ask"}
        assert one.faults == other.faults == []
    finally:
        one.close()
        other.close()
        central.close()


def test_command_of_a_short_outage_never_arrives(lasting_endpoint: str, peers: Make) -> None:
    """Not even when central is back before anybody has noticed that it was away."""
    central = Central([lasting_endpoint])
    one, other = (peers(name, lasting_endpoint).connect() for name in ("one", "other"))
    commands = other.collect(v.EVENT)
    one.publish_until(v.EVENT, commands)
    for _ in range(3):
        commands.clear()
        central.close()
        for number in range(20):
            one.publish(v.EVENT, Number(value=number))
        central = Central([lasting_endpoint])
        epoch = central.registry.epoch
        until(
            lambda epoch=epoch: (
                one.client.session.connection.joined[0]
                == other.client.session.connection.joined[0]
                == epoch
            ),
            5.0,
        )
        one.publish_until(v.EVENT, commands)
        assert _values(commands) == []
    one.close()
    other.close()
    central.close()


def test_what_is_published_without_a_hub_is_counted(lasting_endpoint: str, peers: Make) -> None:
    publisher = peers("publisher", lasting_endpoint)

    def not_sent() -> int:
        return publisher.client.faults.counts["not sent"]

    publisher.publish(v.LOG, Number(value=1))
    assert not_sent() == 0, "nobody was there yet to miss it"
    central = Central([lasting_endpoint])
    try:
        publisher.connect()
        publisher.publish(v.LOG, Number(value=2))
        publisher.call(lambda: publisher.client.wait_published(5.0))
        assert not_sent() == 0
    finally:
        central.close()
    until(lambda: not publisher.client.connected, 5.0)
    for number in range(3):
        publisher.publish(v.LOG, Number(value=number))
    assert not_sent() == 3


def test_query_under_way_ends_when_central_is_started_again(
    lasting_endpoint: str, peers: Make
) -> None:
    central = Central([lasting_endpoint])
    one, other = (peers(name, lasting_endpoint).connect() for name in ("one", "other"))
    asked, free = threading.Event(), threading.Event()

    def answer(ask: Number) -> Number:
        asked.set()
        free.wait(10.0)
        return ask

    one.call(lambda: one.client.respond(v.ASK, v.ANSWER, answer))
    one.call(lambda: one.client.directory.listing(5.0))
    failures: list[QueryError] = []
    other.call(
        lambda: other.client.query_notify(
            v.ASK, Number(value=1), v.ANSWER, timeout=60.0, answered=print, failed=failures.append
        )
    )
    assert asked.wait(5.0)
    central.close()
    central = Central([lasting_endpoint])
    try:
        until(lambda: failures, 10.0)
        assert "ended without an answer" in str(failures[0])
        free.set()
        until(lambda: one.client.connected and other.client.connected, 5.0)
    finally:
        free.set()
        one.close()
        other.close()
        central.close()


def test_client_that_was_silent_too_long_is_forgotten_and_comes_back(
    central: Central, peers: Make
) -> None:
    one, other = (peers(name, central.endpoints[0]).connect() for name in ("one", "other"))
    received = one.collect(v.LOG)
    other.publish_until(v.LOG, received)
    free = threading.Event()
    one.client.post(lambda: free.wait(10.0))
    until(lambda: central.connected() == ("other",), 10.0)
    free.set()
    until(lambda: set(central.connected()) == {"one", "other"}, 5.0)
    del received[:]
    other.publish_until(v.LOG, received)


def test_close_is_told_to_central_at_once(central: Central, peers: Make) -> None:
    one = peers("one", central.endpoints[0]).connect()
    one.close()
    until(lambda: central.connected() == (), 1.0)


def test_close_leaves_no_threads_files_or_ports(lasting_endpoint: str, tmp_path: Path) -> None:
    def once() -> None:
        central = Central([lasting_endpoint])
        client = Client("one", lasting_endpoint)
        client.subscribe(v.LOG, print)
        client.wait_connected(5.0)
        client.wait_defined(5.0)
        client.close()
        central.close()

    once()  # what libraries load at first use
    threads = {thread.ident for thread in threading.enumerate()}
    descriptors = psutil.Process().num_fds()
    for _ in range(3):
        once()
    assert {thread.ident for thread in threading.enumerate()} == threads
    assert psutil.Process().num_fds() == descriptors
    assert [path for path in tmp_path.iterdir() if "central" in path.name] == []


@pytest.mark.parametrize("publishes", [False, True])
def test_client_that_leaves_at_once_is_not_taken_for_a_stranger(
    central: Central, *, publishes: bool
) -> None:
    for number in range(30):
        with closing(Client(f"brief{number}", central.endpoints[0])) as brief:
            brief.wait_connected(5.0)
            if publishes:
                brief.publish(v.COMMAND, Number(value=number))
    # What central hears of each place it hears in order, so a stranger's end comes last.
    door = central.entrances[0]
    for port, path in zip(door.ports, door.paths, strict=True):
        with socket.socket(socket.AF_INET if port else socket.AF_UNIX) as stranger:
            stranger.connect(("127.0.0.1", port) if port else path)
    counts = central.faults.counts
    until(lambda: len(counts) == len(door.ports), 5.0, lambda: f"{counts}")
    assert set(counts.values()) == {1}, counts


def test_closing_twice_and_posting_afterwards_is_harmless(central: Central) -> None:
    client = Client("one", central.endpoints[0])
    client.wait_connected(5.0)
    client.close()
    client.close()
    client.post(lambda: None)
    central.close()
    central.close()


def test_post_to_a_closed_client_writes_into_no_other_file(
    central: Central, tmp_path: Path
) -> None:
    client = Client("one", central.endpoints[0])
    client.close()
    path = tmp_path / "file"
    files = [path.open("wb", buffering=0) for _ in range(20)]
    for _ in range(50):
        client.post(lambda: None)
    for file in files:
        file.close()
    assert path.read_bytes() == b""


def test_busy_port_is_told_with_its_number() -> None:
    port = free_port()
    central = Central([f"tcp://127.0.0.1:{port}"])
    try:
        with pytest.raises(EndpointError, match=rf"tcp://127.0.0.1:{port}: another program uses"):
            Central([f"tcp://127.0.0.1:{port}"])
    finally:
        central.close()


def test_busy_neighbour_port_frees_those_already_taken() -> None:
    port = free_port()
    with socket.socket() as neighbour:
        neighbour.bind(("127.0.0.1", port + 3))
        neighbour.listen()
        with pytest.raises(EndpointError, match=str(port + 3)):
            Central([f"tcp://127.0.0.1:{port}"])
    Central([f"tcp://127.0.0.1:{port}"]).close()


def test_socket_file_of_a_live_central_is_not_taken_over(tmp_path: Path, peers: Make) -> None:
    endpoint = f"ipc://{tmp_path}/central"
    central = Central([endpoint])
    try:
        with pytest.raises(EndpointError, match="another program uses it"):
            Central([endpoint])
        peers("one", endpoint).connect()
    finally:
        central.close()


def test_socket_file_left_behind_is_used_again(tmp_path: Path) -> None:
    path = tmp_path / "central"
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(path))
    assert path.is_socket()
    Central([f"ipc://{path}"]).close()


def test_file_of_another_kind_is_never_deleted(tmp_path: Path) -> None:
    path = tmp_path / "letter.txt"
    path.write_text("dear")
    with pytest.raises(EndpointError, match="a file is there"):
        Central([f"ipc://{path}"])
    assert path.read_text() == "dear"


def test_folder_that_is_not_there_is_told() -> None:
    with pytest.raises(EndpointError, match="No such file"):
        Central(["ipc:///nowhere/central"])


def test_central_listens_at_tcp_and_ipc_together(tmp_path: Path, peers: Make) -> None:
    central = Central(["tcp://127.0.0.1:0", f"ipc://{tmp_path}/central"])
    try:
        one, other = (
            peers(name, endpoint).connect()
            for name, endpoint in zip(("one", "other"), central.endpoints, strict=True)
        )
        received = other.collect(v.LOG)
        one.publish_until(v.LOG, received)
        one.close()
        other.close()
    finally:
        central.close()
    assert not (tmp_path / "central").exists()


def test_two_tcp_endpoints_are_refused() -> None:
    with pytest.raises(EndpointError, match="name only one"):
        Central(["tcp://127.0.0.1:0", "tcp://127.0.0.1:0"])


def test_ipv6_loopback_works_where_the_machine_has_it(peers: Make) -> None:
    try:
        with socket.socket(socket.AF_INET6) as probe:
            probe.bind(("::1", 0))
    except OSError:
        pytest.skip("no IPv6 here")
    central = Central(["tcp://[::1]:0"])
    try:
        peers("one", central.endpoints[0]).connect().close()
    finally:
        central.close()


@for_each(
    "text",
    [
        "tcp://0.0.0.0:1381",
        "tcp://*:1381",
        "tcp://192.168.1.5:1381",
        "tcp://example.org:1381",
        "tcp://[::]:1381",
        "tcp://:1381",
        "tcp://127.0.0.1",
        "tcp://127.0.0.1:",
        "tcp://127.0.0.1:x",
        "tcp://127.0.0.1:-1",
        "tcp://127.0.0.1:١",
        "tcp://127.0.0.1:65532",
        "tcp://127.0.0.1:99999999999",
        "udp://127.0.0.1:1381",
        "127.0.0.1:1381",
        "ipc://",
        "ipc://*",
        "ipc:///" + "x" * 200,
        "inproc://x",
        "",
    ],
)
def test_endpoint_that_is_malformed_or_elsewhere_is_refused_by_both_sides(text: str) -> None:
    with pytest.raises(EndpointError, match="cannot be used"):
        Central([text])
    with pytest.raises(EndpointError, match="cannot be used"):
        Client("one", text)


def test_client_needs_a_port() -> None:
    with pytest.raises(EndpointError, match="port 0"):
        Client("one", "tcp://127.0.0.1:0")


@for_each(
    ("text", "address"),
    [
        ("tcp://localhost:5", "tcp://127.0.0.1:5"),
        ("tcp://127.0.0.2:65529", "tcp://127.0.0.2:65529"),
        ("tcp://[::1]:5", "tcp://[::1]:5"),
        ("tcp://127.0.0.1:0", "tcp://127.0.0.1:*"),
        ("ipc:///a/b", "ipc:///a/b"),
    ],
)
def test_endpoint_on_this_machine_is_taken(text: str, address: str) -> None:
    assert str(endpoints.parse_endpoint(text)) == address


def test_fault_of_central_itself_is_counted_and_does_not_end_it(
    central: Central, peers: Make, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = peers("one", central.endpoints[0]).connect()
    monkeypatch.setattr(central.registry, "expire", lambda: 1 // 0)
    until(lambda: central.faults.counts["internal fault"] > 3, 5.0)
    monkeypatch.undo()
    one.call(lambda: one.client.directory.listing(5.0))
    lines = [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert len([record for record in lines if record.name == "hub.ipc.broker.central"]) == 2


def test_name_that_is_being_given_back_is_waited_for(
    connect: Callable[[str], Peer], central: Central, peers: Make
) -> None:
    """The goodbye of the one before may still be under way when the next says hello."""
    one = connect("again")
    other = peers("again", central.endpoints[0])
    until(lambda: central.faults.counts["refused connection"], 5.0)
    one.close()
    other.connect()
    assert other.client.refusal is None
