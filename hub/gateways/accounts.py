"""The accounts of keys: the used part of their quotas.

All connections with one key share one account. Pure: the time comes with each call.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from types import MappingProxyType

from hub.bucket import Bucket
from hub.ipc.broker.quotas import QUOTAS, Quota
from hub.ipc.roles import Principal
from hub.ipc.wire import control

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
"""The price of a control message that is expensive for central; all others cost 1."""
STOPS_PER_S, STOPS_AT_ONCE = 20.0, 40.0
"""Stops of one key that pass [1/s, burst]; with more, the robot is stopped already."""
_EXCESS = 2000.0
"""Amount of refused requests, less the rate since then, that ends a connection."""
_MAX_EXCESSIVE = 256
BARRED_S = 10.0
"""Time without new connections for a key after such an end [s]."""


class QuotaVerdict(enum.Enum):
    """The decision on a control message."""

    SERVED = "served"
    REFUSED = "refused"
    ENDED = "ended"
    """It is refused, and its connection ends: too much was refused before."""


class Account:
    """The used quota of one key's clients."""

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
        """The limits on control messages, for people."""
        quota = self._quota
        return (
            f"the key {self._principal.name!r} ({self._principal.role.value}) asks too much of "
            f"the hub; all its clients together may ask {quota.requests_per_s:.0f} times a second "
            f"(a LIST counts {PRICES[control.List]:.0f}) "
            f"and send {quota.bytes_per_s / 1024:.0f} KiB a second"
        )

    def ask(self, identity: bytes, kind: type | None, size: int, now: float) -> QuotaVerdict:
        """Charge a control message.

        Args:
            identity: Of its connection.
            kind: Its kind; None: it is no control message.
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
        # A long frame is refused by its length: a few of them fill the line.
        if excess.take(max(price, size / 4096), now):
            return QuotaVerdict.REFUSED
        del self._excess[identity]
        self._barred_until = now + BARRED_S
        return QuotaVerdict.ENDED

    def may_command(self, now: float) -> bool:
        """Charge a command; whether it may pass."""
        return self._commands.take(1.0, now)

    def may_stop(self, now: float) -> bool:
        """Charge a stop, apart from commands; whether it may pass."""
        return self._stops.take(1.0, now)

    def may_answer(self, now: float) -> bool:
        """Whether a refusal gets an answer: at most one a second."""
        return self._answers.take(1.0, now)

    def may_connect(self, place: str, now: float) -> bool:
        """Charge a connection to a place; whether it may stay."""
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
        """The account of this key, made at first use."""
        account = self._accounts.get(principal)
        if account is None:  # another thread may call this at the same time
            account = self._accounts.setdefault(
                principal, Account(principal, QUOTAS[principal.role])
            )
        return account
