"""The gateway for other machines: a copy of central's sockets, open to the holders of keys.

| input | decided by |
| --- | --- |
| a connection | `KeyJudge`: key, role, rate; `ConnectionRates`: its address |
| a control message | `Admission`: its key, and the quota of that key |
| a command | `CommandFilter`: key, role, number, rate |
| a subscription | `FloodWatch`: number, length |
| states and pictures | the role of the connection |
"""

from __future__ import annotations

from collections.abc import Sequence

import zmq

from hub.errors import EndpointError
from hub.gateways.accounts import Accounts
from hub.gateways.curve.admission import Admission
from hub.gateways.curve.command_filter import CommandFilter, user_id_of
from hub.gateways.curve.gateway_sockets import GatewaySockets
from hub.gateways.curve.removed_keys import RemovedKeys
from hub.ipc.broker.gateways import CentralAccess, ControlEntrance, GatewayOpener
from hub.ipc.definition import Plane
from hub.ipc.endpoints import TcpEndpoint, parse_endpoint
from hub.ipc.roles import CONTROL, Principal
from hub.ipc.security.keyring import Keyring
from hub.ipc.transport import sockets

_QUEUE, _BACKLOG = 100, 5000
"""Most control messages that wait from one client, and for one that may not read them."""


def curve_gateway(endpoint: str, keyring: Keyring | None) -> GatewayOpener:
    """A gateway for `Central`, at a tcp:// address, for the keys of a keyring."""

    def open_gateway(central: CentralAccess) -> CurveGateway:
        parsed = parse_endpoint(endpoint, beyond_loopback=True)
        if not isinstance(parsed, TcpEndpoint) or keyring is None:
            text = f"the gateway at {endpoint!r} needs a tcp:// address and a folder of keys"
            raise EndpointError(text)
        return CurveGateway(central, parsed, keyring)

    return open_gateway


class CurveGateway:
    """A gateway of central (see `hub.ipc.broker.gateways.Gateway`).

    Attributes:
        endpoint: Address for clients, with the real port.
        entrances: Its sockets for control messages.
        polled: Sockets that central polls for input.
        ports: TCP ports in the order of the planes: first plane in, out, second plane in, ...
    """

    def __init__(self, central: CentralAccess, endpoint: TcpEndpoint, keyring: Keyring) -> None:
        """Bind and start.

        Args:
            central: Access to central.
            endpoint: Port p takes p and two more for each plane; 0 takes free ports.
            keyring: The keys that may connect, and the hub's own.

        Raises:
            EndpointError: A port is busy.
            KeyFileError: The hub's keys cannot be used.
        """
        self._central = central
        accounts = Accounts()
        self._removed_keys = RemovedKeys(keyring, self.admitted, self._end_key)
        command_filter = CommandFilter(
            central.peer_of,
            self._removed_keys.holds,
            central.faults,
            central.clock,
            accounts=accounts,
        )
        self._sockets = GatewaySockets(
            central.context,
            endpoint,
            keyring,
            {plane.value: addresses for plane, addresses in central.planes.items()},
            central.faults,
            make=self._make,
            accounts=accounts,
            clock=central.clock,
            judge=lambda raw, frame: command_filter.admit(raw, user_id_of(frame)),
            zap=central.zap,
        )
        guard = Admission(
            accounts,
            clock=central.clock,
            faults=central.faults,
            answer=central.send,
            hang_up=lambda frame: self._sockets.hang_up(sockets.descriptor_of(frame)),
            identified=lambda frame, role: self._sockets.identified(
                sockets.descriptor_of(frame), role
            ),
            holds=self._removed_keys.holds,
        )
        router = self._sockets.control
        self.endpoint, self.ports = str(self._sockets.endpoint), self._sockets.ports
        entrance = ControlEntrance(router=router, ports=self.ports, guard=guard)
        self.entrances: Sequence[ControlEntrance] = (entrance,)
        self.polled: Sequence[sockets.Socket] = self._sockets.polled

    def admitted(self) -> frozenset[Principal]:
        """The keys admitted since the start."""
        return self._sockets.admitted()

    def holds(self, principal: Principal) -> bool:
        """Whether this key is still on the list."""
        return self._removed_keys.holds(principal)

    def serve(self, polled: sockets.Socket) -> None:
        """Note connections that end."""
        for descriptor in self._sockets.serve({polled: zmq.POLLIN}):
            self._central.disconnected(descriptor)

    def report_ended(self) -> None:
        """Report all control connections that have ended."""
        for descriptor in self._sockets.ended():
            self._central.disconnected(descriptor)

    def check(self) -> None:
        """Detect floods, silent connections and removed keys."""
        self._sockets.check(self._central.has_connection)
        self._removed_keys.check(self._central.clock())

    def close(self) -> None:
        """End the relays, and free the ports."""
        self._sockets.close()

    def _make(self, kind: int, plane: str) -> sockets.Socket:
        if plane != CONTROL:
            return sockets.make_plane(self._central.context, kind, Plane(plane))
        router = sockets.make_router(self._central.context)
        router.rcvhwm, router.sndhwm = _QUEUE, _BACKLOG
        return router

    def _end_key(self, principal: Principal) -> None:
        self._sockets.end_broadcasts()
        for descriptor in self._central.descriptors_of(principal):
            self._sockets.hang_up(descriptor)
            self._central.disconnected(descriptor)
