"""One WebSocket to a bridge, without waiting.

| state | event | action |
| --- | --- | --- |
| closed | the time of the next attempt | look up the name, begin to connect |
| opening | 5 s without a greeting | lose it |
| open | bytes | messages, and pings answered |
| open | a second since the last ping was answered | ping |
| open | a second without an answer to a ping | no velocity leaves: it would wait on the way |
| open | 3 s without a byte since a ping | lose it: it is open at this end only |
| open | 256 kB wait to leave | lose it |
| any | a fault | lose it; the next attempt is a second later, after five of them up to five |

A lost connection is reset, so that nothing of it leaves later.
"""

from __future__ import annotations

import collections
import contextlib
import errno
import math
import ssl
import struct
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, cast

from hub.plain_text import plain
from hub.robots.interfaces import FileLoop
from hub.robots.refusals import Refusals
from hub.robots.ros.address import RosAddress
from hub.robots.ros.foxglove.byte_stream import ByteStream
from hub.robots.ros.foxglove.wire import SUBPROTOCOLS
from hub.ros.panel_door_name import PANEL_DOOR_SERVER

if TYPE_CHECKING:
    from websockets.client import ClientProtocol
    from websockets.frames import Frame

MOST_MESSAGE: Final = 1 << 25
"""Longest message of a bridge [bytes]."""
MOST_WAITING: Final = 1 << 18
"""Most bytes that wait to leave [bytes]."""
_MOST_READ: Final = 1 << 20
_MOST_FRAMES: Final = 500
"""About the most bytes and frames of one `advance`; the rest waits. A flood leaves the driver
time."""
_OPENING_S: Final = 5.0
"""Longest time until the bridge has greeted [s]."""
_PING_S: Final = 1.0
_QUIET_S: Final = 1.0
"""After this time without an answer to a ping no velocity leaves [s]."""
_SILENT_S: Final = 3.0
RETRY_S: Final = 1.0
"""Time between the first attempts [s]."""
_QUICK_RETRIES: Final = 5
_SLOWEST_RETRY_S: Final = 5.0
_CONTINUATION, _TEXT, _BINARY, _PONG = 0, 1, 2, 10
"""Kinds of frames of a WebSocket."""
_MOST_WORDS: Final = 300
"""Longest reason of a lost connection [characters]; part of it may come from the other end."""
HUBS_DOOR: Final = (
    "the door of a hub for panels answers there (`rune-hub serve foxglove`), and no bridge of a "
    "robot: start the bridge, or give its port; --port moves the door"
)


class FoxgloveConnection:
    """Messages to and from a bridge; used by one thread.

    Attributes:
        made: How often the bridge greeted.
        heard: When bytes were last received [s, monotonic]; -inf: never.
        why: The last fault in words; empty: there was none.
        lost: Called after a connection was lost.
        answered: Called with the time from a ping to its answer, and with now [s].
    """

    def __init__(self, address: RosAddress) -> None:
        """Take the address; nothing is opened yet."""
        self.made = 0
        self.heard = -math.inf
        self.why = ""
        self.lost: Callable[[], None] = lambda: None
        self.answered: Callable[[float, float], None] = lambda _, __: None
        self._address = address
        self._stream = ByteStream(address)
        self._protocol: ClientProtocol | None = None
        self._opened = self._greeted = False
        self._now = self._begun = self._retry_at = self._pinged = -math.inf
        self._ping = b""
        self._failures = 0
        self._refusals = Refusals()
        self._messages: collections.deque[tuple[bool, bytes | bytearray]] = collections.deque()
        self._parts: bytearray | None = None
        self._is_text = False
        self._waiting = bytearray()

    @property
    def up(self) -> bool:
        """Whether the bridge has greeted."""
        return self._greeted

    @property
    def refused_since(self) -> float:
        """Since when the host refuses connections [s, monotonic]; infinite: it does not."""
        return math.inf if self._stream.is_open else self._refusals.since

    @property
    def prompt(self) -> bool:
        """Whether a message that is sent now leaves now, as far as can be seen."""
        unanswered = self._now - self._pinged if self._ping else 0.0
        if not self._greeted or self._waiting or unanswered >= _QUIET_S:
            return False
        return self._stream.unsent == 0

    def greet(self) -> None:
        """Note that the other end is a bridge."""
        if not self._greeted:
            self._greeted, self._failures = True, 0
            self.why = ""
            self.made += 1

    def advance(self, now: float) -> None:
        """Connect if need be, read, send what waits; never waits.

        Args:
            now: Monotonic time [s].
        """
        self._now = now
        try:
            if not self._stream.is_open and now >= self._retry_at:
                self._open()
            if self._stream.is_open and not self._stream.joined:
                self._stream.join()
            if self._stream.joined:
                if not self._messages:
                    self._read()
                self._flush()
            self._judge()
        except OSError as fault:
            self.lose(_words(fault), refused=fault.errno == errno.ECONNREFUSED)

    def receive(self) -> tuple[bool, bytes | bytearray] | None:
        """The next message, and before it whether it is a text; None: there is none yet."""
        return self._messages.popleft() if self._messages else None

    def send(self, message: bytes, *, text: bool) -> bool:
        """Send a message, or have it wait; returns whether the connection is open."""
        if not self._opened or self._protocol is None:
            return False
        send = self._protocol.send_text if text else self._protocol.send_binary
        send(message)
        try:
            self._flush()
        except OSError as fault:
            self.lose(_words(fault))
        return self._opened

    def watch(self, loop: FileLoop, work: Callable[[], None]) -> None:
        """Have a loop call `work` whenever there is something to read."""
        self._stream.watch(loop, work)

    def lose(self, why: str, *, at_once: bool = False, refused: bool = False) -> None:
        """Drop the connection with all that waits in it.

        Args:
            why: The reason.
            at_once: Make a new one at the next `advance`; a second after the last attempt at least.
            refused: Whether the system of the host refused it.
        """
        was_open = self._stream.is_open
        self._shut(reset=True)
        self.why = why
        self._failures += 1
        self._refusals.attempt(self._now, refused=refused, addresses=self._stream.addresses)
        delay = min(max(RETRY_S, self._failures - _QUICK_RETRIES + 1), _SLOWEST_RETRY_S)
        self._retry_at = self._begun + RETRY_S if at_once else self._now + delay
        if was_open:
            self.lost()

    def close(self) -> None:
        """Leave; a later `advance` opens it again."""
        if polite := self.prompt and self._protocol is not None:
            self._protocol.send_close()
            with contextlib.suppress(OSError):
                self._flush()
        self._shut(reset=not polite)

    def _shut(self, *, reset: bool) -> None:
        self._stream.shut(reset=reset)
        self._protocol = self._parts = None
        self._messages.clear()
        self._waiting.clear()
        self._opened = self._greeted = False
        self._ping, self._pinged = b"", -math.inf

    def _open(self) -> None:
        self._begun = self._now
        try:
            from websockets.client import ClientProtocol
            from websockets.typing import Subprotocol
            from websockets.uri import parse_uri
        except ImportError as fault:
            text = "websockets is missing: pip install 'robot-user-nexus[ros]'"
            raise OSError(0, text) from fault
        self._stream.open()
        self._protocol = ClientProtocol(
            parse_uri(self._address.url),
            subprotocols=[Subprotocol(each) for each in SUBPROTOCOLS],
            max_size=MOST_MESSAGE,
        )
        self._protocol.send_request(self._protocol.connect())

    def _read(self) -> None:
        size = frames = 0
        while size < _MOST_READ and frames < _MOST_FRAMES and self._protocol is not None:
            data = self._stream.receive()
            if not data:
                return
            size += len(data)
            self.heard = self._now
            self._protocol.receive_data(data)
            events = self._protocol.events_received()
            frames += len(events)
            for event in events:
                self._take(event)
            self._check(self._protocol)
            if self._stream.drained:
                return

    def _take(self, event: object) -> None:
        """Take the answer to the request for a WebSocket, or a frame."""
        opcode = getattr(event, "opcode", None)
        if opcode is None:
            self._opened = True
            return
        frame = cast("Frame", event)
        data = frame.data if isinstance(frame.data, bytes | bytearray) else bytes(frame.data)
        if opcode == _PONG:
            if data == self._ping:
                self._ping = b""
                self.answered(self._now - self._pinged, self._now)
        elif opcode == _CONTINUATION and self._parts is not None:
            self._parts += data
            if frame.fin:
                self._messages.append((self._is_text, self._parts))
                self._parts = None
        elif opcode in (_TEXT, _BINARY):
            self._is_text = opcode == _TEXT
            if frame.fin:
                self._messages.append((self._is_text, data))
            else:
                self._parts = bytearray(data)

    def _check(self, protocol: ClientProtocol) -> None:
        """Raise a fault of the protocol as one of the connection."""
        if protocol.handshake_exc is not None:
            answer = getattr(protocol.handshake_exc, "response", None)
            if answer is not None and answer.headers.get("Server") == PANEL_DOOR_SERVER:
                raise ConnectionError(errno.EPROTO, HUBS_DOOR)
            text = f"no bridge for Foxglove answers: {protocol.handshake_exc}"
            raise ConnectionError(errno.EPROTO, text)
        if self._opened and protocol.state.name != "OPEN":
            if protocol.parser_exc is not None:
                text = f"the bridge sent what no WebSocket has: {protocol.parser_exc}"
            else:
                text = f"the bridge ended the connection: {protocol.close_rcvd or 'no reason'}"
            raise ConnectionError(errno.EPROTO, text)

    def _flush(self) -> None:
        """Send what the protocol made; what cannot leave waits."""
        if self._protocol is None:
            return
        for data in self._protocol.data_to_send():
            self._waiting += data
        self._stream.send(self._waiting)
        if len(self._waiting) > MOST_WAITING:
            raise TimeoutError(errno.ETIMEDOUT, "the bridge takes nothing any more")

    def _unheard(self) -> float:
        """Time since the last sign of the bridge after an unanswered ping [s]."""
        return self._now - max(self.heard, self._pinged) if self._ping else 0.0

    def _judge(self) -> None:
        """Ping, and end a connection that does not answer."""
        if not self._stream.is_open:
            return
        if not self._greeted and self._now - self._begun > _OPENING_S:
            raise TimeoutError(errno.ETIMEDOUT, "no bridge for Foxglove answers")
        if not self._opened or self._protocol is None:
            return
        if self._unheard() > _SILENT_S:
            text = f"the bridge has been silent for {_SILENT_S:.0f} s"
            raise TimeoutError(errno.ETIMEDOUT, text)
        if not self._ping and self._now - self._pinged >= _PING_S:
            self._pinged, self._ping = self._now, struct.pack("<d", self._now)
            self._protocol.send_ping(self._ping)
            self._flush()


def _words(fault: OSError) -> str:
    if isinstance(fault, ssl.SSLCertVerificationError):
        reason = fault.verify_message or "it cannot be checked"
        return f"the bridge's certificate is not trusted ({reason}): name its file in SSL_CERT_FILE"
    if fault.errno == errno.ECONNREFUSED:
        return "no program listens at its port: start the bridge, or give another port"
    return plain((fault.strerror or str(fault) or type(fault).__name__)[:_MOST_WORDS])
