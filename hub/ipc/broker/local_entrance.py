"""Where clients of this machine reach central: Unix sockets, and TCP ports with a token."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hub.errors import EndpointError
from hub.ipc.broker import binding
from hub.ipc.broker.gateways import ControlEntrance
from hub.ipc.broker.zap import ZapHandler, ZapRequest, ZapVerdict
from hub.ipc.endpoints import IpcEndpoint, TcpEndpoint, parse_endpoint
from hub.ipc.security.token import RunPassword, Token, keep_token, own_token
from hub.ipc.transport import sockets
from hub.ipc.transport.fault_counter import FaultCounter

_ABSTRACT = "ipc://@"


class LocalEntrance:
    """Central's own addresses; bound from the start to `close`.

    Attributes:
        endpoints: The addresses for clients, with the real port.
        entrance: The socket of control messages, and the addresses of the planes.
    """

    def __init__(
        self,
        ends: Sequence[sockets.Socket],
        endpoints: Sequence[str],
        zap: ZapHandler,
        faults: FaultCounter,
        epoch: int,
    ) -> None:
        """Bind.

        Args:
            ends: The sockets: for control messages (ROUTER), then in and out of each plane.
            endpoints: Addresses: ipc://, and at most one of tcp://.
            zap: Answers the handshakes at TCP ports.
            faults: Counts refusals.
            epoch: Number of this run of central.

        Raises:
            EndpointError: An address is malformed, not allowed, or busy.
            KeyFileError: The token of the port cannot be used.
        """
        self._faults = faults
        self._epoch = epoch
        self._proofs: dict[str, Token | RunPassword] = {}
        self._files: list[Path] = []
        self.endpoints: list[str] = []
        wanted = [parse_endpoint(endpoint) for endpoint in endpoints]
        if sum(isinstance(endpoint, TcpEndpoint) for endpoint in wanted) > 1:
            text = "central listens at one tcp:// endpoint; name only one"
            raise EndpointError(text)
        ports, paths = [0] * (len(ends) - 1), [""] * (len(ends) - 1)
        zap.decide([binding.TOKEN_DOMAIN], self._judge)
        zap.decide([binding.FILE_DOMAIN], lambda _: ZapVerdict(status="200", reason=""))
        # A filter of users holds for what a socket binds later: abstract sockets come last.
        for endpoint in sorted(wanted, key=lambda each: str(each).startswith(_ABSTRACT)):
            if isinstance(endpoint, TcpEndpoint):
                ports = self._bind_ports(ends, endpoint)
            else:
                bound = self._bind(ends, endpoint)
                paths = bound if not any(paths) else paths
                files = [each for each in (endpoint.path, *bound) if not each.startswith("@")]
                self._files += map(Path, files)
        self.entrance = ControlEntrance(router=ends[0], ports=tuple(ports), paths=tuple(paths))

    def _bind_ports(self, ends: Sequence[sockets.Socket], endpoint: TcpEndpoint) -> list[int]:
        """Bind at ports of this machine; those of the planes."""
        token = own_token(endpoint.port)
        password = token.of_run(self._epoch)
        self._proofs = {"CURVE": token, "PLAIN": password}
        rest = self._bind(ends, endpoint, token.serve, password.serve)
        file = keep_token(token, int(self.endpoints[-1].rpartition(":")[2]))
        if not endpoint.port:
            self._files.append(file)  # no other hub will have this port
        return [int(address.rpartition(":")[2]) for address in rest]

    def _bind(
        self,
        ends: Sequence[sockets.Socket],
        endpoint: TcpEndpoint | IpcEndpoint,
        protect_control: binding.Protect | None = None,
        protect_plane: binding.Protect | None = None,
    ) -> list[str]:
        """Bind all at an endpoint and beside it; where those of the planes are."""
        bound = [
            binding.bind(
                end,
                binding.sibling(endpoint, index),
                protect_plane if index else protect_control,
            )
            for index, end in enumerate(ends)
        ]
        self.endpoints.append(bound[0])
        return [address.partition("://")[2] for address in bound[1:]]

    def close(self) -> None:
        """Remove the socket files, after the sockets are closed."""
        for path in self._files:
            path.unlink(missing_ok=True)

    def _judge(self, asked: ZapRequest) -> ZapVerdict:
        """Whether a client may connect to a TCP port."""
        proof = self._proofs.get(asked.mechanism)
        if proof is not None and proof.admits(asked.credentials):
            return ZapVerdict(status="200", reason="")
        self._faults.count("refused at a TCP port", "a client there shows no token of this hub")
        return ZapVerdict(status="400", reason="no token")
