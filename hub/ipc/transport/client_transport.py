"""What all sockets of one client share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.handshakes import Handshakes
from hub.ipc.transport.loop import Loop
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientTransport:
    """What all sockets of one client share.

    Attributes:
        context: Makes the sockets.
        loop: Serves them.
        faults: Counts what is dropped, by reason.
        handshakes: Those with the planes of central that are under way.
    """

    context: sockets.Context
    loop: Loop
    faults: FaultCounter
    handshakes: Handshakes = field(default_factory=Handshakes)

    @property
    def clock(self) -> Callable[[], float]:
        """Monotonic time [s]."""
        return self.loop.clock
