"""A session with a Zenoh router, as far as doors and lines need it.

Zenoh calls back on threads of its own, which also read from the network. Who takes such a call puts
the sample into a queue, and returns at once.
"""

from __future__ import annotations

import atexit
import contextlib
import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final, Protocol, TypeVar

from hub.errors import RouterUnreachableError
from hub.values import dataclass

if TYPE_CHECKING:
    import zenoh

_Came = TypeVar("_Came")

EXTRA: Final = "robot-user-nexus[fleet]"
"""What to install for Zenoh."""
OPEN_S: Final = 3.0
"""Longest time to open a session with a router that does not answer [s]."""
LEASE_S: Final = 2.0
"""Silence after which the other side is gone [s]; Zenoh's own threads keep it up."""
_RETRY_MS: Final = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2}
_TOO_LONG: Final = 1 << 28
"""Longest payload that is taken [bytes]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ZenohSample:
    """A received sample.

    Attributes:
        key: The key.
        payload: Its bytes.
        attachment: What is attached; None: nothing.
    """

    key: str
    payload: bytes
    attachment: bytes | None


class _Undeclared(Protocol):
    def undeclare(self) -> None: ...


class _Putting(_Undeclared, Protocol):
    def put(self, payload: bytes, *, attachment: bytes) -> None: ...


class ZenohPublisher:
    """Puts samples under one key; what cannot leave at once is dropped."""

    def __init__(self, made: _Putting) -> None:
        self._made = made

    def put(self, payload: bytes | memoryview, attachment: bytes) -> bool:
        """Put a sample; returns whether the session is open."""
        import zenoh

        try:
            self._made.put(bytes(payload), attachment=attachment)
        except zenoh.ZError:
            return False
        return True

    def undeclare(self) -> None:
        """Put no more."""
        _undeclare(self._made)


class ZenohDeclared:
    """Something that a session has declared: a token, a subscriber, a listener."""

    def __init__(self, made: _Undeclared) -> None:
        self._made = made

    def undeclare(self) -> None:
        """Take it back."""
        _undeclare(self._made)


class ZenohSession:
    """An open session; it finds its router again by itself."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self.zid = str(session.zid())

    def declare_token(self, key: str) -> ZenohDeclared:
        """Announce a key for as long as this session lives."""
        return ZenohDeclared(self._session.liveliness().declare_token(key))

    def watch_tokens(self, pattern: str, taken: Callable[[str, bool], None]) -> ZenohDeclared:
        """Have the key of each token that there is, that comes, and (False) that goes."""
        import zenoh

        put = zenoh.SampleKind.PUT

        def take(sample: zenoh.Sample) -> None:
            taken(str(sample.key_expr), sample.kind == put)

        return ZenohDeclared(
            self._session.liveliness().declare_subscriber(pattern, direct(take), history=True)
        )

    def watch_link(self, changed: Callable[[bool], None]) -> ZenohDeclared:
        """Learn that the router is there, now or later, or (False) gone."""
        import zenoh

        put = zenoh.SampleKind.PUT

        def take(event: zenoh.TransportEvent) -> None:
            changed(event.kind == put)

        return ZenohDeclared(
            self._session.info.declare_transport_events_listener(direct(take), history=True)
        )

    def subscribe(
        self, key: str, taken: Callable[[ZenohSample], None], *, history: int = 0
    ) -> ZenohDeclared:
        """Have each sample of a key from other sessions.

        Args:
            key: The key, which may be a pattern.
            taken: Takes them.
            history: Most samples of before that each publisher with a memory gives.
        """
        import zenoh

        def take(sample: zenoh.Sample) -> None:
            if len(sample.payload) <= _TOO_LONG:
                taken(_sample(sample))

        remote = zenoh.Locality.REMOTE
        if not history:
            return ZenohDeclared(
                self._session.declare_subscriber(key, direct(take), allowed_origin=remote)
            )
        from zenoh import ext

        return ZenohDeclared(
            ext.declare_advanced_subscriber(
                self._session,
                key,
                direct(take),
                history=ext.HistoryConfig(detect_late_publishers=True, max_samples=history),
                allowed_origin=remote,
            )
        )

    def publisher(self, key: str, *, urgent: bool = False, latched: bool = False) -> ZenohPublisher:
        """A publisher of a key.

        Args:
            key: The key.
            urgent: Before all others, and not gathered with them.
            latched: The last sample is kept for those who subscribe later.
        """
        import zenoh

        drop = zenoh.CongestionControl.DROP
        priority = zenoh.Priority.REAL_TIME if urgent else zenoh.Priority.DATA
        if not latched:
            return ZenohPublisher(
                self._session.declare_publisher(
                    key, congestion_control=drop, priority=priority, express=urgent
                )
            )
        from zenoh import ext

        return ZenohPublisher(
            ext.declare_advanced_publisher(
                self._session,
                key,
                congestion_control=drop,
                priority=priority,
                express=urgent,
                cache=ext.CacheConfig(max_samples=1),
                publisher_detection=True,
            )
        )

    def ask(
        self,
        key: str,
        payload: bytes,
        attachment: bytes,
        timeout: float,
        answered: Callable[[bytes | None], None],
    ) -> None:
        """Send a query; `answered` is called with each answer, and with None at the end."""
        import zenoh

        def take(reply: zenoh.Reply) -> None:
            if reply.ok is not None and len(reply.ok.payload) <= _TOO_LONG:
                answered(reply.ok.payload.to_bytes())

        self._session.get(
            key,
            direct(take, lambda: answered(None)),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            congestion_control=zenoh.CongestionControl.DROP,
            timeout=timeout,
            payload=payload,
            attachment=attachment,
        )

    def probe(self, answered: Callable[[], None], timeout: float) -> None:
        """Ask the router for something; `answered` is called then, or after `timeout` [s]."""
        self._session.liveliness().get(
            f"@rune/{self.zid}/probe",
            direct(lambda _: None, answered),
            timeout=timeout,
        )

    def close(self) -> None:
        """End the session; may wait for a moment."""
        import zenoh

        atexit.unregister(self._session.close)
        with contextlib.suppress(zenoh.ZError):
            self._session.close()  # type: ignore[no-untyped-call]


def open_session(
    endpoint: str, *, mode: str = "client", settings: Mapping[str, object] | None = None
) -> ZenohSession:
    """Open a session; waits until the router answers.

    Args:
        endpoint: Such as "tcp/127.0.0.1:7447".
        mode: "client"; or "router" or "peer", which listen there.
        settings: Settings of Zenoh by their path, such as "transport/link/tx/lease".

    Raises:
        RouterUnreachableError: No router answers there, or Zenoh is not installed.
    """
    return ZenohSession(connect(endpoint, mode=mode, settings=settings))


def connect(endpoint: str, *, mode: str, settings: Mapping[str, object] | None) -> zenoh.Session:
    """A session of Zenoh itself; as `open_session`.

    Raises:
        RouterUnreachableError: No router answers there, or Zenoh is not installed.
    """
    try:
        import zenoh
    except ImportError as error:
        text = f"Zenoh is not installed; `pip install '{EXTRA}'` brings it"
        raise RouterUnreachableError(text) from error
    zenoh.init_log_from_env_or("off")  # what is wrong comes as errors
    config = zenoh.Config()
    given = {
        "mode": mode,
        f"{'connect' if mode == 'client' else 'listen'}/endpoints": [endpoint],
        "scouting/multicast/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": round(LEASE_S * 1000),
        "transport/unicast/open_timeout": round(OPEN_S * 1000),
        "connect/retry": _RETRY_MS,
        "timestamping/enabled": True,  # what is latched needs it
        **(settings or {}),
    }
    try:
        for path, value in given.items():
            config.insert_json5(path, json.dumps(value))
        session = zenoh.open(config)
    except zenoh.ZError as error:
        text = f"no Zenoh router answers at {endpoint[:80]}; start one there, such as rmw_zenohd"
        if endpoint.startswith("tls/"):
            text += ", or see that both sides know each other's authority"
        if mode == "router":
            why = str(error).partition(" at /")[0][:200]
            text = f"no Zenoh router can listen at {endpoint[:80]}: {why}"
        raise RouterUnreachableError(text) from error
    # Else the threads of Zenoh may call an interpreter that is ending.
    atexit.register(session.close)
    return session


def _sample(sample: zenoh.Sample) -> ZenohSample:
    attached = sample.attachment
    return ZenohSample(
        key=str(sample.key_expr),
        payload=sample.payload.to_bytes(),
        attachment=None if attached is None else attached.to_bytes(),
    )


def direct(
    take: Callable[[_Came], object], ended: Callable[[], object] | None = None
) -> Callable[[_Came], object]:
    """Calls `take` in a thread of Zenoh, and `ended` after the last time.

    By itself, Zenoh makes a thread of Python for each callback. Such a thread keeps a process that
    ends with an open session from ending.
    """
    from zenoh import handlers

    made: Callable[[_Came], object] = handlers.Callback(take, ended, indirect=False)
    return made


def _undeclare(made: _Undeclared) -> None:
    import zenoh

    with contextlib.suppress(zenoh.ZError):  # its session is closed
        made.undeclare()
