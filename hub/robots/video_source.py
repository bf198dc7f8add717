"""Sources of a real camera's pictures, and sentences on their faults; pure."""

from __future__ import annotations

import enum
import errno
import math
import re

from hub.errors import CameraError
from hub.values import dataclass

_SCHEMES = ("rtsp", "rtsps", "http", "https")
_FIX = "correct 'source' under [camera] in the robot file"
_PLUG_IN = f"is not there; plug it in, or {_FIX}"
_DEVICE_FAULTS = {
    errno.ENOENT: _PLUG_IN,
    errno.ENODEV: _PLUG_IN,
    errno.ENXIO: _PLUG_IN,
    errno.EACCES: "may not be used by this user; add the user to the group that owns it, "
    "usually 'video', and log in again",
    errno.EBUSY: "is used by another program; end that program",
}
_LONGEST_STEP = 1.0
"""Longest gap between two pictures of a file that is played [s]."""
_LATE = 0.25
"""Delay from which late pictures are played at normal speed, without catching up [s]."""


class SourceKind(enum.Enum):
    """The kind of a source."""

    DEVICE = enum.auto()
    FILE = enum.auto()
    STREAM = enum.auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoSource:
    """A camera, a file, or a stream from the network.

    Attributes:
        kind: Its kind.
        address: Its address for opening.
        shown: Its name in messages, without a password.
    """

    kind: SourceKind
    address: str
    shown: str

    @property
    def live(self) -> bool:
        """Whether its pictures are live."""
        return self.kind is not SourceKind.FILE


def video_source(text: str) -> VideoSource:
    """The source of pictures in a robot file.

    Raises:
        CameraError: It is an address of an unknown kind.
    """
    scheme, separator, rest = text.partition("://")
    if not separator:
        device = text.startswith("/dev/")
        kind = SourceKind.DEVICE if device else SourceKind.FILE
        return VideoSource(kind=kind, address=text, shown=text)
    shown = f"{scheme}://{re.sub('^[^/]*@', '', rest)}"
    if scheme not in _SCHEMES:
        text = (
            f"no pictures can be had from {shown}: give a device, a path, or an address that "
            f"begins with one of {', '.join(f'{known}://' for known in _SCHEMES)}"
        )
        raise CameraError(text)
    return VideoSource(kind=SourceKind.STREAM, address=text, shown=shown)


def why_not(source: VideoSource, fault: Exception) -> str:
    """A sentence with the reason why a source gives no pictures, and the remedy."""
    number = (fault.errno if isinstance(fault, OSError) else None) or 0
    reason = getattr(fault, "strerror", None) or str(fault) or type(fault).__name__
    shown = source.shown
    reason = reason.replace(source.address, shown)
    if source.kind is SourceKind.STREAM:
        return (
            f"no pictures come from {shown}: {reason}; see that the camera there is on, or {_FIX}"
        )
    if source.kind is SourceKind.FILE:
        return f"the video file {shown} cannot be shown: {reason}; {_FIX}"
    return f"the camera {shown} {_DEVICE_FAULTS.get(number, f'gives no pictures: {reason}')}"


class Pace:
    """The times of a file's pictures, at its own speed; pure."""

    def __init__(self, period: float) -> None:
        """Start with the first picture at once.

        Args:
            period: Time between pictures without a time of their own [s].
        """
        self._period = period
        self._offset = math.nan
        self._last = -math.inf

    def delay(self, time: float | None, now: float) -> float:
        """The wait until a picture is due [s].

        Args:
            time: The picture's time in the file [s]; None: it has none.
            now: Monotonic time [s].
        """
        if time is None or not math.isfinite(time):
            time = self._last + self._period if math.isfinite(self._last) else 0.0
        step = time - self._last
        if math.isnan(self._offset):
            self._offset = now - time
        elif not 0.0 <= step <= _LONGEST_STEP:
            # It restarts, or has a long gap.
            self._offset += self._last + self._period - time
        self._last = time
        wait = self._offset + time - now
        if wait < -_LATE:
            self._offset = now - time
        return min(max(0.0, wait), _LONGEST_STEP)
