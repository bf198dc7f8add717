"""Who may connect to the door for panels: its rules, and raw bytes at its port."""

from __future__ import annotations

import json
import logging
import random
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing
from urllib.parse import urlsplit

import psutil
import pytest
from websockets import Subprotocol
from websockets.sync.client import ClientConnection, connect

from hub.doors.foxglove.entrance import MOST_YOUNG
from hub.doors.foxglove.handshake import DoorRules
from hub.doors.foxglove.tool_server import ServerSettings, ToolServer
from hub.doors.panels.wishes import CMD_VEL
from hub.recording.topics import RecordedTopic
from hub.robots.ros.address import ros_address
from hub.robots.ros.opening import line_to
from tests.support.foxglove_panel import SUBPROTOCOL
from tests.support.waiting import until

RULES = DoorRules(key="Key-1", names=frozenset({"robot", "lichtblick.example"}))
HERE = "127.0.0.1:8765"
CHANCE = random.Random(7)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        (HERE, None),  # a program
        ("localhost:9999", None),  # by ssh -L to another port
        ("[::1]:8765", "http://[::1]:8080"),
        ("192.168.0.7:8765", None),
        ("robot:8765", "http://lichtblick.example"),
        ("ROBOT", "https://lichtblick.example:8443"),
        (HERE, "http://localhost:8080"),
        (HERE, "https://app.foxglove.dev"),
        (HERE, "file://"),  # Foxglove and Lichtblick as programs
    ],
)
def test_with_the_key_programs_and_pages_of_this_machine_connect(
    host: str, origin: str | None
) -> None:
    origins = [] if origin is None else [origin]
    assert RULES.refusal("/Key-1", [host], origins) == ""
    assert RULES.refusal("/Key-1?x=1", [host], origins) == ""
    for path in ("/", "", "/key-1", "/Key-1x", "/x/Key-1", "/?Key-1", "/%4Bey-1", "/Kéy-1"):
        assert "lacks the key" in RULES.refusal(path, [host], origins), path


@pytest.mark.parametrize(
    ("hosts", "origins", "words"),
    [
        ([HERE], ["http://evil.example"], "pages of this origin may not connect: http://evil"),
        ([HERE], ["null"], "pages"),
        ([HERE], [""], "pages"),
        ([HERE], ["http://localhost", "http://localhost"], "pages"),
        ([HERE], ["http://localhost.evil.example"], "pages"),
        ([HERE], ["http://localhost@evil.example"], "pages"),
        ([HERE], ["http://evil.example/localhost"], "pages"),
        ([HERE], ["chrome-extension://localhost"], "pages"),
        ([HERE], ["https://app.foxglove.dev.evil.example"], "pages"),
        ([HERE], ["file:///home/x/evil.html"], "pages"),
        ([HERE], ["http://192.168.0.7"], "pages"),  # another machine's
        (["rebound.evil.example:8765"], [], "name of the host"),
        (["localhost.evil.example"], [], "name of the host"),
        (["user@localhost"], [], "name of the host"),
        (["localhost:0"], [], "name of the host"),
        (["localhost:99999"], [], "name of the host"),
        (["[::1"], [], "name of the host"),
        ([""], [], "name of the host"),
        ([], [], "name of the host"),
        ([HERE, HERE], [], "name of the host"),
    ],
)
def test_pages_and_names_of_others_are_refused_with_the_key_too(
    hosts: list[str], origins: list[str], words: str
) -> None:
    assert words in RULES.refusal("/Key-1", hosts, origins)


def test_files_of_a_browser_connect_only_where_that_was_asked_for() -> None:
    rules = DoorRules(key="Key-1", names=frozenset({"null"}))
    assert rules.refusal("/Key-1", [HERE], ["null"]) == ""
    assert rules.refusal("/", [HERE], ["null"])


@pytest.fixture
def server() -> Iterator[ToolServer]:
    settings = ServerSettings(name="Rune: rover", drive=True, handshake_s=1.0)
    with closing(ToolServer(settings, lambda: None)) as opened:
        yield opened


def request(server: ToolServer, path: str, *more: str, method: str = "GET") -> bytes:
    """A request for a WebSocket as raw bytes."""
    lines = [
        f"{method} {path} HTTP/1.1", "Upgrade: websocket", "Connection: Upgrade",
        "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
        f"Sec-WebSocket-Protocol: {SUBPROTOCOL}", *(more or (f"Host: 127.0.0.1:{server.port}",)),
    ]  # fmt: skip
    return "\r\n".join([*lines, "", ""]).encode()


def answer(server: ToolServer, sent: bytes) -> bytes:
    """What the door sends back until it closes; an open WebSocket is cut off after its head."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=20.0) as client:
        client.sendall(sent)
        got = b""
        while part := client.recv(4096):
            got += part
            if b" 101 " in got and b"\r\n\r\n" in got:
                break
    return got


def test_raw_requests_without_the_key_or_of_other_pages_get_nothing(
    server: ToolServer, caplog: pytest.LogCaptureFixture
) -> None:
    number = server.open(RecordedTopic("/odom", "nav_msgs/msg/Odometry"))
    path, here = urlsplit(server.address).path, f"Host: 127.0.0.1:{server.port}"
    assert b" 101 " in answer(server, request(server, path))
    assert b" 101 " in answer(server, request(server, path, here, "Origin: http://localhost:80"))
    caplog.set_level(logging.WARNING)
    for sent in (
        request(server, "/"),
        request(server, path[:-1]),
        request(server, path.swapcase()),
        request(server, path, here, "Origin: http://evil.example"),
        request(server, path, here, "Origin: null"),
        request(server, path, "Host: evil.example"),
        request(server, path, here, here),
        f"GET {path} HTTP/1.1\r\n{here}\r\n\r\n".encode(),
        request(server, "/", method="POST") + b"x" * 2000,
        request(server, path, method="POST"),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + CHANCE.randbytes(300),
        b"\xff\0\0\0\0\0\0\0\x01\x7f\x03\0NULL" + bytes(49),
        b"GET /" + b"x" * 100_000,
        CHANCE.randbytes(5000) + b"\r\n\r\n",
        b"\r\n\r\n",
    ):
        got = answer(server, sent)
        assert b" 101 " not in got, sent[:60]
        assert b"rover" not in got
        assert path.encode() not in got
    assert server.refused >= 7
    assert len(caplog.records) <= 20
    server.send(number, b"x", 1)
    assert server.take_wishes().watched == frozenset()


def test_half_requests_and_programs_that_do_not_read_keep_nobody_out(server: ToolServer) -> None:
    number = server.open(RecordedTopic("/image", "sensor_msgs/msg/Image"))
    with ExitStack() as stack:
        for size in range(1, 200):
            client = stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            client.sendall(request(server, "/")[:size])
        deaf = [
            stack.enter_context(
                connect(
                    server.address,
                    subprotocols=[Subprotocol(SUBPROTOCOL)],
                    max_queue=1,
                    close_timeout=0.1,
                )
            )
            for _ in range(3)
        ]
        for each in deaf:
            wanted = [{"id": 1, "channelId": number}]
            each.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
        until(lambda: number in server.take_wishes().watched or None, 10.0)
        good = stack.enter_context(
            connect(server.address, subprotocols=[Subprotocol(SUBPROTOCOL)], close_timeout=0.1)
        )
        assert json.loads(good.recv(10.0))["op"] == "serverInfo"
        assert json.loads(good.recv(10.0))["op"] == "advertise"
        for _ in range(300):
            server.send(number, bytes(100_000), 1)
        server.say("still here")
        until(lambda: b"still here" in bytes(_text(good.recv(10.0)), "utf-8"), 10.0)
        good.send("x" * (1 << 20))  # longer than any text of a program
        until(lambda: threading.active_count() < 50, 10.0)
        channel = {"id": 1, "topic": CMD_VEL, "encoding": "json", "schemaName": "Twist"}
        other = stack.enter_context(
            connect(server.address, subprotocols=[Subprotocol(SUBPROTOCOL)], close_timeout=0.1)
        )
        other.send(json.dumps({"op": "advertise", "channels": [channel]}))
        until(lambda: server.take_wishes().panels, 10.0)


def test_half_requests_are_bounded_in_number_and_the_newest_counts() -> None:
    settings = ServerSettings(name="Rune: rover", handshake_s=600.0)
    with closing(ToolServer(settings, lambda: None)) as server, ExitStack() as stack:
        before = _descriptors()
        programs = [_program(server, stack) for _ in range(3)]
        for number in range(1000):
            client = stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            client.sendall(request(server, "/")[: number % 100])
        until(lambda: server.refused >= 1000 - MOST_YOUNG, 20.0)
        until(lambda: _descriptors() - before <= 1000 + MOST_YOUNG + 20, 20.0)
        programs.append(_program(server, stack))
        server.say("still here")
        for each in programs:
            until(lambda each=each: b"still here" in _text(each.recv(10.0)).encode(), 10.0)


def _program(server: ToolServer, stack: ExitStack) -> ClientConnection:
    protocol = Subprotocol(SUBPROTOCOL)
    opened = connect(server.address, subprotocols=[protocol], close_timeout=0.1)
    return stack.enter_context(opened)


def _descriptors() -> int:
    """How many this process has open, those of its clients too."""
    return psutil.Process().num_fds()


def _text(frame: str | bytes) -> str:
    return frame if isinstance(frame, str) else ""


def test_a_line_to_a_robot_says_that_this_is_the_door_of_a_hub(server: ToolServer) -> None:
    line = line_to(ros_address(f"ws://127.0.0.1:{server.port}"))
    with closing(line):
        now = [1000.0]

        def look() -> None:
            now[0] += 0.01
            line.advance(now[0])

        until(lambda: "rune-hub serve foxglove" in line.state.why, 10.0, meanwhile=look)
        assert not line.state.up
