"""A client's queries under way: each ends exactly once, with an answer or an error."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import hub.errors
from hub.errors import (
    CodecError,
    FrameError,
    HandlerDiedError,
    HandlerFailedError,
    NoHandlerError,
    QueryError,
    QueryTimeoutError,
)
from hub.ipc.message_info import MessageInfo
from hub.ipc.node.connection import Connection
from hub.ipc.node.direct_queries import DirectRequester
from hub.ipc.wire import control, frames
from hub.values import dataclass


@dataclass(slots=True, kw_only=True)
class PendingQuery:
    """A query under way.

    Attributes:
        name: Message name of the query.
        read: Turns the answer's frame into the argument of `answered`.
        timeout: Longest time for the answer [s].
        deadline: End of that time [s].
        answered: Called with the answer.
        failed: Called with the error.
        unsent: Whether it could not be sent.
        frame: The message of a query that was sent directly.
        requester: Its direct connection; None: it went through central.
        sent_again: Whether it was sent again through central, after that connection ended.
    """

    name: str
    read: Callable[[frames.Frame], Any]
    timeout: float
    deadline: float
    answered: Callable[[Any, MessageInfo], None]
    failed: Callable[[QueryError], None]
    unsent: bool = False
    frame: bytes | None = None
    requester: DirectRequester | None = None
    sent_again: bool = False


class PendingQueries:
    """All queries under way of one client, by number."""

    def __init__(self, connection: Connection, clock: Callable[[], float]) -> None:
        self._connection = connection
        self._clock = clock
        self._waiting: dict[int, PendingQuery] = {}
        self._last = 0
        self._requesters: dict[str, DirectRequester] = {}
        # No query times out before this [s], so most turns need not check every query.
        self._earliest = math.inf

    def ask(self, pending: PendingQuery, frame: bytes | None) -> None:
        """Ask with a message's frame, or without one for the last value of the message.

        It never waits for a lost central: it fails at the next `expire`.
        """
        self._last = number = self._last % 0xFFFF_FFFF + 1
        self._waiting[number] = pending
        if pending.deadline < self._earliest:
            self._earliest = pending.deadline
        if frame is None:
            last = control.Last(number=number, name=pending.name, timeout_s=pending.timeout)
            self._ask_central(pending, last, None)
            return
        query = control.Query(number=number, name=pending.name, timeout_s=pending.timeout)
        requester = self._requesters.get(pending.name)
        if requester is not None and requester.ask(query, frame):
            pending.requester, pending.frame = requester, frame
        else:
            self._ask_central(pending, query, frame)

    def ask_and_wait(
        self, name: str, frame: bytes | None, timeout: float, listen: Callable[[float], None]
    ) -> frames.Frame:
        """Ask, and `listen` until the answer arrives.

        Raises:
            QueryError: No handler, it died or failed, or the time ran out.
        """
        answers: list[frames.Frame] = []
        failures: list[QueryError] = []
        self._ask_for_frame(name, frame, timeout, answers.append, failures.append)
        while not answers and not failures:
            listen(0.1)
        if failures:
            raise failures[0]
        return answers[0]

    def ask_last(self, name: str, timeout: float, answered: Callable[[frames.Frame], None]) -> None:
        """Ask for the last value of a message; without one, `answered` is not called."""

        def came(frame: frames.Frame) -> None:
            if frame.name == name:
                answered(frame)

        self._ask_for_frame(name, None, timeout, came, lambda _: None)

    def _ask_for_frame(
        self,
        name: str,
        frame: bytes | None,
        timeout: float,
        answered: Callable[[frames.Frame], None],
        failed: Callable[[QueryError], None],
    ) -> None:
        """Ask, and pass on the answer's frame."""
        pending = PendingQuery(
            name=name,
            read=lambda answer: answer,
            timeout=timeout,
            deadline=self._clock() + timeout,
            answered=lambda answer, _: answered(answer),
            failed=failed,
        )
        self.ask(pending, frame)

    def _ask_central(
        self, pending: PendingQuery, message: control.Query | control.Last, frame: bytes | None
    ) -> None:
        if not self._connection.publisher or not self._connection.send(message, frame):
            pending.unsent, pending.deadline = True, -math.inf
            self._earliest = -math.inf

    def use_requester(self, name: str, requester: DirectRequester | None) -> DirectRequester | None:
        """Send queries of this name by `requester` from now on; None: through central.

        Returns:
            The requester before that, if it was another one.
        """
        if requester is not None and self._requesters.get(name) is requester:
            return None
        before = self._requesters.pop(name, None)
        if before is not None:
            before.names.discard(name)
            self._send_again(before, name)
        if requester is not None:
            self._requesters[name] = requester
            requester.names.add(name)
        return before

    def requesters(self) -> set[DirectRequester]:
        """All direct connections in use."""
        return set(self._requesters.values())

    def _send_again(self, requester: DirectRequester, name: str) -> None:
        """Send through central what `requester` had sent."""
        now = self._clock()
        for number, pending in self._waiting.items():
            if pending.requester is requester and pending.name == name:
                pending.requester, pending.sent_again = None, True
                query = control.Query(
                    number=number, name=name, timeout_s=max(pending.deadline - now, 1e-3)
                )
                self._ask_central(pending, query, pending.frame)

    def due(self, otherwise: float) -> float:
        """Time at which the next query times out [s], at most `otherwise`."""
        return min(otherwise, self._earliest)

    def expire(self, now: float, endpoint: str) -> None:
        """Fail the queries that timed out by `now` [s]."""
        if now <= self._earliest:
            return
        overdue = [(each.deadline, n) for n, each in self._waiting.items() if each.deadline < now]
        for _, number in sorted(overdue):
            pending = self._waiting.pop(number, None)
            if pending is None:
                continue  # the callback of another query listened, and so ended this one
            if pending.unsent:
                text = f"the query {pending.name} was not sent: no hub answers at {endpoint}"
                pending.failed(QueryError(text))
            else:
                text = f"no answer to the query {pending.name} in {pending.timeout:g} s"
                pending.failed(QueryTimeoutError(text))
        self._earliest = min((each.deadline for each in self._waiting.values()), default=math.inf)

    def end_all(self, why: str) -> None:
        """Fail all queries, after the loss of central."""
        for number in list(self._waiting):
            pending = self._waiting.pop(number, None)
            if pending is not None:
                text = f"the query {pending.name} ended without an answer: {why}"
                pending.failed(QueryError(text))

    def conclude(
        self,
        message: control.Response | control.Failure,
        attached: bytes | None,
        received: Callable[[frames.Frame], MessageInfo],
    ) -> bool:
        """Conclude a query by its answer or error; False: no query waits for it."""
        pending = self._waiting.pop(message.number, None)
        if pending is None:
            return False
        if not self._waiting:
            self._earliest = math.inf
        if isinstance(message, control.Failure) or attached is None:
            text = message.text if isinstance(message, control.Failure) else "an empty answer"
            kind = getattr(hub.errors, getattr(message, "error", ""), HandlerFailedError)
            if pending.sent_again and kind is NoHandlerError:
                kind = HandlerDiedError  # it was connected when the query was sent
            valid = isinstance(kind, type) and issubclass(kind, QueryError)
            pending.failed(kind(text) if valid else HandlerFailedError(text))
            return True
        try:
            frame = frames.unpack(attached)
            value = pending.read(frame)
        except (FrameError, CodecError) as error:
            pending.failed(HandlerFailedError(str(error)))
            return True
        pending.answered(value, received(frame))
        return True
