"""Limits the number and rate of connections from each address to the gateway."""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Callable, Set

from hub.bucket import Bucket
from hub.ipc.roles import CONTROL
from hub.ipc.transport.fault_counter import FaultCounter
from hub.values import dataclass

AT_ONCE, PER_S = 300, 40.0
"""New connections of one address: in one burst after a rest, and each second."""
CONTROLS = 128
"""Most control connections of one address."""
EXTRA_CONNECTIONS = 8
"""Additional connections of an address to each other place."""
SILENT_S = 5.0
"""Time after which a control connection without a HELLO ends [s]."""
_MAX_ADDRESSES = 4096


@dataclass(slots=True)
class _Connection:
    address: str
    place: str
    since: float
    known: bool = False


class ConnectionRates:
    """The gateway's connections, by address."""

    def __init__(self, faults: FaultCounter, hang_up: Callable[[int], None]) -> None:
        """Start with none.

        Args:
            faults: Counts ended connections.
            hang_up: Ends the connection of a descriptor.
        """
        self._faults = faults
        self._hang_up = hang_up
        self._connections: dict[int, _Connection] = {}
        self._open: Counter[tuple[str, str]] = Counter()
        self._rates: OrderedDict[str, Bucket] = OrderedDict()

    def admit(self, descriptor: int, address: str, place: str, now: float) -> bool:
        """Whether a connection from `address` to `place` may stay; counts a refusal."""
        self.ended(descriptor)  # an earlier one with this descriptor ended unnoticed
        rate = self._rates.get(address)
        if rate is None:
            rate = self._rates[address] = Bucket(PER_S, AT_ONCE)
            if len(self._rates) > _MAX_ADDRESSES:
                self._rates.popitem(last=False)
        most = CONTROLS if place == CONTROL else self._open[address, CONTROL] + EXTRA_CONNECTIONS
        if not rate.take(1.0, now):
            self._count_fault(f"{address} connects more than {PER_S:.0f} times a second")
            return False
        if self._open[address, place] >= most:
            self._count_fault(f"{address} has {most} connections to {place}")
            return False
        self._connections[descriptor] = _Connection(address, place, now)
        self._open[address, place] += 1
        return True

    def ended(self, descriptor: int) -> None:
        """Forget a connection that has ended."""
        ended = self._connections.pop(descriptor, None)
        if ended is not None:
            self._open[ended.address, ended.place] -= 1
            if not self._open[ended.address, ended.place]:
                del self._open[ended.address, ended.place]

    def at(self, places: Set[str]) -> list[int]:
        """Descriptors of the connections to these places."""
        return [each for each, found in self._connections.items() if found.place in places]

    def end_silent(self, known: Callable[[int], bool], now: float) -> None:
        """End control connections without a HELLO; call it about once a second.

        Args:
            known: Whether a connected client has this descriptor.
            now: The time [s].
        """
        for descriptor, each in list(self._connections.items()):
            if each.place != CONTROL or each.known or now - each.since < SILENT_S:
                continue
            each.known = known(descriptor)
            if not each.known:
                self.ended(descriptor)
                self._count_fault(f"one of {each.address} says no HELLO")
                self._hang_up(descriptor)

    def _count_fault(self, why: str) -> None:
        self._faults.count("too many connections", f"at the gateway: {why}; it is ended")
