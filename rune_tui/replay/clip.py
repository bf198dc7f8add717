"""Writes a part of a recording as a video: MP4 by PyAV, or GIF."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from PIL import Image

from hub.recording.holes import beyond_hole
from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.picture import image
from rune_tui.errors import LogError, PictureFileError
from rune_tui.replay import screen
from rune_tui.replay.desk import SECOND, Desk
from rune_tui.replay.player import Player

if TYPE_CHECKING:
    from av import VideoFrame, VideoStream

SUFFIXES = (".mp4", ".gif")
_CRF = "20"
"""Quality of an MP4, as x264 counts it: text stays sharp enough to read."""
_GIF_COLOURS = 128


@dataclass(frozen=True, slots=True, kw_only=True)
class ClipOptions:
    """Which part of a recording becomes a video, and how.

    Attributes:
        start: Its begin after that of the recording [ns].
        end: Its end after the begin of the recording [ns]; None: that of the recording.
        rate: Log time over the video's time.
        frames_per_s: Frames of the video [1/s].
        scale: Width of a cell in the video [px].
        as_seen: Whether to leave out the border that says that it is a recording.
        lossless: Whether an MP4 keeps each pixel; some players cannot show that.
    """

    start: int = 0
    end: int | None = None
    rate: float = 1.0
    frames_per_s: float = 10.0
    scale: int = 8
    as_seen: bool = False
    lossless: bool = False


def write_clip(
    player: Player, path: Path, options: ClipOptions, progress: Callable[[float], None]
) -> int:
    """Write a video; the file is there when it is complete.

    Args:
        player: Plays the recording.
        path: The file; its suffix gives the format.
        options: Which part, and how.
        progress: Gets the share that is done, 0 to 1, after each frame.

    Returns:
        Number of frames.

    Raises:
        LogError: There is nothing to show in this part.
        PictureFileError: The file cannot be written, or PyAV is missing.
    """
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        count = _write(player, part, options, progress)
        part.replace(path)
    except OSError as error:
        text = f"{path} cannot be written: {error.strerror or error}; choose another place"
        raise PictureFileError(text) from error
    finally:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
    return count


class _Encoder(Protocol):
    """Takes pictures of one size."""

    def add(self, picture: Image.Image) -> None:
        """Add a picture."""

    def close(self) -> None:
        """Write what is left."""


def _write(
    player: Player, part: Path, options: ClipOptions, progress: Callable[[float], None]
) -> int:
    stamps = list(_stamps(player, options))
    painter = _Painter(player, options)
    encoder: _Encoder | None = None
    try:
        for number, stamp in enumerate(stamps, 1):
            picture = painter.picture(stamp)
            if encoder is None:
                encoder = _encoder(part, picture.size, options)
            encoder.add(picture)
            progress(number / len(stamps))
    finally:
        if encoder is not None:
            encoder.close()
    return len(stamps)


def _stamps(player: Player, options: ClipOptions) -> Iterator[int]:
    """The time of the recording for each frame of the video [ns]."""
    source = player.source
    begin = source.start + options.start
    end = source.end if options.end is None else min(source.end, source.start + options.end)
    step = options.rate * SECOND / options.frames_per_s
    if end < begin or source.frame_before(end) is None:
        text = f"{source.title} has nothing in this part"
        raise LogError(text)
    number = 0
    while (stamp := begin + round(number * step)) <= end:
        after = beyond_hole(source.holes, stamp)
        if after != stamp:
            begin, number = after, 0
        else:
            yield stamp
            number += 1


class _Painter:
    """Draws the screen at times that follow each other."""

    def __init__(self, player: Player, options: ClipOptions) -> None:
        self._player = player
        self._options = options
        self._desk = Desk(player, lambda: 0.0)
        self._desk.say("")
        if not options.as_seen:
            self._desk.overview = player.survey()
        self._size: tuple[int, int] | None = None
        self._last: tuple[Cells, Image.Image] | None = None

    def picture(self, stamp: int) -> Image.Image:
        """The screen at a time; equal screens are one object."""
        self._player.seek(stamp)
        frame = self._player.drawer.cells
        if frame is None:  # before the first frame: the first one is shown
            self._player.seek(self._player.source.frame_after(stamp) or stamp)
            frame = self._player.drawer.cells
        if frame is None:
            text = f"{self._player.source.title} has nothing to draw"
            raise LogError(text)
        if self._size is None:
            self._size = frame.columns, frame.rows
        columns, rows = self._size
        if self._options.as_seen:
            cells = frame
        else:
            wide, high = columns + 2 * screen.SIDES, rows + screen.TOP + screen.BOTTOM
            cells = self._desk.cells(wide, high)
        if self._last is None or self._last[0] is not cells:
            picture = image(cells, scale=self._options.scale)
            if self._last is not None and picture.size != self._last[1].size:
                picture = _padded(picture, self._last[1].size)
            self._last = cells, picture
        return self._last[1]


def _padded(picture: Image.Image, size: tuple[int, int]) -> Image.Image:
    """A picture at the upper left of another size: the terminal was resized."""
    canvas = Image.new("RGB", size)
    canvas.paste(picture, (0, 0))
    return canvas


def _encoder(path: Path, size: tuple[int, int], options: ClipOptions) -> _Encoder:
    if path.suffix.lower() == ".gif":
        return _GifFile(path, options.frames_per_s)
    return _Mp4File(path, size, options)


class _Mp4File:
    """An MP4 file with H.264."""

    def __init__(self, path: Path, size: tuple[int, int], options: ClipOptions) -> None:
        try:
            import av
        except ModuleNotFoundError as error:
            text = "PyAV is missing; install it with pip install 'robot-user-nexus[camera]'"
            raise PictureFileError(text) from error
        self._av, self._broken = av, False
        self._size = size[0] + size[0] % 2, size[1] + size[1] % 2
        self._container = av.open(str(path), "w", format="mp4")
        rate = Fraction(options.frames_per_s).limit_denominator(1000)
        codec = "libx264rgb" if options.lossless else "libx264"
        self._stream = cast("VideoStream", self._container.add_stream(codec, rate=rate))
        self._stream.width, self._stream.height = self._size
        self._stream.pix_fmt = "rgb24" if options.lossless else "yuv420p"
        quality = "0" if options.lossless else _CRF
        self._stream.options = {"crf": quality, "preset": "superfast"}

    def add(self, picture: Image.Image) -> None:
        """Add a picture."""
        if picture.size != self._size:
            picture = _padded(picture, self._size)
        frame = self._av.VideoFrame.from_ndarray(np.asarray(picture), format="rgb24")
        self._mux(frame)

    def close(self) -> None:
        """Write what is left."""
        try:
            if not self._broken:
                self._mux(None)
        finally:
            self._container.close()

    def _mux(self, frame: VideoFrame | None) -> None:
        """Write a frame; None: those that the codec kept back.

        After a fault nothing more may be written: FFmpeg would read what it never allocated.
        """
        self._broken = True
        for packet in self._stream.encode(frame):
            self._container.mux(packet)
        self._broken = False


class _GifFile:
    """A GIF file; equal pictures that follow each other become one of greater length."""

    def __init__(self, path: Path, frames_per_s: float) -> None:
        self._path = path
        self._each_ms = 1000.0 / frames_per_s
        self._pictures: list[tuple[Image.Image, int]] = []
        self._last: Image.Image | None = None

    def add(self, picture: Image.Image) -> None:
        """Add a picture."""
        if picture is self._last:
            reduced, count = self._pictures[-1]
            self._pictures[-1] = reduced, count + 1
            return
        self._last = picture
        reduced = picture.quantize(
            _GIF_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
        )
        self._pictures.append((reduced, 1))

    def close(self) -> None:
        """Write what is left."""
        if self._pictures:
            (first, _), *rest = self._pictures
            first.save(
                self._path,
                "GIF",
                save_all=True,
                append_images=[picture for picture, _ in rest],
                duration=[round(count * self._each_ms) for _, count in self._pictures],
                loop=0,
                optimize=False,
            )
