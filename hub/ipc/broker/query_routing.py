"""Queries under way through central: their handlers, their successors, and their ends."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace

from hub.ipc.broker.peers import Outgoing, Peer
from hub.ipc.broker.query_shares import QueryShares
from hub.ipc.formats.codegen import Buffer
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control
from hub.values import dataclass

_logger = logging.getLogger(__name__)

MAX_QUERIES = 4096
MAX_QUERY_S = 60.0
_MAX_KEPT = 16 << 10
"""Longest query that another handler can take over; central keeps no longer one [bytes]."""

Asked = control.Query | control.Last
Answer = control.Response | control.Failure


@dataclass(frozen=True, slots=True, kw_only=True)
class _Route:
    """A query under way.

    Attributes:
        asker: The peer that waits for the answer.
        number: The asker's number of the query.
        handler: The peer that answers.
        query: The query, under central's number.
        attached: The query's message; None: it has none, or is too long to ask again.
        deadline: When the asker stops waiting [s].
    """

    asker: Peer
    number: int
    handler: Peer
    query: Asked
    attached: bytes | None
    deadline: float


class QueryRouting:
    """All queries under way."""

    def __init__(self, candidates: Callable[[Asked], Iterable[Peer]], faults: FaultCounter) -> None:
        """Start with none.

        Args:
            candidates: The peers that could answer, in the order of their start.
            faults: Counts late answers.
        """
        self._candidates = candidates
        self._faults = faults
        self._routes: dict[int, _Route] = {}
        self._busy: Counter[Peer] = Counter()
        self._late: dict[Peer, set[int]] = {}
        self._shares = QueryShares()
        self.last = 0

    def ask(self, asker: Peer, query: Asked, attached: Buffer | None, now: float) -> list[Outgoing]:
        """Send a query to the handler with the fewest under way.

        A query that timed out stays in the handler's load until it answers in time again. No other
        handler gets it meanwhile: two would work on it.
        """
        if len(self._routes) >= MAX_QUERIES:
            text = f"{MAX_QUERIES} queries are under way, {query.name[:80]} is one too many"
            return [_failure(asker, query.number, "NoHandlerError", text)]
        handler = self._choose(query)
        if handler is None:
            return [_failure(asker, query.number, *_no_handler(query))]
        refusal = self._shares.refusal(asker, handler, now)
        if refusal:
            self._faults.count("query over quota", f"{asker.name}: {refusal}")
            text = f"{refusal}; {query.name[:80]} is not asked, try again later"
            return [_failure(asker, query.number, "HandlerFailedError", text)]
        self.last = self.last % 0xFFFF_FFFF + 1
        wait = query.timeout_s if 0.0 < query.timeout_s < MAX_QUERY_S else MAX_QUERY_S
        keep = attached is not None and len(attached) <= _MAX_KEPT
        route = _Route(
            asker=asker,
            number=query.number,
            handler=handler,
            query=type(query)(number=self.last, name=query.name, timeout_s=query.timeout_s),
            attached=bytes(attached) if keep and attached is not None else None,
            deadline=now + wait,
        )
        return [self._send(route, attached)]

    def answer(self, handler: Peer, answer: Answer, attached: Buffer | None) -> list[Outgoing]:
        """Forward an answer to the asker."""
        route = self._routes.get(answer.number)
        if route is None or route.handler is not handler:
            self._late.get(handler, set()).discard(answer.number)
            self._faults.count("late answer", f"from {handler.name}, no peer waits for it")
            return []
        self._end(route)
        self._late.pop(handler, None)
        handed_on = replace(answer, number=route.number)
        return [Outgoing(identity=route.asker.identity, message=handed_on, attached=attached)]

    def expire(self, now: float) -> None:
        """Forget the queries that timed out; the askers keep their own time."""
        for route in [route for route in self._routes.values() if route.deadline < now]:
            self._end(route)
            detail = f"{route.handler.name} let {route.query.name} run out"
            self._faults.count("unanswered query", detail)
            late = self._late.setdefault(route.handler, set())
            if len(late) < MAX_QUERIES:
                late.add(route.query.number)

    def drop(self, peer: Peer, now: float) -> list[Outgoing]:
        """Hand the queries of a peer that is gone to another handler, or fail them at once."""
        outgoing = []
        for route in list(self._routes.values()):
            if route.asker is peer:
                self._end(route)
            elif route.handler is peer:
                self._end(route)
                outgoing.append(self._take_over(route, now))
        del self._busy[peer]
        self._late.pop(peer, None)
        self._shares.drop(peer)
        return outgoing

    def _take_over(self, route: _Route, now: float) -> Outgoing:
        again = isinstance(route.query, control.Last) or route.attached is not None
        successor = self._choose(route.query) if again and now < route.deadline else None
        if successor is None:
            text = f"{route.handler.name} went away before it answered {route.query.name}"
            return _failure(route.asker, route.number, "HandlerDiedError", text)
        _logger.info("%s answers %s now", successor.name, route.query.name)
        left = replace(route.query, timeout_s=route.deadline - now)
        return self._send(replace(route, handler=successor, query=left), route.attached)

    def _choose(self, query: Asked) -> Peer | None:
        def load(peer: Peer) -> int:
            return self._busy[peer] + len(self._late.get(peer, ()))

        return min(self._candidates(query), key=load, default=None)

    def _send(self, route: _Route, attached: Buffer | None) -> Outgoing:
        self._routes[route.query.number] = route
        self._busy[route.handler] += 1
        self._shares.begin(route.asker, route.handler)
        _logger.debug(
            "query %s {%d}: %s --> %s",
            route.query.name,
            route.query.number,
            route.asker.name,
            route.handler.name,
        )
        return Outgoing(identity=route.handler.identity, message=route.query, attached=attached)

    def _end(self, route: _Route) -> None:
        del self._routes[route.query.number]
        self._busy[route.handler] -= 1
        self._shares.end(route.asker, route.handler)


def _no_handler(query: Asked) -> tuple[str, str]:
    """Error class and sentence for a query that no peer can answer."""
    if isinstance(query, control.Last):
        return "NoValueError", f"no connected module publishes {query.name[:80]}"
    return "NoHandlerError", f"no connected module answers queries of {query.name[:80]}"


def _failure(asker: Peer, number: int, error: str, text: str) -> Outgoing:
    failure = control.Failure(number=number, error=error, text=text)
    return Outgoing(identity=asker.identity, message=failure)
