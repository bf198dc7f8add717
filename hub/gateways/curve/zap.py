"""Decides about every CURVE handshake of the gateway: ZeroMQ asks here (ZAP, RFC 27).

Each secure socket has a ZAP domain of its own, its place (`roles.CONTROL`, "state in", ...). So a
key is admitted or refused by place, before any message of its holder is read.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import zmq
from zmq.utils import z85

from hub.errors import EndpointError, KeyFileError
from hub.gateways.accounts import Accounts
from hub.ipc.roles import Principal, may_connect
from hub.ipc.security.keyring import Keyring
from hub.ipc.transport.fault_counter import FaultCounter
from hub.values import dataclass

_ADDRESS = "inproc://zeromq.zap.01"
_VERSION = b"1.0"
_BATCH = 16
_PARTS = 9
"""Sender, empty, version, request, domain, address, identity, mechanism, key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ZapVerdict:
    """The answer to a handshake.

    Attributes:
        status: "200" admitted, "300" not now, "400" refused, "500" unknown. After 300 the client's
            socket tries again; after 400 and 500 it does not, and the client needs a new one.
        reason: Reason for a refusal; empty: admitted.
        detail: More of it, for the log.
        user_id: Role, name and fingerprint of the key, which ZeroMQ adds to every frame of the
            connection.
    """

    status: str
    reason: str
    detail: str = ""
    user_id: str = ""


class ZapHandler:
    """Answers ZeroMQ's requests; owned by the thread that polls its socket.

    Attributes:
        socket: Poll it for input, then call `serve`.
    """

    def __init__(
        self,
        context: zmq.Context[zmq.Socket[bytes]],
        keyring: Keyring,
        faults: FaultCounter,
        *,
        accounts: Accounts,
        clock: Callable[[], float],
    ) -> None:
        """Register at ZeroMQ.

        Args:
            context: Context of the secure sockets.
            keyring: The keys that may connect.
            faults: Counts refusals.
            accounts: The accounts of the keys.
            clock: Monotonic time [s].

        Raises:
            EndpointError: This process has another ZAP handler in the same ZeroMQ context.
        """
        self._keyring = keyring
        self._faults = faults
        self._accounts = accounts
        self._clock = clock
        self._admitted: set[Principal] = set()
        self.socket = context.socket(zmq.ROUTER)
        self.socket.linger = 0
        try:
            self.socket.bind(_ADDRESS)
        except zmq.ZMQError as error:
            self.socket.close()
            text = f"the gateway cannot decide who may connect ({error}); close the other one first"
            raise EndpointError(text) from error

    def serve(self) -> None:
        """Answer the waiting requests; returns without waiting."""
        for _ in range(_BATCH):
            try:
                parts = self.socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return
            self._answer(parts)

    def close(self) -> None:
        """Unregister: from now on ZeroMQ refuses every handshake."""
        self.socket.close()

    def judge(self, domain: str, mechanism: str, key: bytes) -> ZapVerdict:
        """Whether the owner of `key` (32 bytes) may connect to the place named `domain`."""
        if mechanism != "CURVE" or len(key) != 32:
            return ZapVerdict(status="400", reason=f"mechanism {mechanism[:20]!r}")
        try:
            holder = self._keyring.holder(z85.encode(key).decode())
        except KeyFileError as error:
            return ZapVerdict(status="500", reason="unreadable list of keys", detail=f"{error}; ")
        if holder is None:
            return ZapVerdict(status="400", reason="unknown key")
        if not may_connect(holder.role, domain):
            return ZapVerdict(status="400", reason=f"role {holder.role.value}")
        if not self._accounts.of(holder.principal).may_connect(domain, self._clock()):
            detail = f"{holder.name} connects too often, or asked too much; "
            return ZapVerdict(status="300", reason="over quota", detail=detail)
        self._admitted.add(holder.principal)
        return ZapVerdict(status="200", reason="", user_id=holder.principal.user_id)

    def admitted(self) -> frozenset[Principal]:
        """The keys admitted since the start, at most all that the list ever had."""
        return frozenset(self._admitted)

    def _answer(self, parts: Sequence[bytes]) -> None:
        if len(parts) != _PARTS or parts[2] != _VERSION:
            self._faults.count("malformed ZAP request", f"{len(parts)} parts")
            return
        sender, empty, version, request, domain, address, _, mechanism, key = parts
        place = domain.decode(errors="replace")
        verdict = self.judge(place, mechanism.decode(errors="replace"), key)
        if verdict.status != "200":
            # The key is public: the owner of the robot can find it, or put it on the list.
            shown = f"from {address.decode(errors='replace')}, key {z85.encode(key).decode()}"
            self._faults.count(
                f"refused at the gateway's {place}: {verdict.reason}", verdict.detail + shown
            )
        reply = [sender, empty, version, request, verdict.status.encode()]
        self.socket.send_multipart(
            [*reply, verdict.reason.encode(), verdict.user_id.encode(), b""], zmq.NOBLOCK
        )
