"""The seam between a mirror and the network of a fleet."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from hub.ipc.definition import Plane

Came = Callable[[str, bytes, bytes | None], None]
"""Gets the key, the payload and the attachment of what was put."""
Answered = Callable[[bytes, bytes | None], None]
"""Gets the payload and the attachment of an answer."""
Failed = Callable[[str, str], None]
"""Gets the error's class in `hub.errors`, and a sentence."""


class Declared(Protocol):
    """Something that stands at a key until it is withdrawn."""

    def withdraw(self) -> None:
        """Take it back."""


class FleetLine(Protocol):
    """A session in the network of a fleet. All callbacks come in the loop of its owner."""

    def watch(self, pattern: str, changed: Callable[[str, bool], None]) -> Declared:
        """Call `changed` with each key where a token is, or is no longer; at once for those now."""

    def declare_token(self, key: str) -> Declared:
        """Be there at a key."""

    def subscribe(self, pattern: str, came: Came) -> Declared:
        """Call `came` for all that others put under a pattern."""

    def put(self, key: str, payload: bytes, attachment: bytes, _plane: Plane, /) -> None:
        """Put; it is lost where the line cannot carry it now."""

    def ask(
        self,
        key: str,
        payload: bytes,
        attachment: bytes,
        *,
        timeout: float,
        answered: Answered,
        failed: Failed,
        plane: Plane = Plane.STATE,
    ) -> None:
        """Ask; exactly one of `answered` and `failed` is called, `timeout` [s] later at most."""
