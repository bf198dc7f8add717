"""Decides about every CURVE handshake of the gateway.

Each secure socket has a ZAP domain of its own, its place (`roles.CONTROL`, "state in", ...). So a
key is admitted or refused by place, before any message of its holder is read.
"""

from __future__ import annotations

from collections.abc import Callable

from zmq.utils import z85

from hub.errors import KeyFileError
from hub.gateways.accounts import Accounts
from hub.ipc.broker.zap import ZapRequest, ZapVerdict
from hub.ipc.roles import Principal, may_connect
from hub.ipc.security.keyring import Keyring
from hub.ipc.transport.fault_counter import FaultCounter


class KeyJudge:
    """Admits holders of keys on the list, by place, role and rate; a judge of `ZapHandler`."""

    def __init__(
        self,
        keyring: Keyring,
        faults: FaultCounter,
        *,
        accounts: Accounts,
        clock: Callable[[], float],
    ) -> None:
        """Start without admitted keys.

        Args:
            keyring: The keys that may connect.
            faults: Counts refusals.
            accounts: The accounts of the keys.
            clock: Monotonic time [s].
        """
        self._keyring = keyring
        self._faults = faults
        self._accounts = accounts
        self._clock = clock
        self._admitted: set[Principal] = set()

    def judge(self, asked: ZapRequest) -> ZapVerdict:
        """Whether the owner of a key may connect to the place that is the domain."""
        key = asked.credentials[0] if len(asked.credentials) == 1 else b""
        if asked.mechanism != "CURVE" or len(key) != 32:
            return self._refuse(asked, "400", f"mechanism {asked.mechanism[:20]!r}")
        try:
            holder = self._keyring.holder(z85.encode(key).decode())
        except KeyFileError as error:
            return self._refuse(asked, "500", "unreadable list of keys", f"{error}; ")
        if holder is None:
            return self._refuse(asked, "400", "unknown key")
        if not may_connect(holder.role, asked.domain):
            return self._refuse(asked, "400", f"role {holder.role.value}")
        if not self._accounts.of(holder.principal).may_connect(asked.domain, self._clock()):
            detail = f"{holder.name} connects too often, or asked too much; "
            return self._refuse(asked, "300", "over quota", detail)
        self._admitted.add(holder.principal)
        return ZapVerdict(status="200", reason="", user_id=holder.principal.user_id)

    def admitted(self) -> frozenset[Principal]:
        """The keys admitted since the start, at most all that the list ever had."""
        return frozenset(self._admitted)

    def _refuse(self, asked: ZapRequest, status: str, reason: str, detail: str = "") -> ZapVerdict:
        # The key is public: the owner of the robot can find it, or put it on the list.
        key = asked.credentials[0] if asked.credentials else b""
        shown = z85.encode(key).decode() if len(key) == 32 else "none"
        detail += f"from {asked.address}, key {shown}"
        self._faults.count(f"refused at the gateway's {asked.domain}: {reason}", detail)
        return ZapVerdict(status=status, reason=reason)
