"""How much of central each role may use; pure.

All connections with one key share its quota. Clients of this machine have no key and no quota.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from hub.ipc.roles import LOCAL, Principal, Role
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Quota:
    """The limits of a role. A limit that is "together" counts the roles below as well.

    Attributes:
        connections: Connected clients of one key.
        connections_together: Connected clients with keys of this role.
        definitions: New messages that the clients of one key may define.
        names: Messages that one client may publish; the same for subscriptions and answers.
        queries: Queries under way of one key.
        queries_together: Queries under way of this role.
        at_one_handler: Queries under way of this role at one handler.
        to_one_handler_per_s: Queries of this role to one handler [1/s].
        requests_per_s: Control messages of one key, by their prices [1/s].
        requests_at_once: The same, in one burst after a rest.
        bytes_per_s: Bytes of control messages of one key [B/s].
        bytes_at_once: The same, in one burst after a rest [B].
        commands_per_s: Broadcast commands of one key, without stops [1/s].
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


def quota_of(principal: Principal) -> Quota | None:
    """The quota of this key; None for clients of this machine."""
    return None if principal is LOCAL else QUOTAS[principal.role]


def counts_with(principal: Principal, role: Role) -> bool:
    """Whether `principal` counts for `role` where a limit is "together"."""
    return principal is not LOCAL and role.includes(principal.role)
