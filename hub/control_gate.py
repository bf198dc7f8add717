"""Keeps commands out of a module that come from others than the one who has control."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any

from hub.gcm.control import CONTROL_REFUSAL, CONTROL_STATE, ControlRefusal, ControlState
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.publish_rights import ROBOMON

_logger = logging.getLogger(__name__)

TELL_S = 1.0
"""A sender is told no more often than this why its commands do not count [s]."""
_MOST_SENDERS = 256


def follow_control(client: Client, learn: Callable[[ControlState], None]) -> None:
    """Call `learn` with each state of control that comes from the hub's daemon, and no other.

    The daemon is known by the number that central gave its connection. A state may come before
    central says that number: the newest one waits for it.
    """
    daemon = 0
    waiting: tuple[int, ControlState] | None = None

    def look() -> None:
        nonlocal waiting
        if waiting is not None and waiting[0] == daemon != 0:
            state, waiting = waiting[1], None
            learn(state)

    def connected(number: int) -> None:
        nonlocal daemon
        daemon = number
        look()

    def came(state: ControlState, reception: MessageInfo) -> None:
        nonlocal waiting
        waiting = reception.publisher, state
        look()

    client.directory.follow(ROBOMON, connected)
    client.subscribe(CONTROL_STATE, came, last=True)


class ControlGate:
    """Whose commands count now; anybody's until the hub says that somebody has control.

    What it knows holds until it is told something else: were the hub's daemon to hang, nobody else
    could begin to drive.

    Attributes:
        refused: Commands that were kept out since the module started.
    """

    def __init__(
        self, client: Client, changed: Callable[[ControlState, int], None] = lambda *_: None
    ) -> None:
        """Listen to who has control.

        Args:
            client: The module's connection.
            changed: Called with the new state, and who had control before (0: nobody), when
                somebody else has it than before.
        """
        self._client = client
        self._changed = changed
        self._state = ControlState()
        self._modules: frozenset[int] = frozenset()
        self._told: dict[int, float] = {}
        self.refused = 0
        client.define(CONTROL_REFUSAL)
        follow_control(client, self._learn)

    def counts(self, sender: int) -> bool:
        """Whether commands of this sender, by its number at central, are to be followed."""
        return self._state.owner in (0, sender) or sender in self._modules

    def admits(self, definition: MessageDefinition[Any], reception: MessageInfo) -> bool:
        """Whether a command is to be followed; if it is not, its sender is told why."""
        sender = reception.publisher
        if self.counts(sender):
            return True
        self.refused += 1
        now = time.monotonic()
        if now - self._told.get(sender, -TELL_S) >= TELL_S:
            if len(self._told) >= _MOST_SENDERS:
                self._told.clear()
            self._told[sender] = now
            self._tell(definition, sender)
        return False

    def _tell(self, definition: MessageDefinition[Any], sender: int) -> None:
        operator = self._state.operator
        _logger.warning(
            "%s of number %d refused: %s has control", definition.name, sender, operator
        )
        refusal = ControlRefusal(
            sender=sender,
            message=definition.name,
            owner=self._state.owner,
            operator=operator,
            refused=self.refused,
        )
        self._client.publish(CONTROL_REFUSAL, refusal)

    def _learn(self, state: ControlState) -> None:
        before, self._state = self._state.owner, state
        self._modules = frozenset(state.modules.tolist())
        if state.owner != before:
            self._changed(state, before)
