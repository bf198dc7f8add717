"""A program's line to its fleet: opens the session, and does all in the loop of its owner.

The session is opened on a thread, again and again until a router answers. What was declared before
is declared then. Puts and replies leave on two threads, because a full line delays them: commands
and states on one, all that is large on the other.
"""

from __future__ import annotations

import functools
import logging
import threading
import time
from collections.abc import Callable, Hashable
from typing import Any, Protocol

from hub.errors import HubError
from hub.ipc.definition import Plane
from hub.zenoh.fleet_session import FleetQuery, FleetSession, FleetWay, open_fleet_session
from hub.zenoh.handover import Handover, Sender, Work
from hub.zenoh.session import ZenohDeclared, ZenohSample
from hub.zenoh.settings import RouterPlace
from hub.zenoh.token_changes import TokenChanges

_logger = logging.getLogger(__name__)

_RETRY_S = 0.5
_PUT_S = 0.5
"""Longest wait of a put that has no limit of its own [s]."""

LONGEST = 1 << 24
"""Longest payload that waits for the loop [bytes]; the bus carries none of this length."""

Came = Callable[[str, bytes, bytes | None], None]
"""Gets the key, the payload and the attachment of what was put."""


class PostingLoop(Protocol):
    """The loop of the owner."""

    def post(self, work: Work) -> None:
        """Have the loop make a call; any thread may ask."""


class FleetDeclared:
    """Something that stands at a key until it is withdrawn."""

    def __init__(
        self, make: Callable[[FleetSession], ZenohDeclared], all_declared: set[FleetDeclared]
    ) -> None:
        self._make = make
        self._made: ZenohDeclared | None = None
        self._all = all_declared
        all_declared.add(self)  # Zenoh ends what its program has forgotten

    def declare(self, session: FleetSession) -> None:
        """Declare it."""
        self._made = self._make(session)

    def withdraw(self) -> None:
        """Take it back."""
        self._all.discard(self)
        if self._made is not None:
            self._made.undeclare()
            self._made = None


class ZenohFleetLine:
    """A line to a fleet. The owner's loop makes all calls, and gets all callbacks."""

    def __init__(self, place: RouterPlace, settings: dict[str, Any], loop: PostingLoop) -> None:
        """Begin to open it.

        Args:
            place: Where the router listens.
            settings: As `client_settings` gives them.
            loop: The owner's.
        """
        self._place, self._settings, self._loop = place, settings, loop
        self._handover = Handover(loop.post)
        self._senders = {
            FleetWay.COMMAND: (quick := Sender("fleet")),
            FleetWay.STATE: quick,
            FleetWay.BULK: Sender("fleet bulk"),
        }
        self._session: FleetSession | None = None
        self._trouble = ""
        self._too_long = 0
        self._declared: set[FleetDeclared] = set()
        self._closed = threading.Event()
        self._opening = threading.Thread(target=self._open, name="fleet open", daemon=True)
        self._opening.start()

    @property
    def connected(self) -> bool:
        """Whether a router answers now."""
        return self._session is not None and self._session.routers > 0

    @property
    def trouble(self) -> str:
        """Why there is no session yet, in one sentence; empty: it is open, or not yet tried."""
        return self._trouble

    @property
    def dropped(self) -> int:
        """Number of messages that were dropped on this side: too many waited, or too long."""
        senders = set(self._senders.values())
        return self._too_long + self._handover.dropped + sum(sender.dropped for sender in senders)

    def watch(self, pattern: str, changed: Callable[[str, bool], None]) -> FleetDeclared:
        """Call `changed` with each key where a token is, or (False) is no longer."""
        changes = TokenChanges(self._loop.post, changed)
        return self._declare(lambda session: session.watch_tokens(pattern, changes.note))

    def declare_token(self, key: str) -> FleetDeclared:
        """Be there at a key."""
        return self._declare(lambda session: session.declare_token(key))

    def subscribe(
        self, pattern: str, came: Came, *, keep: Callable[[str], bool] = lambda _: False
    ) -> FleetDeclared:
        """Call `came` for all that others put under a pattern.

        Args:
            pattern: The keys.
            came: Gets each.
            keep: Whether a message at this key is kept when too many wait; only its newest is.
        """

        def take(sample: ZenohSample) -> None:
            key, payload = sample.key, sample.payload
            kept = keep(key)
            if len(payload) > LONGEST:
                self._too_long += 1
                if not kept:
                    return
                payload = b""  # what is kept counts even when it cannot be read
            call = functools.partial(came, key, payload, sample.attachment)
            name = key if kept else None
            self._handover.add(call, name=name, keep=kept, size=len(payload))

        return self._declare(lambda session: session.subscribe(pattern, take))

    def watch_subscribers(self, key: str, changed: Callable[[bool], None]) -> FleetDeclared:
        """Call `changed` when the first subscriber of a key comes, and when the last has gone."""

        def note(wanted: bool) -> None:  # noqa: FBT001 - Zenoh calls it
            call = functools.partial(changed, wanted)
            self._handover.add(call, name=("subscribers", key), keep=True)

        return self._declare(lambda session: session.watch_subscribers(key, note))

    def respond(self, pattern: str, take: Callable[[FleetQuery], None]) -> FleetDeclared:
        """Call `take` for each query of keys that match."""
        return self._declare(
            lambda session: session.respond(
                pattern, lambda query: self._handover.add(lambda: take(query))
            )
        )

    def respond_at_once(self, key: str, answer: Callable[[], bytes]) -> FleetDeclared:
        """Answer queries of a key from the thread for commands, without the loop's delay."""
        sender = self._senders[FleetWay.COMMAND]

        def asked(query: FleetQuery) -> None:
            sender.add(lambda: query.answer(answer(), key=key), until=time.monotonic() + _PUT_S)

        return self._declare(lambda session: session.respond(key, asked))

    def reply(
        self,
        query: FleetQuery,
        payload: bytes,
        attachment: bytes,
        way: FleetWay,
        *,
        key: str = "",
    ) -> None:
        """Answer a query from the thread of its way; give the `key` where it asked for several."""
        until = time.monotonic() + _PUT_S * (1 if way is FleetWay.COMMAND else 20)
        self._senders[way].add(lambda: query.answer(payload, attachment, key=key), until=until)

    def put(
        self,
        key: str,
        payload: bytes,
        attachment: bytes | None,
        plane: Plane,
        *,
        until: float | None = None,
        name: Hashable | None = None,
    ) -> None:
        """Put; it is lost where the line cannot carry it now.

        Args:
            key: Where.
            payload: What.
            attachment: Its header.
            plane: What decides about its way.
            until: Monotonic time after which it is not put any more [s].
            name: What is still waiting under the same name is replaced.
        """
        session, way = self._session, FleetWay.of(plane)
        if session is None:
            return
        limit = time.monotonic() + _PUT_S if until is None else until
        self._senders[way].add(
            lambda: session.put(key, payload, attachment, way), until=limit, name=name
        )

    def ask(
        self,
        key: str,
        payload: bytes,
        attachment: bytes,
        *,
        timeout: float,
        answered: Callable[[bytes, bytes | None], None],
        failed: Callable[[str, str], None],
        plane: Plane = Plane.STATE,
    ) -> None:
        """Ask; exactly one of `answered` and `failed` is called, soon after `timeout` [s] at most.

        Args:
            key: What is asked for.
            payload: Bytes of the query.
            attachment: Its header.
            timeout: Longest wait for the answer [s].
            answered: Gets the payload and the attachment of the first answer.
            failed: Gets a class of `hub.errors`, and a sentence.
            plane: That of the query's message, which decides about the way of both.
        """
        session, done = self._session, False

        def end(call: Work) -> None:
            nonlocal done
            if not done:
                done = True
                call()

        def pass_on(call: Work, size: int = 0) -> None:
            self._handover.add(functools.partial(end, call), size=size)

        def came(each: ZenohSample) -> None:
            size = len(each.payload)
            if size > LONGEST:
                why = f"the answer at {key} has {size} bytes, which is more than {LONGEST}"
                pass_on(lambda: failed("QueryError", why))
            else:
                pass_on(lambda: answered(each.payload, each.attachment), size)

        if session is None:
            pass_on(lambda: failed("NoHandlerError", f"no router answers at {self._place}"))
            return
        silent = f"nothing in the fleet answers at {key} within {timeout:g} s"
        session.query(
            key,
            payload,
            attachment,
            way=FleetWay.of_query(plane),
            timeout=timeout,
            answered=came,
            failed=lambda error, why: pass_on(lambda: failed(error, why)),
            ended=lambda: pass_on(lambda: failed("QueryTimeoutError", silent)),
        )

    def tokens(self, pattern: str, *, timeout: float) -> list[str]:
        """The keys of the tokens that are there now; waits for up to `timeout` [s]."""
        return [] if self._session is None else self._session.tokens(pattern, timeout=timeout)

    def close(self) -> None:
        """End the session; nothing of it stays in the fleet."""
        self._closed.set()
        self._opening.join(5.0)
        for sender in set(self._senders.values()):
            sender.close()
        if self._session is not None:
            self._session.close()

    def _declare(self, make: Callable[[FleetSession], ZenohDeclared]) -> FleetDeclared:
        declared = FleetDeclared(make, self._declared)
        if self._session is not None:
            declared.declare(self._session)
        return declared

    def _open(self) -> None:
        while not self._closed.is_set():
            try:
                session = open_fleet_session(self._place, self._settings)
            except HubError as error:
                if str(error) != self._trouble:
                    self._trouble = str(error)
                    _logger.warning("%s; trying again until it does", self._trouble)
                self._closed.wait(_RETRY_S)
                continue
            if self._closed.is_set():
                session.close()
            else:
                self._loop.post(functools.partial(self._opened, session))
            return

    def _opened(self, session: FleetSession) -> None:
        self._session, self._trouble = session, ""
        _logger.info("joined the router at %s", self._place)
        for each in tuple(self._declared):
            each.declare(session)
