"""Ends connections of the gateway that send more bytes than their key may, within a message too.

ZeroMQ keeps the parts of a message until its last one came, and bounds neither their number nor
their sum. Accounts charge whole messages, so only the bytes that the system received show that one
grows without end.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hub.bucket import Bucket
from hub.ipc.broker.quotas import QUOTAS
from hub.ipc.roles import COMMANDS, CONTROL, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.file_descriptors import received
from hub.values import dataclass

_FRAMING: Final = 2.0
"""Bytes on the line for each byte of a control message: CURVE adds 33 to each part."""
_COMMANDS_PER_S, _COMMANDS_AT_ONCE = float(1 << 20), float(2 << 20)
"""Bytes of one connection that sends commands [B/s, B]."""


@dataclass(slots=True)
class _MeteredConnection:
    place: str
    allowance: Bucket
    role: Role | None = None
    seen: int = 0


class ReceivedBytes:
    """The connections of control messages and commands, with the bytes that came on each."""

    def __init__(self, faults: FaultCounter, hang_up: Callable[[int], None]) -> None:
        """Start with none.

        Args:
            faults: Counts ended connections.
            hang_up: Ends the connection of a descriptor.
        """
        self._faults = faults
        self._hang_up = hang_up
        self._senders: dict[int, _MeteredConnection] = {}

    def connected(self, descriptor: int, place: str) -> None:
        """Watch a new connection to a place; until its key is known it may do the least."""
        if place == CONTROL:
            self._senders[descriptor] = _MeteredConnection(place, _allowance(Role.OBSERVE))
        elif place == COMMANDS:
            self._senders[descriptor] = _MeteredConnection(
                place, Bucket(_COMMANDS_PER_S, _COMMANDS_AT_ONCE)
            )

    def identified(self, descriptor: int, role: Role) -> None:
        """Note the role of the key of a control connection."""
        sender = self._senders.get(descriptor)
        if sender is not None and sender.place == CONTROL and sender.role is not role:
            sender.role, sender.allowance = role, _allowance(role)

    def disconnected(self, descriptor: int) -> None:
        """Forget a connection that ended."""
        self._senders.pop(descriptor, None)

    def check(self, now: float) -> None:
        """End connections that sent too much; call it about ten times a second."""
        for descriptor, sender in list(self._senders.items()):
            total = received(descriptor)
            new, sender.seen = total - sender.seen, total
            if new > 0 and not sender.allowance.take(new, now):
                text = f"a connection to {sender.place} is ended after {total >> 10} KiB"
                self._faults.count("too many bytes", text)
                self.disconnected(descriptor)
                self._hang_up(descriptor)


def _allowance(role: Role) -> Bucket:
    quota = QUOTAS[role]
    return Bucket(_FRAMING * quota.bytes_per_s, _FRAMING * quota.bytes_at_once)
