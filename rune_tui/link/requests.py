"""Requests for large data: one in flight, the next only when the last answer has been shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from hub.errors import CodecError, HubError, NoHandlerError, QueryError
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.reception import Reception

TIMEOUT_S = 1.0
"""An answer that takes longer does not come [s]."""
RETRY_S = 0.25
"""Pause after a request that failed [s]."""

Q = TypeVar("Q")
A = TypeVar("A")


class Requester(Generic[Q, A]):
    """Asks for one kind of data, again and again; used by the link's thread alone.

    Attributes:
        interval: Shortest time between two requests [s].
        shown: Number of the newest answer that is on the screen; another thread may set it.
    """

    def __init__(
        self,
        client: Client,
        request: MessageDefinition[Q],
        response: MessageDefinition[A],
        *,
        ask: Callable[[], Q | None],
        take: Callable[[A, Reception], int],
        fail: Callable[[str], None],
        clock: Callable[[], float],
    ) -> None:
        """Prepare; nothing is asked yet.

        Args:
            client: Who asks.
            request: What is sent.
            response: What comes back.
            ask: What to ask for now; None for nothing.
            take: Gets the answer, and returns its number for `shown`.
            fail: Gets in words why there is none; empty when there is one.
            clock: Monotonic time [s].
        """
        self._client = client
        self._request = request
        self._response = response
        self._ask = ask
        self._take = take
        self._fail = fail
        self._clock = clock
        self.interval = 0.0
        self.shown = 0
        self._taken = 0
        self._in_flight = False
        self._due = 0.0
        self._asked = 0.0
        self.round_trip = float("nan")

    @property
    def handled(self) -> bool:
        """Whether the last request is over: answered and shown, or failed."""
        return not self._in_flight and self.shown >= self._taken

    def look(self) -> None:
        """Ask if it is time to."""
        now = self._clock()
        if not self.handled or now < self._due or not self._client.connected:
            return
        wanted = self._ask()
        if wanted is None:
            return
        self._in_flight = True
        self._asked = now
        # Counted on from when it was due, so that looking now and then does not lower the rate.
        self._due = max(now, self._due + self.interval)
        self._client.query_notify(
            self._request,
            wanted,
            self._response,
            timeout=TIMEOUT_S,
            answered=self._answered,
            failed=self._failed,
        )

    def _answered(self, value: A, reception: Reception) -> None:
        self._in_flight = False
        self.round_trip = self._clock() - self._asked
        try:
            self._taken = self._take(value, reception)
        except CodecError as error:
            self._failed(error)
        else:
            self._fail("")

    def _failed(self, error: QueryError | HubError) -> None:
        self._in_flight = False
        self._due = max(self._due, self._clock() + RETRY_S)
        nobody = isinstance(error, NoHandlerError)
        self._fail("nobody answers" if nobody else str(error))
