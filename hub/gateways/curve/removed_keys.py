"""Detects keys that were removed from the list, and ends their connections."""

from __future__ import annotations

import logging
from collections.abc import Callable, Set

from hub.errors import KeyFileError
from hub.ipc.roles import Principal
from hub.ipc.security.keyring import Keyring

_logger = logging.getLogger(__name__)

CHECK_S = 1.0
"""Period of the check of the list [s]."""


class RemovedKeys:
    """The keys that left the list. Any thread may call `holds`, one thread the rest.

    A removed key stays refused until the same key is on the list again, with its role and name.
    Another key of that name is another principal, and changes nothing for the removed one.

    An unreadable list changes nothing here: connected clients stay, and no other client is
    admitted.
    """

    def __init__(
        self,
        keyring: Keyring,
        admitted: Callable[[], Set[Principal]],
        end: Callable[[Principal], None],
    ) -> None:
        """Start to watch the list.

        Args:
            keyring: The list.
            admitted: The keys that the gateway admitted since its start.
            end: Ends the connections of a key.
        """
        self._keyring = keyring
        self._admitted = admitted
        self._end = end
        self._removed: frozenset[Principal] = frozenset()
        self._next = 0.0

    def holds(self, principal: Principal) -> bool:
        """Whether this key is still on the list."""
        return principal not in self._removed

    def check(self, now: float) -> None:
        """End the connections of keys that left the list, or have another role now.

        Args:
            now: Monotonic time [s]; it looks once in `CHECK_S`.
        """
        if now < self._next:
            return
        self._next = now + CHECK_S
        try:
            listed = {holder.principal for holder in self._keyring.holders()}
        except KeyFileError:
            return  # the next handshake logs it
        before, self._removed = self._removed, frozenset(self._admitted() - listed)
        for principal in self._removed - before:
            _logger.info("the key of %s was removed: its connections end", principal)
            self._end(principal)
