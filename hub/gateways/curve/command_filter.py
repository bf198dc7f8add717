"""Filters the commands from other machines: each frame is checked before the robot gets it.

ZeroMQ adds the role, name and fingerprint of its connection's key to every frame. So the filter
does not depend on the frame's own text. A command passes if that key may publish it, and if central
gave its number to a client with the same key.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import zmq

from hub.errors import FrameError, NotAllowedError
from hub.gateways.accounts import STOPS_PER_S, Accounts
from hub.ipc.broker.peers import Peer
from hub.ipc.broker.quotas import QUOTAS
from hub.ipc.definition import Plane
from hub.ipc.roles import Principal, parse_principal
from hub.ipc.security.publish_rights import demand_right, right
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames

_logger = logging.getLogger(__name__)

LONGEST = 1 << 16
"""Longest command from another machine [bytes]; a longer one ends its connection."""
QUEUE = 100
"""Most commands of one connection that wait for the filter."""
_LOG_STOP_S = 1.0


class CommandFilter:
    """Admits frames; used by the thread that carries them."""

    def __init__(
        self,
        peer_of: Callable[[int], Peer | None],
        holds: Callable[[Principal], bool],
        faults: FaultCounter,
        clock: Callable[[], float] = time.monotonic,
        *,
        accounts: Accounts,
    ) -> None:
        """Start to filter.

        Args:
            peer_of: The peer of a number at central; None: there is none.
            holds: Whether a key is still on the list.
            faults: Counts dropped frames.
            clock: Monotonic time [s].
            accounts: The accounts of the keys.
        """
        self._accounts = accounts
        self._peer_of = peer_of
        self._holds = holds
        self._faults = faults
        self._clock = clock
        self._next_word = 0.0

    def admit(self, raw: bytes, user_id: str) -> bytes | None:
        """The frame to pass on; None, and counted: it is dropped.

        Args:
            raw: A frame.
            user_id: Its sender by ZeroMQ, such as "operate:alice:FINGERPRINT".
        """
        try:
            principal = parse_principal(user_id)
            if not self._holds(principal):
                text = f"the key of {principal} was removed"
                raise NotAllowedError(text)
            needed = right(frames.name_of(raw), Plane.COMMAND.value)
            if needed.unordered:
                return self._stop(raw, principal)
            return self._command(raw, principal)
        except FrameError as error:
            self._faults.count("malformed command", f"from {user_id[:80]}: {error}")
        except NotAllowedError as error:
            self._faults.count("command not allowed", str(error))
        except Exception:  # a fault of the filter must not end the thread: no stop would pass
            self._faults.count("internal fault", "the gateway goes on after it")
            if self._faults.counts["internal fault"] == 1:
                _logger.exception("the first internal fault")
        return None

    def _command(self, raw: bytes, principal: Principal) -> bytes | None:
        frame = frames.unpack(raw)
        if frame.kind != frames.INLINE:
            text = f"a command {frame.name} is of kind {frame.kind}, which no command is"
            raise FrameError(text)
        sender = self._sender(frame.publisher, principal)
        if sender is None:
            text = f"{principal} sends {frame.name} under number {frame.publisher}, not its own"
            raise NotAllowedError(text)
        demand_right(principal, sender.name, frame.name, Plane.COMMAND.value)
        if not self._accounts.of(principal).may_command(self._clock()):
            self._too_many(principal)
            return None
        return raw

    def _too_many(self, principal: Principal) -> None:
        most = QUOTAS[principal.role].commands_per_s
        text = (
            f"the key {principal.name!r} may send {most:.0f} a second, and {STOPS_PER_S:.0f} stops"
        )
        self._faults.count("too many commands", text)

    def _stop(self, raw: bytes, principal: Principal) -> bytes | None:
        """Pass a stop, even with a wrong header, but not under the number of another sender."""
        now = self._clock()
        if not self._accounts.of(principal).may_stop(now):
            self._too_many(principal)
            return None  # one has just passed
        if now >= self._next_word:
            self._next_word = now + _LOG_STOP_S
            _logger.info("a stop comes from the holder of the key %s", principal)
        try:
            frame = frames.unpack(raw)
        except FrameError:
            frame = None
        if frame is None or frame.kind != frames.INLINE:
            # A receiver cannot read a bare name, and still stops.
            return frames.topic(frames.name_of(raw), frames.FAR)
        own = self._sender(frame.publisher, principal) is not None
        return frames.pack(
            frames.prefix(frame.name, frames.FAR),  # every receiver subscribes to this topic
            publisher=frame.publisher if own else 0,
            fingerprint=frame.fingerprint,
            sequence=frame.sequence,
            stamp_ns=frame.stamp_ns,
            payload=[frame.payload],
        )

    def _sender(self, publisher: int, principal: Principal) -> Peer | None:
        """The peer of this number, if it has this key."""
        peer = self._peer_of(publisher)
        return peer if peer is not None and peer.principal == principal else None


def user_id_of(frame: zmq.Frame) -> str:
    """The sender of a frame by ZeroMQ, such as "operate:alice:FINGERPRINT"; empty: unknown."""
    try:
        return str(frame.get("User-Id"))
    except zmq.ZMQError:
        return ""
