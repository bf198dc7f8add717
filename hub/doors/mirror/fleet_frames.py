"""Messages of the bus from a fleet's, and headers for a fleet, within the ages that count; pure."""

from __future__ import annotations

import collections

from hub.errors import FrameError
from hub.ipc.wire import frames
from hub.zenoh.attachment import Attachment

_FARTHEST_NS = 1 << 62
_LONGEST = frames.MAX_FRAME - frames.MAX_TOPIC - 8 - frames.HEADER_SIZE


def frame_of(name: str, payload: bytes, header: Attachment, offset: float) -> frames.Frame:
    """A message of a robot, its stamp on this process's clock.

    Args:
        name: Of the message.
        payload: Its bytes.
        header: As the robot sent it.
        offset: The robot's time minus this process's, at most [s].

    Raises:
        FrameError: It is too long for the bus, or from another age.
    """
    stamp_ns = header.stamp_ns - round(offset * 1e9)
    if not -_FARTHEST_NS < stamp_ns < _FARTHEST_NS or len(payload) > _LONGEST:
        text = f"{name} of {len(payload)} bytes with the stamp {header.stamp_ns} is no message"
        raise FrameError(text)
    return frames.Frame(
        name=name,
        kind=frames.INLINE,
        publisher=header.publisher,
        fingerprint=header.fingerprint,
        sequence=header.sequence,
        stamp_ns=stamp_ns,
        payload=memoryview(payload),
    )


class SentHeaders:
    """Makes the headers of messages to a robot; each session counts its messages."""

    def __init__(self) -> None:
        """Count from 1."""
        self._sequences: collections.Counter[tuple[str, int]] = collections.Counter()

    def pack(self, name: str, session: int, fingerprint: int, time: float) -> bytes:
        """The next header of a session.

        Args:
            name: Of the message.
            session: Of its sender.
            fingerprint: Of its format.
            time: Of its measurement, on the robot's clock [s].

        Raises:
            FrameError: It is from another age.
        """
        stamp_ns = round(time * 1e9)
        if not -_FARTHEST_NS < stamp_ns < _FARTHEST_NS:
            text = f"{name} was measured at {time:g} s, which is no time; send it with the hub's"
            raise FrameError(text)
        self._sequences[name, session] += 1
        return Attachment(
            publisher=session,
            fingerprint=fingerprint,
            sequence=self._sequences[name, session],
            stamp_ns=stamp_ns,
        ).pack()

    def forget(self, session: int) -> None:
        """A session has ended."""
        for key in [each for each in self._sequences if each[1] == session]:
            del self._sequences[key]

    def clear(self) -> None:
        """All have ended."""
        self._sequences.clear()
