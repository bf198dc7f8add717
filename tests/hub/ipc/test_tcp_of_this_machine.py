"""Central at TCP ports of this machine: who shows its token comes in, all others are cut."""

from __future__ import annotations

import socket
import stat
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import zmq

from hub.errors import CentralUnreachableError, KeyFileError
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.token import own_token, read_token, token_file
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


def test_a_peer_that_speaks_zmtp_3_without_the_token_gets_nothing(central: Central) -> None:
    with zmq.Context() as context:
        for kind, place in ((zmq.DEALER, "control"), (zmq.PUB, "command in")):
            for credentials in (None, b"wrong"):
                with context.socket(kind) as made:
                    made.linger = 0
                    if credentials:
                        made.plain_username, made.plain_password = b"rune", credentials
                    events = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED
                    monitor = made.get_monitor_socket(
                        events | zmq.EVENT_HANDSHAKE_FAILED_AUTH, f"inproc://{place}{credentials!r}"
                    )
                    made.connect(f"tcp://127.0.0.1:{ports(central)[place]}")
                    assert monitor.poll(10_000)
                    event = int.from_bytes(monitor.recv_multipart()[0][:2], "little")
                    assert event != zmq.EVENT_HANDSHAKE_SUCCEEDED
                    made.disable_monitor()
                    monitor.close()
    assert central.faults.counts["refused at a TCP port"] == 2
    assert central.connected() == ()


def test_the_token_is_this_users_alone_and_stays_when_the_hub_starts_again(
    central: Central,
) -> None:
    port = ports(central)["control"]
    file = token_file(port)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (file, file.parent)] == [0o600, 0o700]
    with closing(Client("one", central.endpoints[0])) as client:
        client.wait_connected(10.0)
        assert read_token(file).text not in repr(client.session.connection.keys)
    before = read_token(file)
    assert own_token(port) == before


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
