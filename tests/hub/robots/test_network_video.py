"""Pictures of a vehicle's camera over the network: RTP, MPEG-TS and RTSP that FFmpeg made."""

from __future__ import annotations

import contextlib
import random
import socket
import threading
from collections.abc import Iterator
from contextlib import closing
from fractions import Fraction

import pytest

from hub.errors import CameraError
from hub.robots.video_reader import VideoReader
from hub.robots.video_source import video_source
from tests.hub.robots.videos import HEIGHT, WIDTH, frame_of
from tests.support.waiting import until
from tests.system.harness import in_soak

av = pytest.importorskip(
    "av", reason="PyAV is not installed: pip install 'robot-user-nexus[camera]'"
)
RATE = 25
_FORMATS = {"rtp": "rtp", "udp": "mpegts"}


def two_free_ports() -> int:
    """The first of two UDP ports: RTP needs a second one for its reports."""
    while True:
        with contextlib.suppress(OSError), contextlib.ExitStack() as stack:
            first, second = (
                stack.enter_context(closing(socket.socket(type=socket.SOCK_DGRAM))) for _ in "ab"
            )
            first.bind(("127.0.0.1", 0))
            port: int = first.getsockname()[1]
            second.bind(("127.0.0.1", port + 1))
            return port


class Sender:
    """Sends pictures to a UDP port of loopback."""

    def __init__(self, scheme: str, port: int) -> None:
        self._url = f"{scheme}://127.0.0.1:{port}?pkt_size=1200"
        self._format = _FORMATS[scheme]
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._send, name="video-sender")
        self._thread.start()

    def _send(self) -> None:
        options = {"tune": "zerolatency", "preset": "ultrafast", "g": "5"}
        with av.open(self._url, "w", format=self._format) as container:
            stream = container.add_stream("libx264", rate=Fraction(RATE), options=options)
            stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
            number = 0
            while not self._ended.wait(1.0 / RATE):
                frame = av.VideoFrame.from_ndarray(frame_of(number), format="rgb24")
                frame.pts, frame.time_base = number, Fraction(1, RATE)
                container.mux(stream.encode(frame))
                number += 1

    def close(self) -> None:
        self._ended.set()
        self._thread.join()


class RtspCamera:
    """Answers one client after the other, and passes the packets of a sender on to it."""

    def __init__(self) -> None:
        self._packets = socket.socket(type=socket.SOCK_DGRAM)
        self._packets.bind(("127.0.0.1", 0))
        self._packets.settimeout(0.05)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.05)
        self.address = f"rtsp://127.0.0.1:{self._listener.getsockname()[1]}/video"
        self._sender = Sender("rtp", self._packets.getsockname()[1])
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rtsp-camera")
        self._thread.start()

    def _run(self) -> None:
        while not self._ended.is_set():
            with contextlib.suppress(OSError), self._listener.accept()[0] as client:
                client.settimeout(5.0)
                self._serve(client)

    def _serve(self, client: socket.socket) -> None:
        asked = client.makefile("r", newline="\r\n")
        plays = False
        while not plays:
            head = [*iter(asked.readline, "\r\n")]
            if "" in head or not head:
                return
            method = head[0].split()[0]
            number = next(line for line in head if line.lower().startswith("cseq"))
            client.sendall(self._answer(method, number).encode())
            plays = method == "PLAY"
        while not self._ended.is_set():
            with contextlib.suppress(TimeoutError):
                packet = self._packets.recv(2048)
                client.sendall(b"$\0" + len(packet).to_bytes(2, "big") + packet)

    def _answer(self, method: str, number: str) -> str:
        body, more = "", ""
        match method:
            case "OPTIONS":
                more = "Public: DESCRIBE, SETUP, PLAY\r\n"
            case "DESCRIBE":
                body = "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=-\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\n"
                body += "a=rtpmap:96 H264/90000\r\na=control:0\r\n"
                more = f"Content-Type: application/sdp\r\nContent-Length: {len(body)}\r\n"
            case _:
                more = "Session: 1\r\nTransport: RTP/AVP/TCP;unicast;interleaved=0-1\r\n"
        return f"RTSP/1.0 200 OK\r\n{number.strip()}\r\n{more}\r\n{body}"

    def close(self) -> None:
        self._ended.set()
        self._sender.close()
        self._thread.join()
        self._packets.close()
        self._listener.close()


@contextlib.contextmanager
def sends(scheme: str) -> Iterator[str]:
    """A camera that sends; the value is the address for a robot file."""
    if scheme == "rtsp":
        with closing(RtspCamera()) as camera:
            yield camera.address
        return
    port = two_free_ports()
    with closing(Sender(scheme, port)):
        yield f"{scheme}://127.0.0.1:{port}"


def fault(reader: VideoReader) -> str:
    """Why there is no picture; empty: there is one."""
    try:
        reader.newest()
    except CameraError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("scheme", ["rtp", *in_soak("udp", "rtsp")])
def test_pictures_come_and_are_new(scheme: str) -> None:
    with sends(scheme) as address, closing(VideoReader(video_source(address))) as reader:
        until(lambda: not fault(reader), 20.0, lambda: fault(reader))
        shot = reader.newest()
        pixels = shot.pixels(WIDTH, HEIGHT)
        assert shot.size == (WIDTH, HEIGHT)
        assert pixels[80, 10, 0] > 180 > 80 > pixels[80, 10, 2], "red on the left"
        until(lambda: reader.newest().measured > shot.measured, 10.0)


@pytest.mark.soak
@pytest.mark.parametrize("scheme", ["rtp", "udp"])
def test_datagrams_that_end_or_are_noise_are_said_and_pictures_come_back(scheme: str) -> None:
    port = two_free_ports()
    source = video_source(f"{scheme}://127.0.0.1:{port}")
    chance = random.Random(4)
    with closing(VideoReader(source, pauses=(0.05,))) as reader:
        for _ in range(2):
            with closing(Sender(scheme, port)):
                until(lambda: not fault(reader), 20.0, lambda: fault(reader))
            until(lambda: "nothing came for some seconds" in fault(reader), 20.0)
            assert source.shown in fault(reader)
            with socket.socket(type=socket.SOCK_DGRAM) as noise:
                for _ in range(2000):
                    noise.sendto(chance.randbytes(chance.randrange(1, 1400)), ("127.0.0.1", port))
        with closing(Sender(scheme, port)):
            until(lambda: not fault(reader), 20.0, lambda: fault(reader))
