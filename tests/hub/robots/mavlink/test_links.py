"""Links to a vehicle: addresses, and bytes over real sockets and ptys."""

import contextlib
import os
import pty
import socket
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import VehicleAddressError
from hub.robots.mavlink.link.address import VehicleLinkKind, vehicle_address
from hub.robots.mavlink.link.byte_link import ByteLink
from hub.robots.mavlink.link.opening import link_to
from hub.robots.mavlink.link.sockets import TcpLink, UdpLink
from tests.support.waiting import until

FRAME = b"\xfd0123456789"


@pytest.mark.parametrize(
    ("text", "kind", "host", "port", "baud"),
    [
        ("udp://:14550", VehicleLinkKind.UDP_LISTEN, "127.0.0.1", 14550, 115200),
        ("udp://0.0.0.0:14550", VehicleLinkKind.UDP_LISTEN, "0.0.0.0", 14550, 115200),
        ("udp://[::]:14550", VehicleLinkKind.UDP_LISTEN, "::", 14550, 115200),
        ("udp://rover.local:14555", VehicleLinkKind.UDP, "rover.local", 14555, 115200),
        ("tcp://127.0.0.1:5760", VehicleLinkKind.TCP, "127.0.0.1", 5760, 115200),
        ("tcp://[::1]:5760", VehicleLinkKind.TCP, "::1", 5760, 115200),
        ("/dev/ttyACM0", VehicleLinkKind.SERIAL, "/dev/ttyACM0", 0, 115200),
        ("serial:///dev/ttyUSB0?baud=57600", VehicleLinkKind.SERIAL, "/dev/ttyUSB0", 0, 57600),
        ("COM3", VehicleLinkKind.SERIAL, "COM3", 0, 115200),
    ],
)
def test_an_address_names_a_link(text, kind, host, port, baud):
    address = vehicle_address(text)
    assert (address.kind, address.host, address.port, address.baud) == (kind, host, port, baud)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "rover",
        "udp://",
        "udp://host",
        "udp://host:0",
        "udp://host:99999",
        "tcp://:5760",
        "tcp://host",
        "tcp://host:5760/path",
        "tcp://[::1:5760",
        "http://host:80",
        "serial://",
        "serial:///dev/ttyS0?baud=fast",
        "serial:///dev/ttyS0?baud=3",
        "serial:///dev/ttyS0?rate=9600",
    ],
)
def test_what_is_no_address_is_refused_in_a_sentence(text):
    with pytest.raises(VehicleAddressError, match="is no address of a vehicle: "):
        vehicle_address(text)


@given(st.text(max_size=60))
def test_any_text_is_an_address_or_refused(text):
    with contextlib.suppress(VehicleAddressError):
        assert vehicle_address(text).text == text.strip()


def received(link: ByteLink, size: int) -> bytes:
    data = bytearray()

    def came() -> bool:
        for piece in link.read(time.monotonic()):
            data.extend(piece)
        return len(data) >= size

    until(came, 10)
    return bytes(data)


def is_up(link: ByteLink) -> bool:
    link.read(time.monotonic())
    return link.state.up


def test_a_vehicle_that_sends_first_is_answered():
    link = UdpLink("127.0.0.1", 0, listen=True)
    until(lambda: is_up(link), 10)
    link.write(FRAME)
    assert link.state.dropped == 1  # there is no vehicle yet
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.settimeout(5)
        vehicle.sendto(FRAME, ("127.0.0.1", link.port))
        assert received(link, len(FRAME)) == FRAME
        link.write(b"answer")
        assert vehicle.recv(100) == b"answer"
    link.close()


def test_a_second_sender_is_not_heard_beside_the_first():
    link = UdpLink("127.0.0.1", 0, listen=True)
    now = 100.0
    link.read(now)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second,
    ):
        to = "127.0.0.1", link.port
        first.sendto(b"first", to)
        until(lambda: link.read(now), 10)
        second.sendto(b"second", to)
        first.sendto(b"again", to)
        pieces: list[bytes] = []

        def again() -> bool:
            pieces.extend(link.read(now))
            return b"again" in pieces

        until(again, 10)
        assert pieces == [b"again"]
        second.sendto(b"second", to)
        until(lambda: link.read(now + 10.0) == [b"second"], 10)
    link.close()


@pytest.mark.parametrize(("host", "silence"), [("127.0.0.1", 1.2), ("127.0.0.2", 3.0)])
def test_a_vehicle_that_was_started_again_is_heard_from_its_new_port_soon(host, silence):
    link = UdpLink("127.0.0.1", 0, listen=True)
    now = 100.0
    link.read(now)
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as before,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again,
    ):
        again.bind((host, 0))
        again.settimeout(5)
        to = "127.0.0.1", link.port
        before.sendto(b"before", to)
        until(lambda: link.read(now), 10)
        again.sendto(b"early", to)
        until(lambda: link.read(now + silence - 0.1) == [] and link.state.unheard, 10)
        again.sendto(b"again", to)
        until(lambda: link.read(now + silence + 0.1) == [b"again"], 10)
        link.write(b"answer")
        assert again.recv(100) == b"answer"
    link.close()


def test_a_vehicle_behind_tcp_that_goes_and_comes_back():
    server = socket.create_server(("127.0.0.1", 0))
    link = TcpLink(*server.getsockname())
    until(lambda: is_up(link), 10)
    vehicle, _ = server.accept()
    vehicle.settimeout(5)
    vehicle.sendall(FRAME)
    assert received(link, len(FRAME)) == FRAME
    link.write(b"answer")
    assert vehicle.recv(100) == b"answer"
    vehicle.close()
    until(lambda: not is_up(link), 10)
    assert "ended the connection" in link.state.why
    now = time.monotonic() + 2.0
    link.read(now)
    again, _ = server.accept()
    again.sendall(b"back")
    until(lambda: link.read(now) == [b"back"], 10)
    assert link.state.openings == 2
    link.close()
    again.close()
    server.close()


def test_nobody_listens():
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = server.getsockname()
    link = TcpLink(*address)

    def refused() -> bool:
        link.read(time.monotonic())
        return bool(link.state.why)

    until(refused, 10)
    assert "refused" in link.state.why
    link.close()


def test_a_frame_is_sent_whole_or_not_at_all():
    server = socket.create_server(("127.0.0.1", 0))
    link = TcpLink(*server.getsockname())
    until(lambda: is_up(link), 10)
    vehicle, _ = server.accept()
    frame = bytes(range(250)) * 1000
    until(lambda: link.read(time.monotonic()) or (link.write(frame) or link.state.sent > 0), 10)
    while not link.state.dropped:
        link.write(frame)
    received_bytes = bytearray()
    vehicle.settimeout(5)

    def drained() -> bool:
        link.write(b"END")
        received_bytes.extend(vehicle.recv(1 << 20))
        return b"END" in received_bytes

    until(drained, 10)
    whole = bytes(received_bytes).partition(b"END")[0]
    assert len(whole) % len(frame) == 0
    link.close()
    vehicle.close()
    server.close()


def test_a_serial_port_that_is_unplugged():
    ours, theirs = pty.openpty()
    path = os.ttyname(theirs)
    link = link_to(vehicle_address(f"serial://{path}?baud=57600"))
    until(lambda: is_up(link), 10)
    os.write(ours, FRAME)
    assert received(link, len(FRAME)) == FRAME
    link.write(b"answer")
    assert os.read(ours, 100) == b"answer"
    os.close(ours)
    os.close(theirs)
    until(lambda: not is_up(link), 10)
    assert link.state.why
    link.close()


def test_a_serial_port_that_is_not_there():
    link = link_to(vehicle_address("/dev/rune-has-no-such-port"))
    link.read(time.monotonic())
    assert "plug it in" in link.state.why


def test_a_name_that_is_not_known_does_not_wait():
    link = TcpLink("no-such-host.invalid", 5760)

    def known() -> bool:
        link.read(time.monotonic() + 10.0)
        return "is not known" in link.state.why

    until(known, 10)
