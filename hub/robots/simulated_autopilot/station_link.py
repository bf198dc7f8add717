"""One link of a simulated autopilot: its streams, its signing, what waits to be sent; pure."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from typing import Final

from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from hub.robots.mavlink.wire.signing import Signer

COMPONENT: Final = 1
_PARAMETERS_AT_ONCE: Final = 20


class StationLink:
    """The link to one ground station, or to a network of them.

    Attributes:
        rates: Time between two messages [s], by name; inf: none.
        parameters: Names of parameters that wait to be sent, with their index.
    """

    def __init__(
        self, send: Callable[[bytes], None], number: int, *, datagrams: bool = False
    ) -> None:
        """Take the link.

        Args:
            send: Sends a frame, without waiting.
            number: Of the link; number 0 always takes frames without a signature.
            datagrams: Whether each piece of data is a datagram.
        """
        self._send = send
        self.number = number
        self._datagrams = datagrams
        self._packer, self._parser = FramePacker(1, COMPONENT), FrameParser()
        self.rates: dict[str, float] = {}
        self._due: dict[str, float] = {}
        self.parameters: deque[tuple[str, int]] = deque()

    def begin(self, system: int, signer: Signer | None, rates: dict[str, float]) -> None:
        """Begin after a start of the vehicle: nothing that was asked for counts.

        Args:
            system: The vehicle's number.
            signer: Signs the frames, and checks those that come; None: there is no key.
            rates: The messages that it sends by itself [Hz].
        """
        self._packer = FramePacker(system, COMPONENT, signer)
        self._parser = FrameParser(signer if self.number else None)
        self.rates = {name: 1.0 / rate for name, rate in rates.items()}
        self._due = {}
        self.parameters.clear()

    def frames(self, data: bytes) -> list[MavlinkFrame]:
        """The frames in these bytes."""
        return self._parser.datagram(data) if self._datagrams else self._parser.feed(data)

    def send(self, name: str, /, **fields: object) -> None:
        """Send a message."""
        self._send(self._packer.pack(name, **fields))

    def set_rate(self, name: str, every: float) -> None:
        """Send a message so often [s]; inf: never."""
        self.rates[name] = every
        self._due.pop(name, None)

    def due(self, now: float) -> Iterator[str]:
        """The messages that are due."""
        for name, every in list(self.rates.items()):
            due = self._due.get(name, now)
            if now >= due and every < math.inf:
                self._due[name] = due + every if due + every > now else now + every
                yield name

    def parameters_due(self) -> Iterator[tuple[str, int]]:
        """The parameters to send now."""
        for _ in range(min(len(self.parameters), _PARAMETERS_AT_ONCE)):
            yield self.parameters.popleft()
