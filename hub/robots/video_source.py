"""Sources of a real camera's pictures, and sentences on their faults; pure."""

from __future__ import annotations

import enum
import errno
import ipaddress
import math
import re
from collections.abc import Mapping
from dataclasses import field
from typing import Final
from urllib.parse import urlsplit

from hub.errors import CameraError
from hub.values import dataclass

_SCHEMES = ("rtsp", "rtsps", "http", "https", "rtp", "udp")
_DATAGRAMS = ("rtp", "udp")
_LOOPBACK: Final = "127.0.0.1"
_CODECS: Final[Mapping[str, str]] = {"": "H264", "codec=h264": "H264", "codec=h265": "H265"}
"""Names of codecs in session descriptions, by what stands after the ? of an address."""
_SESSION: Final = """\
v=0
o=- 0 0 IN IP{version} {host}
s=-
c=IN IP{version} {host}
t=0 0
m=video {port} RTP/AVP 96
a=rtpmap:96 {codec}/90000
"""
"""RTP has no announcement of its own: vehicles send payload type 96."""
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
_INTERRUPTED: Final = "Immediate exit requested"
"""FFmpeg's words where its owner ended the wait."""
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
        session: Its pictures as SDP describes them, where RTP has them; else empty.
        options: For opening it.
    """

    kind: SourceKind
    address: str
    shown: str
    session: str = ""
    options: Mapping[str, str] = field(default_factory=dict)

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
    if scheme in _DATAGRAMS:
        return _datagrams(text, scheme)
    return VideoSource(kind=SourceKind.STREAM, address=text, shown=shown)


def _datagrams(text: str, scheme: str) -> VideoSource:
    """The source of datagrams that are sent to this machine."""
    try:
        parts = urlsplit(text)
        own = ipaddress.ip_address(parts.hostname or _LOOPBACK)
        port, codec = parts.port, _CODECS[parts.query]
    except (ValueError, KeyError) as fault:
        raise CameraError(_no_datagrams(text)) from fault
    more = parts.path or parts.username or parts.fragment or (scheme == "udp" and parts.query)
    if not port or more:
        raise CameraError(_no_datagrams(text))
    host = f"[{own}]" if own.version == 6 else str(own)
    session = _SESSION.format(version=own.version, host=own, port=port, codec=codec)
    everywhere = own.is_unspecified or own.is_multicast
    return VideoSource(
        kind=SourceKind.STREAM,
        address=f"{scheme}://{host}:{port}",
        shown=text,
        session=session if scheme == "rtp" else "",
        options={} if everywhere else {"localaddr": str(own)},
    )


def _no_datagrams(text: str) -> str:
    return (
        f"no pictures can come to {text}: give an address of this machine and a port, such as "
        "udp://0.0.0.0:5600 for MPEG-TS, rtp://0.0.0.0:5600 or rtp://0.0.0.0:5600?codec=h265"
    )


def why_not(source: VideoSource, fault: Exception) -> str:
    """A sentence with the reason why a source gives no pictures, and the remedy."""
    number = (fault.errno if isinstance(fault, OSError) else None) or 0
    reason = getattr(fault, "strerror", None) or str(fault) or type(fault).__name__
    shown = source.shown
    reason = "nothing came for some seconds" if reason == _INTERRUPTED else reason
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
