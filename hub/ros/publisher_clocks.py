"""Ages of messages by the clocks of their publishers, which need not be set; pure."""

from __future__ import annotations

from typing import Final

from hub.ros.clock_delay import ClockDelay
from hub.ros.rmw_zenoh import MessageOrigin

MOST_CLOCKS: Final = 256
"""Most publishers that are kept apart."""


class PublisherClocks:
    """The least difference between arrival and stamp, by publisher."""

    def __init__(self) -> None:
        self._clocks: dict[bytes, ClockDelay] = {}

    def age(self, origin: MessageOrigin, arrived: float) -> float:
        """How much longer than the fastest a message was on its way [s].

        Args:
            origin: What is attached to it.
            arrived: When it came [s, monotonic].
        """
        found = self._clocks.get(origin.gid)
        if found is None:
            if len(self._clocks) >= MOST_CLOCKS:
                self._clocks.pop(next(iter(self._clocks)))
            found = self._clocks[origin.gid] = ClockDelay()
        return found.of(origin.stamp_ns, int(arrived * 1e9), arrived)
