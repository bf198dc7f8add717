"""A program with panels, as the thread of the door's server has it."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

_BACKLOG: Final = 64
"""Messages that wait for a slow program; the oldest is dropped."""
_MOST_TEXTS: Final = 2000
"""Texts that wait for a program; one that reads none of them is disconnected."""


class Viewer:
    """Sends to one program, and keeps what it subscribed to.

    Attributes:
        number: Names it.
    """

    def __init__(self, number: int, connection: ServerConnection) -> None:
        self.number = number
        self._connection = connection
        self._by_channel: dict[int, int] = {}
        self._channel_of: dict[int, int] = {}
        self._texts: deque[str] = deque()
        self._messages: deque[bytes] = deque(maxlen=_BACKLOG)
        self._waits = asyncio.Event()

    def subscribe(self, subscription: int, channel: int) -> bool:
        """Subscribe to a channel; returns False if it does already."""
        if subscription in self._channel_of or channel in self._by_channel:
            return False
        self._by_channel[channel] = subscription
        self._channel_of[subscription] = channel
        return True

    def unsubscribe(self, subscription: int) -> int | None:
        """End a subscription; returns its channel, None: there was none."""
        channel = self._channel_of.pop(subscription, None)
        if channel is not None:
            del self._by_channel[channel]
        return channel

    def drop(self, channel: int) -> bool:
        """End the subscription to a channel that is gone; returns False if there was none."""
        subscription = self._by_channel.pop(channel, None)
        if subscription is not None:
            del self._channel_of[subscription]
        return subscription is not None

    def subscription_to(self, channel: int) -> int | None:
        """The number of its subscription to a channel; None: there is none."""
        return self._by_channel.get(channel)

    def say(self, text: str) -> None:
        """Send a text before all messages."""
        if len(self._texts) >= _MOST_TEXTS:
            self._connection.transport.abort()
            return
        self._texts.append(text)
        self._waits.set()

    def give(self, message: bytes) -> None:
        """Send a message, or drop the oldest that waits."""
        self._messages.append(message)
        self._waits.set()

    async def write(self) -> None:
        """Send what waits, until the connection ends."""
        while True:
            await self._waits.wait()
            self._waits.clear()
            while self._texts or self._messages:
                waiting: deque[str] | deque[bytes] = self._texts or self._messages
                await self._connection.send(waiting.popleft())
