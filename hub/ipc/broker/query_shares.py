"""Limits on the queries under way: of each key, of each role, and at each handler."""

from __future__ import annotations

from collections import Counter

from hub.bucket import Bucket
from hub.ipc.broker.peers import Peer
from hub.ipc.broker.quotas import QUOTAS, counts_with, quota_of
from hub.ipc.roles import Principal, Role


class QueryShares:
    """Counts queries under way that came with keys; clients of this machine have no limit."""

    def __init__(self) -> None:
        self._of_key: Counter[Principal] = Counter()
        self._at_handler: Counter[tuple[Peer, Role]] = Counter()
        self._rates: dict[tuple[Peer, Role], Bucket] = {}

    def refusal(self, asker: Peer, handler: Peer, now: float) -> str:
        """Why `asker` may not ask `handler` now; empty: it may, and the query counts."""
        principal, quota = asker.principal, quota_of(asker.principal)
        if quota is None:
            return ""
        role = principal.role
        keys = f"keys to {role.value}"
        if self._of_key[principal] >= quota.queries:
            return f"the key {principal.name!r} has {quota.queries} queries under way, its limit"
        if self._together(role) >= quota.queries_together:
            return f"{keys} have {quota.queries_together} queries under way, their limit"
        if self._at_handler[handler, role] >= quota.at_one_handler:
            return f"{keys} have {quota.at_one_handler} queries under way at {handler.name}"
        rate = self._rates.get((handler, role))
        if rate is None:
            rate = Bucket(quota.to_one_handler_per_s, quota.to_one_handler_per_s)
            self._rates[handler, role] = rate
        if not rate.take(1.0, now):
            most = quota.to_one_handler_per_s
            return f"{keys} ask {handler.name} more than {most:.0f} times a second"
        return ""

    def begin(self, asker: Peer, handler: Peer) -> None:
        """Count a query."""
        self._count(asker, handler, 1)

    def end(self, asker: Peer, handler: Peer) -> None:
        """Count the end of a query."""
        self._count(asker, handler, -1)

    def drop(self, handler: Peer) -> None:
        """Forget a handler that is gone."""
        for role in QUOTAS:
            self._rates.pop((handler, role), None)

    def _together(self, role: Role) -> int:
        """Queries of this role and of those below it."""
        return sum(
            count for principal, count in self._of_key.items() if counts_with(principal, role)
        )

    def _count(self, asker: Peer, handler: Peer, change: int) -> None:
        if quota_of(asker.principal) is None:
            return
        self._of_key[asker.principal] += change
        if not self._of_key[asker.principal]:
            del self._of_key[asker.principal]
        place = handler, asker.principal.role
        self._at_handler[place] += change
        if not self._at_handler[place]:
            del self._at_handler[place]
