"""A fleet in this process: what one line puts, the others get; for tests without a network."""

from __future__ import annotations

from collections.abc import Callable

from hub.doors.mirror.fleet_line import Answered, Came, Failed
from hub.ipc.definition import Plane
from hub.ipc.transport.loop import Loop

Answer = Callable[[str, bytes, bytes], tuple[bytes, bytes | None] | None]
"""(key, payload, attachment) -> payload and attachment; None: no answer comes."""


class _Declared:
    def __init__(self, withdraw: Callable[[], None]) -> None:
        self.withdraw = withdraw


class MemoryFleet:
    """A `FleetLine` whose other side is the test.

    Attributes:
        tokens: Declared tokens.
        puts: What was put: key, payload, attachment.
        patterns: What is subscribed to.
        answers: What answers queries of keys that begin so.
    """

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._watchers: list[tuple[str, Callable[[str, bool], None]]] = []
        self._subscribers: list[tuple[str, Came]] = []
        self.tokens: list[str] = []
        self.puts: list[tuple[str, bytes, bytes]] = []
        self.answers: dict[str, Answer] = {}

    @property
    def patterns(self) -> list[str]:
        return [pattern for pattern, _ in self._subscribers]

    def come(self, key: str, *, there: bool = True) -> None:
        for _, changed in self._watchers:
            changed(key, there)

    def give(self, key: str, payload: bytes, attachment: bytes | None = None) -> None:
        for pattern, came in list(self._subscribers):
            if pattern == key:
                came(key, payload, attachment)

    def watch(self, pattern: str, changed: Callable[[str, bool], None]) -> _Declared:
        entry = (pattern, changed)
        self._watchers.append(entry)
        return _Declared(lambda: self._watchers.remove(entry))

    def declare_token(self, key: str) -> _Declared:
        self.tokens.append(key)
        return _Declared(lambda: self.tokens.remove(key))

    def subscribe(self, pattern: str, came: Came) -> _Declared:
        entry = (pattern, came)
        self._subscribers.append(entry)
        return _Declared(lambda: self._subscribers.remove(entry))

    def put(self, key: str, payload: bytes, attachment: bytes, _plane: Plane) -> None:
        self.puts.append((key, payload, attachment))

    def ask(
        self,
        key: str,
        payload: bytes,
        attachment: bytes,
        *,
        timeout: float,
        answered: Answered,
        failed: Failed,
        plane: Plane = Plane.STATE,  # noqa: ARG002 - there is one way only
    ) -> None:
        def answer() -> None:
            for start, how in self.answers.items():
                if key.startswith(start):
                    found = how(key, payload, attachment)
                    if found is not None:
                        answered(*found)
                    else:
                        self._loop.after(timeout, lambda: failed("QueryTimeoutError", "silence"))
                    return
            failed("NoHandlerError", f"nobody answers {key}")

        self._loop.after(0.0, answer)
