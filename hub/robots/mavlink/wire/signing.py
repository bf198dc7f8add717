"""Signatures of MAVLink 2 frames: https://mavlink.io/en/guide/message_signing.html.

A signature is the number of a link, a stamp, and six bytes of SHA-256 over key, frame and both.
Stamps count 10 us since 2015. Each is greater than the one before of the same sender and link.
"""

from __future__ import annotations

import contextlib
import hashlib
import hmac
import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Final

from hub import files

_logger = logging.getLogger(__name__)
SIGNATURE: Final = 13
"""Length of a signature [bytes]."""
_SHORT: Final = 6
"""Bytes of the hash in it."""
_EPOCH: Final = 1420070400.0
"""1 January 2015 [s since the epoch of Unix]."""
_PER_SECOND: Final = 100_000
_AHEAD: Final = 10 * _PER_SECOND
"""The stamp on disk is so far ahead of the last one: after a crash none comes twice."""
_NEW_SENDER: Final = 60 * _PER_SECOND
"""The first frame of a sender may be so far behind the newest stamp."""
_MOST_SENDERS: Final = 64
"""Most senders whose stamps are kept; frames of others are refused."""
_MOST_BYTES: Final = 64
"""Longest file of a stamp [bytes]."""


class SigningClock:
    """Gives stamps that only grow, also after a restart with another system time.

    A vehicle takes no frame with a stamp before the last one. It would be deaf to a station whose
    system time went back.
    """

    def __init__(
        self, path: Path | None = None, wall_clock: Callable[[], float] = time.time
    ) -> None:
        """Go on after the stamp in a file.

        Args:
            path: The file, which need not be there yet; None: only the system time counts.
            wall_clock: The system time [s since the epoch].
        """
        self._path = path
        self._wall_clock = wall_clock
        self._last = self._kept = _stamp_in(path)
        self._said = False

    @property
    def last(self) -> int:
        """The newest stamp that was given or heard."""
        return self._last

    def next(self) -> int:
        """The next stamp; a file that cannot be written is said once, and the vehicle driven on."""
        now = int((self._wall_clock() - _EPOCH) * _PER_SECOND)
        self._last = max(self._last + 1, now)
        if self._path is not None and self._last >= self._kept:
            self._kept = self._last + _AHEAD
            self._keep(self._path)
        return self._last

    def _keep(self, path: Path) -> None:
        try:
            files.replace(path, b"%d\n" % self._kept, mode=0o600)
        except OSError as fault:
            if not self._said:
                text = "%s cannot be written: %s; a hub whose clock goes back may not be heard"
                _logger.warning(text, path, fault.strerror)
            self._said = True

    def heard(self, stamp: int) -> None:
        """Take the stamp of a genuine frame: what is sent next is newer."""
        self._last = max(self._last, stamp)


def _stamp_in(path: Path | None) -> int:
    """The stamp in a file; 0: there is none."""
    if path is not None:
        with contextlib.suppress(OSError, ValueError):
            return max(0, min(2**47, int(files.read_regular(path, _MOST_BYTES))))
    return 0


class Signer:
    """Signs the frames of one sender on one link, and checks those of others."""

    def __init__(self, key: bytes, clock: SigningClock, link: int = 0) -> None:
        """Take a key.

        Args:
            key: Its 32 bytes.
            clock: Gives the stamps.
            link: Number of the link, 0 to 255.
        """
        self._key = key
        self._clock = clock
        self._link = bytes((link,))
        self._newest: dict[tuple[int, int, int], int] = {}

    def signature(self, frame: bytes) -> bytes:
        """The signature of a frame that ends with its checksum."""
        tail = self._link + self._clock.next().to_bytes(6, "little")
        return tail + self._hash(frame + tail)

    def genuine(self, frame: bytes, system: int, component: int) -> bool:
        """Whether a frame with its signature comes from an owner of the key, for the first time.

        Args:
            frame: The whole frame.
            system: Its sender.
            component: Its sender.
        """
        if not hmac.compare_digest(self._hash(frame[:-_SHORT]), frame[-_SHORT:]):
            return False
        sender = system, component, frame[-SIGNATURE]
        stamp = int.from_bytes(frame[1 - SIGNATURE : -_SHORT], "little")
        newest = self._newest.get(sender)
        if newest is None:
            if stamp < self._clock.last - _NEW_SENDER or len(self._newest) >= _MOST_SENDERS:
                return False
        elif stamp <= newest:
            return False
        self._newest[sender] = stamp
        self._clock.heard(stamp)
        return True

    def _hash(self, frame: bytes) -> bytes:
        return hashlib.sha256(self._key + frame).digest()[:_SHORT]
