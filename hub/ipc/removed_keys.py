"""Notices that keys were removed from the list while somebody is connected with them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable

from hub.errors import KeyFileError
from hub.ipc.keyring import Keyring
from hub.ipc.security import LOCAL, Bearer

_logger = logging.getLogger(__name__)

LOOK_S = 1.0
"""How often the list is looked at [s]."""


class RemovedKeys:
    """Keys that are on the list no longer; `holds` is for any thread, the rest for one.

    A list that cannot be read changes nothing here: who is connected stays, nobody else comes in.
    """

    def __init__(
        self,
        keyring: Keyring,
        connected: Callable[[], Iterable[Bearer]],
        end: Callable[[Bearer], None],
    ) -> None:
        """Read the list.

        Args:
            keyring: The list.
            connected: The keys of those who are connected now.
            end: Ends the connections of who has this key.

        Raises:
            KeyFileError: The list cannot be read.
        """
        self._keyring = keyring
        self._connected = connected
        self._end = end
        self._known = self._read()
        self._removed: frozenset[Bearer] = frozenset()
        self._next = 0.0

    def holds(self, bearer: Bearer) -> bool:
        """Whether this key was not removed."""
        return bearer not in self._removed

    def look(self, now: float) -> None:
        """End the connections of keys that are on the list no longer, or have another role now.

        Args:
            now: Monotonic time [s]; it looks once in `LOOK_S`.
        """
        if now < self._next:
            return
        self._next = now + LOOK_S
        try:
            known = self._read()
        except KeyFileError:
            return  # the next handshake counts it and logs it
        listed = {bearer for bearer, _ in known}
        replaced = {bearer for bearer, _ in self._known - known}
        strangers = {each for each in self._connected() if each is not LOCAL and each not in listed}
        self._removed = (self._removed | replaced | strangers) - listed
        self._known = known
        for bearer in replaced | strangers:
            _logger.info("the key of %s was removed: its connections end", bearer)
            self._end(bearer)

    def _read(self) -> frozenset[tuple[Bearer, str]]:
        return frozenset((holder.bearer, holder.public) for holder in self._keyring.holders())
