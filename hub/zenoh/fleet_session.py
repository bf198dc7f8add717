"""A session of a fleet: puts and queries by way, and what a robot declares for others.

Callbacks come on threads of Zenoh, and return at once. A put on a full line drops its message,
after 20 ms.
"""

from __future__ import annotations

import contextlib
import enum
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hub.errors import RouterUnreachableError
from hub.ipc.definition import Plane
from hub.zenoh.certificate_facts import read_certificate
from hub.zenoh.session import ZenohDeclared, ZenohSample, ZenohSession, connect, direct
from hub.zenoh.settings import CertificateFiles, RouterPlace

if TYPE_CHECKING:
    import zenoh

_LONGEST_REASON = 1000
_GRACE_S = 1.0
_ROUTER = "rune-hub fleet router"


class FleetWay(enum.Enum):
    """The way of a message through a fleet: its priority, and with it its link.

    Attributes:
        COMMAND: For commands, and queries about control.
        STATE: For states and events.
        BULK: For pictures, maps and logs.
    """

    COMMAND = ("REAL_TIME", True)
    STATE = ("INTERACTIVE_HIGH", True)
    BULK = ("DATA_LOW", False)

    @staticmethod
    def of(plane: Plane) -> FleetWay:
        """The way of a broadcast."""
        return _WAYS[plane]

    @staticmethod
    def of_query(plane: Plane) -> FleetWay:
        """The way of a query and its answer; only those of the command plane are short."""
        return FleetWay.COMMAND if plane is Plane.COMMAND else FleetWay.BULK


_WAYS = {
    Plane.COMMAND: FleetWay.COMMAND,
    Plane.STATE: FleetWay.STATE,
    Plane.PICTURE: FleetWay.BULK,
}


class FleetQuery:
    """A query from a fleet; answer or refuse it once, on any thread.

    Attributes:
        key: What it asks for.
        payload: Its bytes.
        attachment: Its header; None: it has none.
    """

    def __init__(self, query: zenoh.Query) -> None:
        self._query: zenoh.Query | None = query
        self.key = str(query.key_expr)
        self.payload = query.payload.to_bytes() if query.payload is not None else b""
        attachment = query.attachment
        self.attachment = attachment.to_bytes() if attachment is not None else None

    def answer(self, payload: bytes, attachment: bytes | None = None, *, key: str = "") -> None:
        """Answer; an asker who has gone gets nothing."""
        self._end(lambda query: query.reply(key or self.key, payload, attachment=attachment))

    def refuse(self, error: str, why: str) -> None:
        """Answer with a class of `hub.errors`, and why there is no answer."""
        self._end(lambda query: query.reply_err(f"{error}: {why}".encode()))

    def _end(self, reply: Callable[[Any], None]) -> None:
        import zenoh

        query, self._query = self._query, None
        if query is None:
            return
        with contextlib.suppress(zenoh.ZError):  # the line or the asker is gone
            reply(query)
        query.drop()  # type: ignore[no-untyped-call]


class _Watched(ZenohDeclared):
    """A publisher and its listener, which ends when it is forgotten."""

    def __init__(self, publisher: zenoh.Publisher, listener: object) -> None:
        super().__init__(publisher)
        self._listener = listener


class FleetSession(ZenohSession):
    """A session of a fleet; it finds its router again by itself."""

    @property
    def routers(self) -> int:
        """Number of routers that it is connected to now."""
        return 0 if self._session.is_closed() else len(self._session.info.routers_zid())

    def links(self) -> list[str]:
        """The links now, each with its priorities."""
        return [str(link.dst) for link in self._session.info.links()]

    def put(self, key: str, payload: bytes, attachment: bytes | None, way: FleetWay) -> None:
        """Put once."""
        import zenoh

        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._session.put(key, payload, attachment=attachment, **_quality(way))

    def watch_subscribers(self, key: str, changed: Callable[[bool], None]) -> ZenohDeclared:
        """Call `changed` when the first subscriber of a key comes, and when the last has gone."""
        publisher = self._session.declare_publisher(key)

        def take(now: zenoh.MatchingStatus) -> None:
            changed(now.matching)

        listener = publisher.declare_matching_listener(direct(take))
        if publisher.matching_status:
            changed(True)  # noqa: FBT003 - a callback's only argument
        return _Watched(publisher, listener)

    def respond(self, pattern: str, take: Callable[[FleetQuery], None]) -> ZenohDeclared:
        """Call `take` for each query of keys that match."""

        def asked(query: zenoh.Query) -> None:
            take(FleetQuery(query))

        return ZenohDeclared(self._session.declare_queryable(pattern, direct(asked), complete=True))

    def query(
        self,
        key: str,
        payload: bytes,
        attachment: bytes | None,
        *,
        way: FleetWay,
        timeout: float,
        answered: Callable[[ZenohSample], None],
        failed: Callable[[str, str], None],
        ended: Callable[[], None],
    ) -> None:
        """Ask; each reply calls `answered` or `failed`, and `ended` comes after the last.

        Args:
            key: What is asked for; a pattern may get several replies.
            payload: Bytes of the query.
            attachment: Its header.
            way: Its way, and that of the reply.
            timeout: Longest wait for replies [s].
            answered: Gets a reply.
            failed: Gets a class of `hub.errors`, and why there is no answer.
            ended: There will be no more.
        """
        import zenoh

        def replied(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                sample = reply.ok
                header = sample.attachment
                answered(
                    ZenohSample(
                        key=str(sample.key_expr),
                        payload=sample.payload.to_bytes(),
                        attachment=header.to_bytes() if header is not None else None,
                    )
                )
            elif reply.err is not None:
                text = reply.err.payload.to_bytes()[:_LONGEST_REASON].decode("utf-8", "replace")
                error, _, why = text.partition(": ")
                if why:  # else Zenoh itself says "Timeout", and the end follows
                    failed(error, why)

        try:
            self._session.get(
                key,
                direct(replied, ended),
                payload=payload,
                attachment=attachment,
                timeout=timeout,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                **_quality(way),
            )
        except zenoh.ZError as error:
            failed("QueryError", str(error).partition(" at /")[0])
            ended()

    def answers(self, key: str, *, way: FleetWay, timeout: float) -> list[ZenohSample]:
        """All answers to a query without a payload; waits for them, up to `timeout` [s]."""
        found: list[ZenohSample] = []
        ended = threading.Event()
        self.query(
            key,
            b"",
            None,
            way=way,
            timeout=timeout,
            answered=found.append,
            failed=lambda *_: None,
            ended=ended.set,
        )
        ended.wait(timeout + _GRACE_S)
        return found

    def tokens(self, pattern: str, *, timeout: float) -> list[str]:
        """The keys of the tokens that are there now; waits for up to `timeout` [s]."""
        replies = self._session.liveliness().get(pattern, timeout=timeout)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]


def check_certificates(settings: dict[str, Any]) -> None:
    """See that the own certificate in settings is there, and counts.

    Raises:
        KeyFileError: It does not.
    """
    shown = settings.get("transport/link/tls")
    if shown is not None:
        side = "connect" if "connect_certificate" in shown else "listen"
        read_certificate(
            CertificateFiles(
                authority=Path(shown["root_ca_certificate"]),
                certificate=Path(shown[f"{side}_certificate"]),
                key=Path(shown[f"{side}_private_key"]),
            )
        )


def open_fleet_session(
    place: RouterPlace, settings: dict[str, Any], *, mode: str = "client"
) -> FleetSession:
    """Open a session of a fleet.

    Raises:
        RouterUnreachableError: No router answers there, or Zenoh is not installed.
        KeyFileError: The own certificate is not there, or does not count.
    """
    check_certificates(settings)
    try:
        return FleetSession(connect(str(place), mode=mode, settings=settings))
    except RouterUnreachableError as error:
        if mode == "router" or isinstance(error.__cause__, ImportError):
            raise
        why = ", or it does not know this certificate" if place.scheme == "tls" else ""
        text = f"no router of a fleet answers at {place}{why}; start one there: `{_ROUTER}`"
        raise RouterUnreachableError(text) from error


def _quality(way: FleetWay) -> dict[str, Any]:
    import zenoh

    priority, express = way.value
    return {
        "priority": getattr(zenoh.Priority, priority),
        "congestion_control": zenoh.CongestionControl.DROP,
        "express": express,
    }
