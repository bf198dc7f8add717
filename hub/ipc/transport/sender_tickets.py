"""Tickets: central vouches for the number of each sender of commands, connection by connection.

A number in a frame may be forged. So the receiver of commands makes a key that only central gets.
Central gives each sender a ticket for its number, made with that key, and the sender shows it when
it connects. The receiver then admits frames of that connection under that number only.

| connection | frame | action |
| --- | --- | --- |
| with a ticket for the number of the frame, or for `ANY` | any | admit |
| any | a stop; not as a query | admit |
| any | without a name or a number | admit; the reader counts it |
| all others | any | refuse, count |

A bundle is checked frame by frame. A connection of ZMTP 2 has no properties at all, as one inside
this process has none. So only a ticket counts.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets

import zmq

from hub.errors import FrameError
from hub.ipc.definition import Plane
from hub.ipc.security.publish_rights import right
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames

ANY = 0
"""The number in the ticket of a client that forwards messages under the numbers of others."""
_PROPERTY = "X-Rune-Sender"
_KEY = re.compile(r"[0-9a-f]{32}")
_TICKET = re.compile(r"[0-9a-f]{1,8}\.[0-9a-f]{32}")
_MOST_KNOWN = 1024


def ticket(key: str, number: int) -> str:
    """The ticket for a number, made with a receiver's key; empty: it is not a key."""
    if not _KEY.fullmatch(key):
        return ""
    seal = hashlib.blake2b(b"%x" % number, key=key.encode(), digest_size=16)
    return f"{number:x}.{seal.hexdigest()}"


def show(socket: zmq.Socket[bytes], shown: str) -> None:
    """Show a ticket at each connection that this socket makes from now on.

    Args:
        socket: The socket.
        shown: From central; another text is not shown.
    """
    if _TICKET.fullmatch(shown):
        socket.setsockopt(zmq.METADATA, f"{_PROPERTY}:{shown}".encode())


class SenderTickets:
    """A receiver's key, and its check of frames; one thread uses `admit`.

    Attributes:
        key: For central.
    """

    def __init__(self, faults: FaultCounter) -> None:
        """Make a key.

        Args:
            faults: Counts refused frames.
        """
        self.key = secrets.token_hex(16)
        self._faults = faults
        self._numbers: dict[str, int | None] = {}

    def admit(self, raw: bytes, frame: zmq.Frame) -> bytes | None:
        """What to deliver of a frame, or of a bundle; None: nothing. The rest is counted.

        Args:
            raw: The bytes.
            frame: The same, as ZeroMQ received it.
        """
        number = self._number(_shown(frame))
        if number == ANY or frames.sender_of(raw) == number:
            return raw
        if not frames.is_bundle(raw):
            return raw if self._may_count(raw, number) else None
        try:
            whole = frames.split_bundle(raw)
        except FrameError:
            return raw
        kept = [each for each in whole if self._may_count(each, number)]
        if len(kept) == len(whole):
            return raw
        return frames.bundle(kept) if kept else None

    def admits_query(self, frame: zmq.Frame) -> bool:
        """Whether the message of a query has the number of its connection; no query is a stop."""
        number = self._number(_shown(frame))
        sender = frames.sender_of(frame.bytes)
        if number == ANY or sender in (number, -1):
            return True
        self._refuse("a query", sender)
        return False

    def _may_count(self, raw: bytes, number: int | None) -> bool:
        """Whether readers may get one frame of a connection with this number; None: it has none."""
        try:
            name = frames.name_of(raw)
        except FrameError:
            return True
        # Readers take the number from this place, even if the frame is damaged elsewhere.
        sender = frames.sender_of(raw)
        if sender in (number, -1) or right(name, Plane.COMMAND.value).unordered:
            return True
        try:
            frames.unpack(raw)
            self._refuse(name, sender)
        except FrameError as error:
            self._faults.count("malformed frame", str(error))
        return False

    def _refuse(self, name: str, sender: int) -> None:
        text = f"{name} came under number {sender} from a connection without its ticket"
        self._faults.count("forged number", text)

    def _number(self, shown: str) -> int | None:
        """The number in a ticket; None: it is not from central."""
        known = self._numbers.get(shown, ANY)
        if known != ANY:
            return known
        if not _TICKET.fullmatch(shown):
            return None  # not kept: it may be long
        claimed = int(shown.partition(".")[0], 16)
        number = claimed if hmac.compare_digest(shown, ticket(self.key, claimed)) else None
        if len(self._numbers) >= _MOST_KNOWN:
            self._numbers.clear()
        self._numbers[shown] = number
        return number


def _shown(frame: zmq.Frame) -> str:
    """The text that the connection of a frame shows as its ticket; empty: none."""
    try:
        return str(frame.get(_PROPERTY))
    except (zmq.ZMQError, UnicodeDecodeError):
        return ""
