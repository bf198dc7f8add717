"""The session of a line with its router: opened beside the line's thread, watched, given up."""

from __future__ import annotations

import math
import socket
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from hub.errors import HubError
from hub.robots.host_lookup import HostLookup
from hub.robots.refusals import Refusals
from hub.robots.ros.address import RosAddress
from hub.zenoh.router_tls import tls_settings
from hub.zenoh.session import ZenohSession, open_session

RETRY_S: Final = 1.0
"""Time between two attempts to open a session [s]."""
PROBE_S: Final = 0.1
"""Time between two questions whether the router answers [s]."""
SILENT_S: Final = 0.5
"""Silence after which nothing is sent: an old velocity must not wait in a socket [s]."""
GIVEN_UP_S: Final = 3.0
"""Silence after which the session is left, with all that waits in it [s]."""
_SETTINGS: Final[dict[str, Any]] = {"transport/link/tx/queue/size/real_time": 1}
_SEND_BUFFER: Final = "#so_sndbuf=16384"
_TRIED_S: Final = 0.5
"""Longest time to learn whether an address refuses connections, which Zenoh does not say [s]."""


class RouterLink:
    """One session at a time.

    Attributes:
        session: The open session; None: there is none.
        why: The last fault in words; empty: there was none.
        connections: How often the router was reached.
        heard: When the router last answered [s, monotonic].
    """

    def __init__(
        self,
        address: RosAddress,
        clock: Callable[[], float],
        wake: Callable[[], None],
        certificates: str = "",
    ) -> None:
        self.session: ZenohSession | None = None
        self.why = ""
        self.connections = 0
        self.heard = -float("inf")
        self._certificates = certificates
        self._endpoint, self._clock, self._wake = address.url, clock, wake
        self._opened: deque[tuple[int, ZenohSession | str, bool]] = deque()
        self._lookup = HostLookup(address.host, address.port, socket.SOCK_STREAM)
        self._refusals = Refusals()
        self._links: deque[tuple[int, bool]] = deque()
        self._answers: deque[tuple[int, float]] = deque()
        self._turn = 0
        self._opening = self._linked = self._closed = False
        self._next_try = self._next_probe = self._since = -float("inf")
        self._probe_ends = -float("inf")

    @property
    def refused_since(self) -> float:
        """Since when the host refuses connections [s, monotonic]; infinite: it does not."""
        busy = self._opening or self.session is not None
        return math.inf if busy else self._refusals.since

    @property
    def up(self) -> bool:
        """Whether the router answers."""
        return self._linked and self._clock() - self.heard < SILENT_S

    def advance(self, now: float) -> bool:
        """Open, watch and give up; returns whether there is another session than before."""
        before = self.session
        self._read()
        if self.session is None:
            if not self._opening and now >= self._next_try:
                self._open(now)
        elif self._linked:
            self._probe(now)
            if now - max(self.heard, self._since) > GIVEN_UP_S:
                self.leave("the Zenoh router does not answer", now)
        return self.session is not before

    def leave(self, why: str, now: float) -> None:
        """End the session, and open another one at once."""
        self.why, self._linked = why, False
        self._turn += 1
        self._next_try = now
        session, self.session = self.session, None
        if session is not None:  # closing may wait for a router that is silent
            threading.Thread(target=session.close, daemon=True).start()

    def close(self) -> None:
        """End the session."""
        self._closed = True
        self._turn += 1
        session, self.session = self.session, None
        if session is not None:
            closing = threading.Thread(target=session.close, daemon=True)
            closing.start()
            closing.join(1.0)

    def _open(self, now: float) -> None:
        self._opening, self._next_try = True, now + RETRY_S
        turn = self._turn

        def work() -> None:
            refused = False
            try:
                tls = tls_settings(Path(self._certificates)) if self._certificates else {}
                opened: ZenohSession | str = open_session(
                    self._endpoint + _SEND_BUFFER, settings=_SETTINGS | tls
                )
            except HubError as error:
                opened = str(error).replace(_SEND_BUFFER, "")
                refused = self._lookup.refuses(_TRIED_S)
            if self._closed and isinstance(opened, ZenohSession):
                opened.close()
                return
            self._opened.append((turn, opened, refused))
            self._wake()

        threading.Thread(target=work, name="opens Zenoh", daemon=True).start()

    def _read(self) -> None:
        while self._opened:
            turn, opened, refused = self._opened.popleft()
            self._opening = False
            self._refusals.attempt(self._clock(), refused=refused)
            if isinstance(opened, str):
                self.why = opened
            elif turn != self._turn:
                opened.close()
            else:
                self._take(opened)
        while self._links:
            turn, here = self._links.popleft()
            if turn == self._turn:
                self._set_link(here)
        while self._answers:
            turn, sent = self._answers.popleft()
            if turn == self._turn:
                self.heard = max(self.heard, sent)
                self._probe_ends = -float("inf")

    def _take(self, opened: ZenohSession) -> None:
        self.session, turn = opened, self._turn
        opened.watch_link(lambda here: self._changed(turn, here))

    def _changed(self, turn: int, here: bool) -> None:  # noqa: FBT001 - called by Zenoh
        self._links.append((turn, here))
        self._wake()

    def _set_link(self, here: bool) -> None:  # noqa: FBT001 - of a callback
        if here and not self._linked:
            self.connections += 1
            self.heard = self._since = self._clock()
        elif not here:
            self.why = "the Zenoh router has left"
        self._linked = here

    def _probe(self, now: float) -> None:
        """Ask, unless a question is open; one that is lost ends after a while."""
        if now < max(self._next_probe, self._probe_ends) or self.session is None:
            return
        self._next_probe, self._probe_ends = now + PROBE_S, now + GIVEN_UP_S
        turn, longest = self._turn, GIVEN_UP_S * 2.0

        def answered() -> None:
            if self._clock() - now < GIVEN_UP_S:  # else it has ended without an answer
                self._answers.append((turn, now))
                self._wake()

        self.session.probe(answered, longest)
