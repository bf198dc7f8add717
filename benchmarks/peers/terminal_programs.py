"""Programs of others that play video in a terminal: bytes and CPU time a frame, on a pty.

Both play the same raw frames; what only reading them takes is measured apart and taken off.
"""

from __future__ import annotations

import fcntl
import os
import pty
import shutil
import struct
import subprocess
import termios
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

_REPEATED = 10
"""How often a scene is played in a row, so that starting counts little."""
_ENVIRONMENT = {"COLORTERM": "truecolor", "TERM": "xterm-256color", "LC_ALL": "C.UTF-8"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """What a frame cost: CPU time [ms], and bytes."""

    milliseconds: float
    kilobytes: float


def played_by_mpv(scene: Path, columns: int, rows: int, frames: int) -> Played | None:
    """None if it is not installed."""
    if not shutil.which("mpv"):
        return None
    film = scene.with_suffix(".film")
    film.write_bytes(scene.read_bytes() * _REPEATED)
    command = [
        *("mpv", "--no-config", "--demuxer=rawvideo", "--demuxer-rawvideo-mp-format=rgb24"),
        *(f"--demuxer-rawvideo-w={columns}", f"--demuxer-rawvideo-h={2 * rows}"),
        *("--demuxer-rawvideo-fps=30", "--no-audio", "--untimed", "--really-quiet"),
        *("--no-input-terminal", "--no-keepaspect", "--sws-scaler=fast-bilinear", str(film)),
    ]
    sized = (f"--vo-tct-width={columns}", f"--vo-tct-height={rows}")
    reading, _ = _run([*command, "--vo=null"], columns, rows)
    spent, written = _run([*command, "--vo=tct", *sized], columns, rows)
    return _a_frame(spent - reading, written, frames)


def played_by_timg(scene: Path, columns: int, rows: int, frames: int) -> Played | None:
    """None if it is not installed, or FFmpeg, which makes a file that it can read."""
    if not (shutil.which("timg") and shutil.which("ffmpeg")):
        return None
    film, packed = scene.with_suffix(".film"), scene.with_suffix(".nut")
    film.write_bytes(scene.read_bytes() * _REPEATED)
    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{columns}x{2 * rows}", "-r", "120")
    made = ["ffmpeg", "-v", "error", "-y", *raw, "-i", str(film), "-c:v", "rawvideo"]
    subprocess.run([*made, "-pix_fmt", "rgb24", str(packed)], check=True)
    reader = ["ffmpeg", "-v", "error", "-threads", "1", "-i", str(packed), "-f", "null", "-"]
    reading, _ = _run(reader, columns, rows)
    command = ["timg", "-ph", f"-g{columns}x{rows}", "--threads=1", str(packed)]
    # A row more, so that it does not scroll.
    spent, written = _run(command, columns, rows + 12)
    return _a_frame(spent - reading, written, frames)


def _a_frame(seconds: float, written: int, frames: int) -> Played:
    count = frames * _REPEATED
    return Played(milliseconds=seconds * 1e3 / count, kilobytes=written / 1e3 / count)


def _run(command: Sequence[str], columns: int, rows: int) -> tuple[float, int]:
    """CPU time of a program [s] and the bytes that it writes to a terminal of its own."""
    child, terminal = pty.fork()
    if child == 0:
        os.execvpe(command[0], list(command), os.environ | _ENVIRONMENT)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    written = 0
    while data := _read(terminal):
        written += len(data)
    _, status, usage = os.wait4(child, 0)
    os.close(terminal)
    if status:
        text = f"{command[0]} ended with status {os.waitstatus_to_exitcode(status)}"
        raise RuntimeError(text)
    return usage.ru_utime + usage.ru_stime, written


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 1 << 16)
    except OSError:  # it has ended
        return b""
