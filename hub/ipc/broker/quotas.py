"""How much of central each role may use, and what the holders of keys have used of it.

All connections with one key share what the key has. Clients of this machine have no key and no
quota: they run the robot. Pure: the time comes with each call.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from hub.bucket import Bucket
from hub.ipc.roles import LOCAL, Principal, Role
from hub.ipc.wire import control


@dataclass(frozen=True, slots=True, kw_only=True)
class Quota:
    """What a role may use. Where a limit is "together", it counts the roles below as well.

    Attributes:
        connections: Connected clients of one key.
        connections_together: Connected clients with keys of this role.
        definitions: New messages that the clients of one key define.
        names: Messages that one client publishes, subscribes to or answers, each.
        queries: Queries under way of one key.
        queries_together: Queries under way of this role.
        at_one_handler: Queries under way of this role at one handler.
        to_one_handler_per_s: Queries of this role to one handler [1/s].
        requests_per_s: Control messages of one key, by their prices [1/s].
        requests_at_once: The same, in one burst after a rest.
        bytes_per_s: Bytes of control messages of one key [B/s].
        bytes_at_once: The same, in one burst after a rest [B].
        commands_per_s: Commands of one key that are broadcast, stops not among them [1/s].
        handshakes_per_s: New connections of one key to one place [1/s].
        handshakes_at_once: The same, in one burst after a rest.
    """

    connections: int
    connections_together: int
    definitions: int
    names: int
    queries: int
    queries_together: int
    at_one_handler: int
    to_one_handler_per_s: float
    requests_per_s: float
    requests_at_once: float
    bytes_per_s: float
    bytes_at_once: float
    commands_per_s: float
    handshakes_per_s: float = 1.0
    handshakes_at_once: float = 40.0


_OPERATE = Quota(
    connections=16,
    connections_together=256,
    definitions=0,
    names=256,
    queries=128,
    queries_together=1536,
    at_one_handler=64,
    to_one_handler_per_s=400.0,
    requests_per_s=400.0,
    requests_at_once=12_000.0,
    bytes_per_s=float(2 << 20),
    bytes_at_once=float(16 << 20),
    commands_per_s=400.0,
)
QUOTAS: Mapping[Role, Quota] = MappingProxyType(
    {
        Role.OBSERVE: Quota(
            connections=4,
            connections_together=64,
            definitions=0,
            names=256,
            queries=32,
            queries_together=512,
            at_one_handler=8,
            to_one_handler_per_s=100.0,
            requests_per_s=200.0,
            requests_at_once=4000.0,
            bytes_per_s=float(256 << 10),
            bytes_at_once=float(1 << 20),
            commands_per_s=0.0,
        ),
        Role.OPERATE: _OPERATE,
        Role.SUPERVISE: _OPERATE,
        Role.MODULE: Quota(
            connections=64,
            connections_together=384,
            definitions=1024,
            names=1024,
            queries=1024,
            queries_together=3072,
            at_one_handler=1024,
            to_one_handler_per_s=4000.0,
            requests_per_s=4000.0,
            requests_at_once=64_000.0,
            bytes_per_s=float(64 << 20),
            bytes_at_once=float(128 << 20),
            commands_per_s=4000.0,
            handshakes_per_s=4.0,
            handshakes_at_once=160.0,
        ),
    }
)
PRICES: Mapping[type, float] = MappingProxyType(
    {
        control.Hello: 5.0,
        control.List: 20.0,
        control.Watch: 10.0,
        control.Subscribe: 10.0,
        control.Unsubscribe: 10.0,
        control.Advertise: 5.0,
        control.Query: 2.0,
        control.Last: 2.0,
    }
)
"""What a control message costs that makes central work more or tell others; all others cost 1."""
STOPS_PER_S, STOPS_AT_ONCE = 20.0, 40.0
"""Stops of one key that are handed on; who sends more has stopped the robot already."""
_EXCESS = 2000.0
"""A connection that was refused so much, less its rate since then, is ended."""
_MAX_EXCESSIVE = 256
_BARRED_S = 10.0
"""A key whose connection was ended makes no new one for so long [s]."""
_ROLES = {role: rank for rank, role in enumerate(Role)}


def quota_of(principal: Principal) -> Quota | None:
    """The quota of this key; None for clients of this machine."""
    return None if principal is LOCAL else QUOTAS[principal.role]


def counts_with(principal: Principal, role: Role) -> bool:
    """Whether what `principal` uses counts for `role` where a limit is "together"."""
    return principal is not LOCAL and _ROLES[principal.role] <= _ROLES[role]


class QuotaVerdict(enum.Enum):
    """What becomes of a control message."""

    SERVED = "served"
    REFUSED = "refused"
    ENDED = "ended"
    """It is refused, and so was so much before that its connection is ended."""


class Account:
    """What the clients of one key have used."""

    def __init__(self, principal: Principal, quota: Quota) -> None:
        self._principal = principal
        self._quota = quota
        self._requests = Bucket(quota.requests_per_s, quota.requests_at_once)
        self._bytes = Bucket(quota.bytes_per_s, quota.bytes_at_once)
        self._answers = Bucket(1.0, 1.0)
        self._commands = Bucket(quota.commands_per_s, quota.commands_per_s)
        self._stops = Bucket(STOPS_PER_S, STOPS_AT_ONCE)
        self._excess: dict[bytes, Bucket] = {}
        self._handshakes: dict[str, Bucket] = {}
        self._barred_until = -1.0

    @property
    def text(self) -> str:
        """Which limit on control messages there is, for people."""
        quota = self._quota
        return (
            f"the key {self._principal.name!r} ({self._principal.role.value}) asks too much of "
            f"the hub; all its clients together may ask {quota.requests_per_s:.0f} times a second "
            f"(a LIST counts {PRICES[control.List]:.0f}) "
            f"and send {quota.bytes_per_s / 1024:.0f} KiB a second"
        )

    def ask(self, identity: bytes, kind: type | None, size: int, now: float) -> QuotaVerdict:
        """A control message came.

        Args:
            identity: Of its connection.
            kind: What it is; None if it is none.
            size: Of all its parts [bytes].
            now: The time [s].
        """
        price = PRICES.get(kind, 1.0) if kind is not None else 5.0
        if self._bytes.take(size, now) and self._requests.take(price, now):
            return QuotaVerdict.SERVED
        excess = self._excess.get(identity)
        if excess is None:
            if len(self._excess) >= _MAX_EXCESSIVE:
                self._excess.clear()
            excess = self._excess[identity] = Bucket(self._quota.requests_per_s, _EXCESS)
        # A frame that is long is refused at its length: few of them fill the line.
        if excess.take(max(price, size / 4096), now):
            return QuotaVerdict.REFUSED
        del self._excess[identity]
        self._barred_until = now + _BARRED_S
        return QuotaVerdict.ENDED

    def may_command(self, now: float) -> bool:
        """Whether one more command is handed on now."""
        return self._commands.take(1.0, now)

    def may_stop(self, now: float) -> bool:
        """Whether one more stop is handed on now, which no command keeps out."""
        return self._stops.take(1.0, now)

    def may_answer(self, now: float) -> bool:
        """Whether a refusal is answered; one a second is."""
        return self._answers.take(1.0, now)

    def may_connect(self, place: str, now: float) -> bool:
        """Whether one more connection to a place is taken now."""
        handshakes = self._handshakes.get(place)
        if handshakes is None:
            quota = self._quota
            handshakes = Bucket(quota.handshakes_per_s, quota.handshakes_at_once)
            self._handshakes[place] = handshakes
        return now >= self._barred_until and handshakes.take(1.0, now)


class Accounts:
    """The accounts of all keys."""

    def __init__(self) -> None:
        self._accounts: dict[Principal, Account] = {}

    def of(self, principal: Principal) -> Account:
        """The account of this key; it begins with the first use."""
        account = self._accounts.get(principal)
        if account is None:  # another thread may ask at the same time
            account = self._accounts.setdefault(
                principal, Account(principal, QUOTAS[principal.role])
            )
        return account
