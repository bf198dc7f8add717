"""Reads frames for the subscriptions of a client: header, payload or shared memory, value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hub.errors import CodecError, FrameError, RangeError
from hub.ipc.node.subscription import ReceivedFrame, Subscription
from hub.ipc.transport import shared_ring
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import frames


class FrameReader:
    """Reads frames, and counts those that cannot be read."""

    def __init__(self, faults: FaultCounter, no_ring: Callable[[Subscription, str], None]) -> None:
        """Begin.

        Args:
            faults: Counts wrong frames.
            no_ring: Called with the reason if shared memory has no payload.
        """
        self._faults = faults
        self._no_ring = no_ring
        self.rings = shared_ring.Readers()

    def close(self) -> None:
        """Close all shared memory."""
        self.rings.close()

    def read(self, subscription: Subscription, raw: bytes) -> ReceivedFrame | None:
        """The messages in a frame; None, and counted: it is malformed and has no replacement."""
        try:
            return subscription.read(raw)
        except FrameError as error:
            self._faults.count("malformed frame", str(error))
        except CodecError as error:
            self._faults.count("wrong format", str(error))
        return subscription.unreadable()

    def check(self, raw: bytes) -> None:
        """Count a frame without a subscription if it is malformed."""
        try:
            frames.unpack(raw)
        except FrameError as error:
            self._faults.count("malformed frame", str(error))

    def split(self, bundle: bytes) -> list[bytes]:
        """The frames of a bundle; none, and counted: it is damaged."""
        try:
            return frames.split_bundle(bundle)
        except FrameError as error:
            self._faults.count("malformed frame", str(error))
            return []

    def places(self, raw: bytes, start: int, end: int) -> list[int]:
        """Begin and end of each frame of a bundle; none, and counted: it is damaged."""
        try:
            return frames.bundle_places(raw, start, end)
        except FrameError as error:
            self._faults.count("malformed frame", str(error))
            return []

    def decoded(self, subscription: Subscription, kind: int, message: Any) -> Any:
        """The value of a message, or its payload; None if that is gone or cannot be read."""

        def note(text: str) -> None:
            subscription.unfit = subscription.unfit or text
            self._faults.count("value changed", text)

        try:
            if message.__class__ is tuple and subscription.receive is not None:
                return subscription.receive(message, note)
            payload = self._payload(subscription, kind, message)
            if payload is None or subscription.raw:
                return payload
            return subscription.definition.decode(payload, note)
        except RangeError as error:
            subscription.refused += 1
            subscription.unfit = subscription.unfit or str(error)
            self._faults.count("out of range", str(error))
            return None
        except (CodecError, FrameError) as error:
            self._faults.count("wrong format", str(error))
            return None

    def _payload(
        self, subscription: Subscription, kind: int, payload: memoryview
    ) -> memoryview | None:
        """The payload itself; None: it is gone."""
        if kind == frames.INLINE:
            return payload
        if kind == frames.NO_RING:
            self._no_ring(subscription, "its publisher has none")
            return None
        try:
            found = self.rings.read(payload)
        except OSError as error:
            self._no_ring(subscription, str(error))
            return None
        if found is None:
            subscription.lost += 1
            self._faults.count("overwritten", f"{subscription.definition.name}: read too late")
        return found
