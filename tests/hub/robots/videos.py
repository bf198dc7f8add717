"""Videos made for tests: red on the left, blue on the right, an upper part that gets brighter."""

from __future__ import annotations

import io
import socket
import threading
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from PIL import Image

HEIGHT, WIDTH = 96, 128


def frame_of(number: int) -> np.ndarray:
    frame = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    frame[:, : WIDTH // 2] = (220, 30, 30)
    frame[:, WIDTH // 2 :] = (30, 30, 220)
    frame[: HEIGHT // 2] = min(255, 20 + 50 * (number % 5))
    return frame


def jpeg_of(frame: np.ndarray) -> bytes:
    file = io.BytesIO()
    Image.fromarray(frame).save(file, "JPEG")
    return file.getvalue()


def make_video(
    path: Path,
    frames: Sequence[np.ndarray] = (),
    *,
    count: int = 10,
    rate: int = 25,
    codec: str = "mpeg4",
) -> Path:
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(rate))
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for frame in frames or [frame_of(number) for number in range(count)]:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="rgb24")))
        container.mux(stream.encode())
    return path


class CameraServer:
    """A network camera: pictures one after the other in an answer that does not end (MJPEG)."""

    def __init__(self, draw: Callable[[], np.ndarray] = lambda: frame_of(0)) -> None:
        self.draw = draw
        self.socket = socket.create_server(("127.0.0.1", 0))
        self.address = f"http://user:pass@127.0.0.1:{self.socket.getsockname()[1]}/video"
        self.sends = threading.Event()
        self.sends.set()
        self.stalls = threading.Event()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="camera-server")
        self._thread.start()

    def _serve(self) -> None:
        self.socket.settimeout(0.05)
        while not self._ended.is_set():
            try:
                connection, _ = self.socket.accept()
            except TimeoutError:
                continue
            with connection:
                if self.sends.is_set():
                    self._answer(connection)

    def _answer(self, connection: socket.socket) -> None:
        connection.settimeout(5.0)
        connection.recv(4096)
        head = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=B\r\n\r\n"
        part = b"--B\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n%s\r\n"
        try:
            connection.sendall(head)
            while self.sends.is_set() and not self._ended.wait(0.02):
                if self.stalls.is_set():
                    continue
                picture = jpeg_of(self.draw())
                connection.sendall(part % (len(picture), picture))
        except OSError:
            return

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self.socket.close()
