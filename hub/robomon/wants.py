"""Wanted capabilities: leases that end unless they are renewed; pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable

from hub.gcm.supervision import LEASE_S
from hub.values import dataclass

MAX_HOLDERS = 256
MAX_CAPABILITIES = 64
MAX_NAME = 64
MAX_LEASE_S = 10_800.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Lease:
    name: str
    capabilities: frozenset[str]
    until: float


class Wants:
    """The leases of all holders; every method gets the time [s].

    Attributes:
        refused: Number of refused wants: too many holders, no capability, or a wrong length.
    """

    def __init__(self) -> None:
        self._leases: dict[int, _Lease] = {}
        self._wanted: dict[str, list[str]] | None = None
        self.refused = 0

    def renew(
        self,
        holder: int,
        name: str,
        capabilities: Iterable[str],
        now: float,
        *,
        lease_s: float = LEASE_S,
    ) -> None:
        """Set all wants of a holder, by its number at central; an empty set ends them."""
        wanted = frozenset(capabilities)
        usable = all(each.isidentifier() and len(each) <= MAX_NAME for each in wanted)
        full = len(self._leases) >= MAX_HOLDERS and holder not in self._leases
        in_limit = 0.0 < lease_s <= MAX_LEASE_S
        if not (usable and in_limit) or len(wanted) > MAX_CAPABILITIES or full:
            self.refused += 1
        elif wanted:
            shown = "".join(name.split())[:MAX_NAME] or "somebody"
            before = self._leases.get(holder)
            if before is None or (before.name, before.capabilities) != (shown, wanted):
                self._wanted = None
            self._leases[holder] = _Lease(name=shown, capabilities=wanted, until=now + lease_s)
        elif self._leases.pop(holder, None):
            self._wanted = None

    def disconnected(self, name: str) -> None:
        """Remove the wants of a client that has left."""
        self._keep(lambda lease: lease.name != name)

    def current(self, now: float) -> dict[str, list[str]]:
        """The wanted capabilities with the names of their holders."""
        self._keep(lambda lease: now < lease.until)
        if self._wanted is None:
            wanted: defaultdict[str, list[str]] = defaultdict(list)
            for lease in self._leases.values():
                for capability in sorted(lease.capabilities):
                    wanted[capability].append(lease.name)
            self._wanted = dict(wanted)
        return self._wanted

    def _keep(self, which: Callable[[_Lease], bool]) -> None:
        left = {holder: lease for holder, lease in self._leases.items() if which(lease)}
        if len(left) < len(self._leases):
            self._leases, self._wanted = left, None
