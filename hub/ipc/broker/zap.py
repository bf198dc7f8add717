"""Answers every handshake that ZeroMQ asks about: TCP clients with a token, clients with a key.

Each TCP socket has a ZAP domain (ZeroMQ RFC 27), and each domain has one judge. With a domain,
ZeroMQ also refuses all but ZMTP 3 before the first frame, such as HTTP from a browser.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import zmq

from hub.errors import EndpointError
from hub.ipc.transport.fault_counter import FaultCounter
from hub.values import dataclass

_ADDRESS = "inproc://zeromq.zap.01"
_VERSION = b"1.0"
_BATCH = 16
_LEAST_PARTS, _MOST_PARTS = 8, 10
"""Sender, empty, version, request, domain, address, identity, mechanism, up to 2 credentials."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ZapRequest:
    """A handshake to decide about.

    Attributes:
        domain: Domain of the socket.
        address: IP address of the client.
        mechanism: "NULL", "PLAIN" or "CURVE".
        credentials: User name and password (PLAIN), the 32 bytes of a key (CURVE), or nothing.
    """

    domain: str
    address: str
    mechanism: str
    credentials: tuple[bytes, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ZapVerdict:
    """The answer to a handshake.

    Attributes:
        status: "200" admitted, "300" not now, "400" refused, "500" unknown. After 300 the client's
            socket tries again; after 400 and 500 it does not, and the client needs a new one.
        reason: Reason for a refusal; empty: admitted.
        user_id: ZeroMQ adds it to every frame of the connection.
    """

    status: str
    reason: str
    user_id: str = ""


Judge = Callable[[ZapRequest], ZapVerdict]


class ZapHandler:
    """Answers ZeroMQ's requests; owned by the thread that polls its socket.

    Attributes:
        socket: Poll it for input, then call `serve`.
    """

    def __init__(self, context: zmq.Context[zmq.Socket[bytes]], faults: FaultCounter) -> None:
        """Register at ZeroMQ.

        Args:
            context: Context of the sockets that have domains.
            faults: Counts malformed requests.

        Raises:
            EndpointError: This context has another ZAP handler already.
        """
        self._faults = faults
        self._judges: dict[str, Judge] = {}
        self.socket = context.socket(zmq.ROUTER)
        self.socket.linger = 0
        try:
            self.socket.bind(_ADDRESS)
        except zmq.ZMQError as error:
            self.socket.close()
            text = f"nobody can decide who may connect ({error}); close the other handler first"
            raise EndpointError(text) from error

    def decide(self, domains: Iterable[str], judge: Judge) -> None:
        """Have `judge` decide about all handshakes at these domains."""
        self._judges.update(dict.fromkeys(domains, judge))

    def serve(self) -> bool:
        """Answer the waiting requests, without waiting; whether there may be more."""
        for _ in range(_BATCH):
            try:
                parts = self.socket.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:
                return False
            self._answer(parts)
        return True

    def close(self) -> None:
        """Unregister: from now on ZeroMQ refuses every handshake."""
        self.socket.close()

    def _answer(self, parts: Sequence[bytes]) -> None:
        if not _LEAST_PARTS <= len(parts) <= _MOST_PARTS or parts[2] != _VERSION:
            self._faults.count("malformed ZAP request", f"{len(parts)} parts")
            return
        sender, empty, version, request, domain, address, _, mechanism, *credentials = parts
        asked = ZapRequest(
            domain=domain.decode(errors="replace"),
            address=address.decode(errors="replace"),
            mechanism=mechanism.decode(errors="replace"),
            credentials=tuple(credentials),
        )
        judge = self._judges.get(asked.domain)
        unknown = ZapVerdict(status="400", reason="unknown domain")
        verdict = unknown if judge is None else judge(asked)
        reply = [sender, empty, version, request, verdict.status.encode()]
        self.socket.send_multipart(
            [*reply, verdict.reason.encode(), verdict.user_id.encode(), b""], zmq.NOBLOCK
        )
