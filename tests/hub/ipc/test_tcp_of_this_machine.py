"""Central at TCP ports of this machine: who shows its token comes in, all others are cut."""

from __future__ import annotations

import socket
import stat
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
import zmq

from hub.errors import CentralUnreachableError, KeyFileError
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.token import Token, keep_token, read_token, token_file
from tests.support.ports import free_port
from tests.support.waiting import until

_FRAME = b"\0\1\2\3GCM_Velocity_Command\0" + bytes(40)
WITHOUT_TOKEN = {
    "a web page": b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://evil\r\n\r\n" + _FRAME * 9,
    "a WebSocket": b"GET / HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n" + _FRAME,
    "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(300),
    "ZMTP 1.0": b"\x01\x00" + bytes([len(_FRAME) + 1]) + b"\0" + _FRAME,
    "ZMTP 2.0": b"\xff" + bytes(7) + b"\x01\x7f\x01\x05\x00\x00\x00" + _FRAME,
    "ZMTP 3.0 without a mechanism": b"\xff" + bytes(8) + b"\x7f\3\0NULL" + bytes(48) + _FRAME,
    "noise": bytes(range(256)) * 4,
}


@pytest.fixture
def central() -> Iterator[Central]:
    with closing(Central(["tcp://127.0.0.1:0"])) as running:
        yield running


def ports(central: Central) -> dict[str, int]:
    first = int(central.endpoints[0].rpartition(":")[2])
    places = ("control", "state in", "state out", "command in", "command out")
    return dict(zip(places, (first, *central.entrances[0].ports), strict=False))


@pytest.mark.parametrize("said", WITHOUT_TOKEN)
def test_what_shows_no_token_is_cut_before_a_frame_and_counted(central: Central, said: str) -> None:
    for place, port in ports(central).items():
        with socket.create_connection(("127.0.0.1", port), timeout=10.0) as raw:
            raw.sendall(WITHOUT_TOKEN[said])
            heard = b"?"
            try:
                while heard:
                    heard = raw.recv(4096)
            except ConnectionError:
                pass
        until(lambda place=place: central.faults.counts[f"bad handshake on {place}"] == 1, 10.0)
    assert set(central.faults.counts) == {f"bad handshake on {place}" for place in ports(central)}


def _plain(made: zmq.Socket[bytes]) -> None:
    made.plain_username, made.plain_password = b"rune", b"wrong"


@pytest.mark.parametrize(
    ("kind", "place", "show", "counted"),
    [
        (zmq.DEALER, "control", lambda _: None, "bad handshake on control"),
        (zmq.DEALER, "control", _plain, "bad handshake on control"),
        (zmq.DEALER, "control", Token(text="0" * 64).apply, "bad handshake on control"),
        (zmq.PUB, "command in", lambda _: None, "bad handshake on command in"),
        (zmq.PUB, "command in", _plain, "refused at a TCP port"),
        (zmq.PUB, "command in", Token(text="0" * 64).of_run(1).apply, "refused at a TCP port"),
    ],
)
def test_a_peer_that_speaks_zmtp_3_without_the_token_gets_nothing(
    central: Central,
    kind: int,
    place: str,
    show: Callable[[zmq.Socket[bytes]], None],
    counted: str,
) -> None:
    assert not _shakes_hands(kind, ports(central)[place], show)
    until(lambda: central.faults.counts[counted] >= 1, 10.0)
    assert central.connected() == ()


def test_the_hubs_public_key_alone_lets_nobody_in(central: Central) -> None:
    port = ports(central)["control"]

    def show(made: zmq.Socket[bytes]) -> None:
        read_token(token_file(port)).apply(made)
        made.curve_publickey, made.curve_secretkey = zmq.curve_keypair()

    assert not _shakes_hands(zmq.DEALER, port, show)
    assert central.faults.counts["refused at a TCP port"] == 1
    assert _shakes_hands(zmq.DEALER, port, read_token(token_file(port)).apply)


def _shakes_hands(kind: int, port: int, show: Callable[[zmq.Socket[bytes]], None]) -> bool:
    """Whether a peer that shows this is let in."""
    watched = (
        zmq.EVENT_HANDSHAKE_SUCCEEDED
        | zmq.EVENT_DISCONNECTED
        | zmq.EVENT_HANDSHAKE_FAILED_AUTH
        | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
        | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
    )
    with zmq.Context() as context, context.socket(kind) as made:
        made.linger = 0
        show(made)
        monitor = made.get_monitor_socket(watched)
        made.connect(f"tcp://127.0.0.1:{port}")
        assert monitor.poll(10_000)
        event = int.from_bytes(monitor.recv_multipart()[0][:2], "little")
        made.disable_monitor()
        monitor.close()
    return event == zmq.EVENT_HANDSHAKE_SUCCEEDED


@pytest.mark.parametrize("known", [True, False])
def test_another_program_at_the_port_of_a_hub_that_is_down_learns_nothing(
    central: Central, *, known: bool
) -> None:
    """It is no hub for the client, and what it sees lets nobody in after the hub's next start."""
    port = ports(central)["control"]
    token = read_token(token_file(port))
    central.close()
    if known:
        keep_token(Token(text=token.text), port)
    for serve in (lambda _: None, lambda other: setattr(other, "plain_server", True)):
        with zmq.Context() as context:
            other = context.socket(zmq.ROUTER)
            serve(other)
            other.bind(f"tcp://127.0.0.1:{port}")
            with other, closing(Client("one", f"tcp://127.0.0.1:{port}")) as client:
                events = other.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED)
                with pytest.raises(CentralUnreachableError):
                    client.wait_connected(1.0)
                assert not events.poll(0)
                other.disable_monitor()
                events.close()


def test_the_password_of_a_plane_counts_in_one_run(central: Central) -> None:
    token = read_token(token_file(ports(central)["control"]))
    assert _shakes_hands(
        zmq.PUB, ports(central)["command in"], token.of_run(central.registry.epoch).apply
    )
    for other in (token.of_run(central.registry.epoch + 1), token.of_run(0)):
        assert not _shakes_hands(zmq.PUB, ports(central)["command in"], other.apply)
    assert token.text not in token.of_run(1).text


def test_the_token_is_this_users_alone(central: Central) -> None:
    port = ports(central)["control"]
    file = token_file(port)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (file, file.parent)] == [0o600, 0o700]
    with closing(Client("one", central.endpoints[0])) as client:
        client.wait_connected(10.0)
        assert read_token(file).text not in repr(client.session.connection.keys)


def test_the_token_of_a_chosen_port_stays_and_that_of_a_free_port_goes(central: Central) -> None:
    chosen, free = free_port(), ports(central)["control"]
    found = []
    for _ in range(2):
        with closing(Central([f"tcp://127.0.0.1:{chosen}"])):
            found.append(read_token(token_file(chosen)))
    assert found[0] == found[1]
    assert token_file(free).exists()
    central.close()
    assert not token_file(free).exists()


def test_a_token_that_others_can_read_is_refused(central: Central) -> None:
    file = token_file(ports(central)["control"])
    file.chmod(0o644)
    with pytest.raises(KeyFileError, match="others can read"):
        read_token(file)
    with (
        closing(Client("one", central.endpoints[0])) as client,
        pytest.raises(CentralUnreachableError, match="give its file with --keys"),
    ):
        client.wait_connected(0.3)


def test_a_token_of_another_place_is_given_by_its_file(
    central: Central, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = token_file(ports(central)["control"]).rename(tmp_path / "token.toml")
    monkeypatch.setenv("RUNE_RUNTIME_DIR", str(tmp_path))
    with closing(Client("one", central.endpoints[0], keys=read_token(file))) as client:
        client.wait_connected(10.0)
