"""Tickets: central vouches for the number of each sender of commands, connection by connection.

A number in a frame may be forged. So the receiver of commands makes a key that only central gets.
Central gives each sender a ticket for its number, made with that key, and the sender shows it when
it connects. The receiver then admits frames of that connection under that number only.

| connection | frame | action |
| --- | --- | --- |
| with a ticket for the number of the frame, or for `ANY` | any | admit |
| from inside this process: its sender has checked the frame | any | admit |
| any | a stop | admit |
| any | unreadable | admit; the reader counts it |
| all others | any | refuse, count |
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
        """The frame to deliver; None, and counted: its number is not its connection's.

        Args:
            raw: The bytes.
            frame: The same, as ZeroMQ received it.
        """
        try:
            shown = str(frame.get(_PROPERTY))
        except zmq.ZMQError:
            shown = ""
        number = self._number(shown)
        if number == ANY or (number is not None and frames.is_sent_by(raw, number)):
            return raw
        try:
            wrong = next((each for each in _senders(raw) if each[1] != number), None)
        except FrameError:
            return raw
        if wrong is None or (not shown and _is_inner(frame)):
            return raw
        text = f"{wrong[0]} came under number {wrong[1]} from a connection without its ticket"
        self._faults.count("forged number", text)
        return None

    def _number(self, shown: str) -> int | None:
        """The number in a ticket; None: it is not from central."""
        known = self._numbers.get(shown, ANY)
        if known != ANY:
            return known
        number = None
        if _TICKET.fullmatch(shown):
            claimed = int(shown.partition(".")[0], 16)
            number = claimed if hmac.compare_digest(shown, ticket(self.key, claimed)) else None
        if len(self._numbers) >= _MOST_KNOWN:
            self._numbers.clear()
        self._numbers[shown] = number
        return number


def _senders(raw: bytes) -> list[tuple[str, int]]:
    """Name and number of each frame whose number counts: of all but stops.

    Raises:
        FrameError: They cannot be read.
    """
    found = []
    for each in frames.split_bundle(raw) if frames.is_bundle(raw) else (raw,):
        name = frames.name_of(each)
        if not right(name, Plane.COMMAND.value).unordered:
            found.append((name, frames.unpack(each).publisher))
    return found


def _is_inner(frame: zmq.Frame) -> bool:
    """Whether a frame came over inproc: only there a connection has no properties."""
    try:
        frame.get("Socket-Type")
    except zmq.ZMQError:
        return True
    return False
