"""Requests for large data: the next only when the last answer has been shown.

On a long round trip, more are under way at once, as many as the wanted rate needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

from hub.errors import CodecError, HubError, NoHandlerError, QueryTimeoutError
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from rune_tui.link.pace import Pace

RETRY_S = 0.25
"""Pause after a request that failed [s]."""
_LATE_S = 0.02
"""Largest delay of a turn that does not lower the rate [s]."""

Q = TypeVar("Q")
A = TypeVar("A")


class Requester(Generic[Q, A]):
    """Asks for one kind of data, again and again; used by the link's thread alone.

    Attributes:
        pace: How often is asked.
        shown: Number of the newest answer that is on the screen; another thread may set it.
        round_trip: Delay of the newest answer [s]; NaN before the first.
    """

    def __init__(
        self,
        client: Client,
        request: MessageDefinition[Q],
        response: MessageDefinition[A],
        *,
        ask: Callable[[], Q | None],
        take: Callable[[A, MessageInfo], int],
        fail: Callable[[str], None],
        clock: Callable[[], float],
        busy: Callable[[Q, float], None] = lambda _, __: None,
        refused: Callable[[Q, HubError], None] = lambda _, __: None,
    ) -> None:
        """Prepare; nothing is asked yet.

        Args:
            client: The client that asks.
            request: Message of the request.
            response: Message of the answer.
            ask: The next request; None: none.
            take: Gets the answer, and returns its number for `shown`.
            fail: Gets in words why there is none; empty when there is one.
            clock: Monotonic time [s].
            busy: Gets for each answer its request, and the time of robot and link [s].
            refused: Gets the request, and the reason for a missing or wrong answer.
        """
        self._client = client
        self._request = request
        self._response = response
        self._ask = ask
        self._take = take
        self._fail = fail
        self._clock = clock
        self._busy = busy
        self._refused = refused
        self.pace = Pace()
        self.shown = 0
        self.round_trip = math.nan
        self._asked = self._newest = 0
        self._open: dict[int, float] = {}
        """Open requests in order, and the numbers of their answers, if any."""
        self._due = 0.0

    def follow(self, interval: float) -> None:
        """Ask no more often than every `interval` [s]; a shorter one holds at once."""
        before = self.pace.spacing
        self.pace.interval = interval
        self._due += self.pace.spacing - before

    @property
    def handled(self) -> bool:
        """Whether enough requests are over: answered and shown, or failed.

        An answer that is shown ends all requests before it, because the newest counts.
        """
        seen = [request for request, number in self._open.items() if number <= self.shown]
        for request in [each for each in self._open if seen and each <= seen[-1]]:
            del self._open[request]
        return len(self._open) < self.pace.window

    def step(self) -> None:
        """Ask if it is time to."""
        now = self._clock()
        if now < self._due or not self.handled or not self._client.connected:
            return
        wanted = self._ask()
        if wanted is None:
            return
        self._asked += 1
        number = self._asked
        self._open[number] = math.inf
        # Counted on from when it was due, so that irregular calls do not lower the rate.
        self._due = max(self._due, now - _LATE_S) + self.pace.spacing
        self._client.query_notify(
            self._request,
            wanted,
            self._response,
            timeout=self.pace.timeout,
            answered=lambda value, how: self._answered(number, wanted, now, value, how),
            failed=lambda error: self._failed(number, wanted, error),
        )

    def _answered(self, number: int, asked: Q, when: float, value: A, how: MessageInfo) -> None:
        now = self._clock()
        self.round_trip = now - when
        service, waited = self.pace.answered(when, now, self._client.round_trip)
        self._due += waited  # the queue of the link drains meanwhile
        if number < self._newest:
            self._open.pop(number, None)
            return
        self._newest = number
        try:
            taken = self._take(value, how)
        except CodecError as error:
            self._failed(number, asked, error)
            return
        if number in self._open:
            self._open[number] = taken
        self._fail("")
        self._busy(asked, service)

    def _failed(self, number: int, asked: Q, error: HubError) -> None:
        self._open.pop(number, None)
        self._due = max(self._due, self._clock() + RETRY_S)
        if isinstance(error, QueryTimeoutError) and not self._open:
            self.pace.timed_out()
        self._refused(asked, error)
        no_answer = isinstance(error, NoHandlerError)
        self._fail("nobody answers" if no_answer else str(error))
