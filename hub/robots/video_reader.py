"""Reads pictures in a thread of its own, and keeps the newest; only this file decodes videos."""

from __future__ import annotations

import io
import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hub.errors import CameraError
from hub.robots.cropping import Size, scaled_size, size_within
from hub.robots.video_source import Pace, SourceKind, VideoSource, why_not
from hub.values import dataclass

if TYPE_CHECKING:
    import av

_logger = logging.getLogger(__name__)

_OPEN_S = 5.0
_READ_S = 3.0
"""Time without data after which a stream counts as lost [s]."""
_STALE_S = 2.0
"""Largest age of a live picture [s]."""
_PAUSES = (0.5, 1.0, 2.0, 5.0)
"""Pauses between two attempts to open a source [s]."""
_CLOSE_S = 0.5
_MOST_DAMAGED = 100
"""Most damaged pieces in a row, for example after lost packets; more end the reading."""
_DEFAULT_PERIOD = 0.04
_MOST_PIXELS = 1 << 24
"""Largest picture; a larger one is damaged, or an attack on the memory."""
_OPTIONS = {
    SourceKind.DEVICE: {},
    SourceKind.FILE: {},
    SourceKind.STREAM: {
        "rtsp_transport": "tcp",
        "fflags": "nobuffer",
        "flags": "low_delay",
        # Data from the network must not open files.
        "protocol_whitelist": "http,https,httpproxy,tcp,tls,rtsp,rtp,srtp,udp,crypto",
    },
}
_INSTALL = "need PyAV; install it with: pip install 'robot-user-nexus[camera]'"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shot:
    """A decoded picture.

    Attributes:
        frame: The decoded picture.
        measured: Time of the picture, on the monotonic clock [s].
    """

    frame: av.VideoFrame
    measured: float

    @property
    def size(self) -> Size:
        """Width and height [px]."""
        return self.frame.width, self.frame.height

    def pixels(self, width_px: int, height_px: int) -> npt.NDArray[np.uint8]:
        """Red, green, blue of the middle, shape (height, width, 3), at most its own size.

        Raises:
            CameraError: Its colours cannot be read.
        """
        width, height = size_within(width_px, height_px, self.size)
        whole = scaled_size((width, height), self.size)
        try:
            # Area averages: skipped pixels would flicker.
            scaled = self.frame.to_ndarray(
                format="rgb24", width=whole[0], height=whole[1], interpolation="AREA"
            )
        except (OSError, ValueError) as fault:
            text = f"a picture of {self.size[0]}x{self.size[1]} cannot be read: {fault}"
            raise CameraError(text) from fault
        left, top = (whole[0] - width) // 2, (whole[1] - height) // 2
        return np.ascontiguousarray(scaled[top : top + height, left : left + width], np.uint8)


class VideoReader:
    """Follows one source from the start to `close`, through losses and returns."""

    def __init__(
        self,
        source: VideoSource,
        *,
        clock: Callable[[], float] = time.monotonic,
        pauses: tuple[float, ...] = _PAUSES,
    ) -> None:
        """Start, without waiting.

        Args:
            source: The source.
            clock: Monotonic time [s].
            pauses: Pauses between attempts to open it [s]; the last one repeats.
        """
        self._source = source
        self._clock = clock
        self._pauses = pauses
        self._shot: Shot | None = None
        self._fault_text = f"no picture has come from {source.shown} yet; ask again in a moment"
        self._ended = threading.Event()
        self._pace: Pace | None = None
        self._thread = threading.Thread(target=self._run, name="video-reader", daemon=True)
        self._thread.start()

    def newest(self) -> Shot:
        """The newest picture.

        Raises:
            CameraError: There is none, or it is too old; the text gives the reason and the remedy.
        """
        shot = self._shot
        if shot is None:
            raise CameraError(self._fault_text)
        age = self._clock() - shot.measured
        if self._source.live and age > _STALE_S:
            text = (
                f"no picture has come from {self._source.shown} for {age:.0f} s; see what it does"
            )
            raise CameraError(text)
        return shot

    def close(self) -> None:
        """End the thread, unless it is stuck in a device."""
        self._ended.set()
        self._thread.join(_CLOSE_S)

    def _run(self) -> None:
        failed = 0
        while not self._ended.is_set():
            try:
                self._read()
            except ImportError:
                self._lost(f"pictures from {self._source.shown} {_INSTALL}")
                return
            except CameraError as error:
                fault_text = str(error)
            except Exception as fault:  # the decoder's errors have no common kind
                _logger.debug("reading failed", exc_info=True)
                fault_text = why_not(self._source, fault)
            else:
                fault_text = f"the pictures from {self._source.shown} have ended; it is tried again"
            if self._shot is None:
                failed += 1
            else:
                failed = 1
            if self._ended.is_set():
                return
            self._lost(fault_text)
            self._ended.wait(self._pauses[min(failed, len(self._pauses)) - 1])

    def _lost(self, fault_text: str) -> None:
        """Drop the newest picture; new ones replace it."""
        self._shot = None
        if fault_text != self._fault_text:
            _logger.warning("%s", fault_text)
        self._fault_text = fault_text

    def _read(self) -> None:
        """Read to the source's end; a file then starts again."""
        while not self._ended.is_set():
            count = self._read_once()
            if self._source.live:
                return
            if not count:
                text = f"the file {self._source.shown} holds no pictures; name a video file"
                raise CameraError(text)

    def _read_once(self) -> int:
        """Read from start to end; returns the number of pictures."""
        import av

        count = 0
        source = self._source
        device = "v4l2" if source.kind is SourceKind.DEVICE else None
        with av.open(
            io.BytesIO(source.session.encode()) if source.session else source.address,
            "r",
            format="sdp" if source.session else device,
            options={**_OPTIONS[source.kind], **source.options},
            timeout=(_OPEN_S, _READ_S),
        ) as container:
            if not container.streams.video:
                text = f"{self._source.shown} holds no pictures; name a source that does"
                raise CameraError(text)
            stream = container.streams.video[0]
            stream.codec_context.options = {"max_pixels": str(_MOST_PIXELS)}
            if self._pace is None:
                rate = float(stream.average_rate or 0.0)
                self._pace = Pace(1.0 / rate if 1.0 <= rate <= 240.0 else _DEFAULT_PERIOD)
            for frame in self._frames(container.demux(stream), av.error.InvalidDataError):
                self._keep(frame)
                count += 1
                if self._ended.is_set():
                    break
        return count

    def _frames(
        self, packets: Iterator[Any], damaged_error: type[Exception]
    ) -> Iterator[av.VideoFrame]:
        """The pictures in the packets, without those that cannot be decoded."""
        damaged = 0
        for packet in packets:
            try:
                frames = packet.decode()
            except damaged_error:
                damaged += 1
                if damaged > _MOST_DAMAGED:
                    raise
                continue
            for frame in frames:
                damaged = 0
                yield frame

    def _keep(self, frame: av.VideoFrame) -> None:
        """Make a picture the newest one, at its time."""
        if not self._source.live and self._pace is not None:
            self._ended.wait(self._pace.delay(frame.time, self._clock()))
        now = self._clock()
        if self._shot is None:
            _logger.info("pictures come from %s", self._source.shown)
        measured = taken(frame.time, now) if self._source.kind is SourceKind.DEVICE else now
        self._shot = Shot(frame=frame, measured=measured)


def taken(time_in_stream: float | None, now: float) -> float:
    """The time of a picture, on the monotonic clock [s].

    Video4Linux stamps pictures with that clock; for a driver with another clock, now counts.
    """
    if time_in_stream is not None and 0.0 <= now - time_in_stream <= _STALE_S:
        return time_in_stream
    return now
