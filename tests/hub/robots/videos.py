"""Videos made for tests: red on the left, blue on the right, an upper part that gets brighter."""

from __future__ import annotations

import io
from collections.abc import Sequence
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
