"""The newest value of one kind, while it is young enough; pure."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

from hub.robots.ros.line import RosMessage
from hub.ros.values import RosValue

Value = TypeVar("Value")


class Newest(Generic[Value]):
    """The newest message of a topic, converted."""

    def __init__(self, convert: Callable[[RosValue], Value], longest: float) -> None:
        """Wait for the first message.

        Args:
            convert: Makes the value of a message.
            longest: Age up to which it counts [s].
        """
        self._convert, self._longest = convert, longest
        self._value: Value | None = None
        self._measured = -math.inf

    def take(self, value: RosValue, message: RosMessage) -> None:
        """Take a newer message."""
        self._value, self._measured = self._convert(value), message.measured

    def value(self, now: float) -> Value | None:
        """The value; None: there is none, or it is too old at `now` [s, monotonic]."""
        return self._value if now - self._measured <= self._longest else None
