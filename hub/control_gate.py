"""Admits commands to a module only from the client that has control of the robot.

The bus admits a command only under the number that central gave to its connection.

| state of control | sender | action |
| --- | --- | --- |
| not known yet, or free | any | admit |
| owned | the owner, or a module that the daemon lists | admit |
| owned | any other | refuse, count; say why at most once per second and sender |
| the daemon hangs or is gone | any | as before: the last known state stays |
"""

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

REPORT_INTERVAL_S = 1.0
"""Least time between two refusals that are reported to one sender [s]."""
_MOST_SENDERS = 256


def follow_control(client: Client, learn: Callable[[ControlState], None]) -> None:
    """Call `learn` with each state of control that the hub's daemon publishes, and no other.

    The number that central gave to the daemon's connection identifies it. A state may come
    before central reports that number: then the newest state waits for the number.
    """
    daemon = 0
    waiting: tuple[int, ControlState] | None = None

    def apply() -> None:
        nonlocal waiting
        if waiting is not None and waiting[0] == daemon != 0:
            state, waiting = waiting[1], None
            learn(state)

    def connected(number: int) -> None:
        nonlocal daemon
        daemon = number
        apply()

    def on_state(state: ControlState, reception: MessageInfo) -> None:
        nonlocal waiting
        waiting = reception.publisher, state
        apply()

    client.directory.follow(ROBOMON, connected)
    client.subscribe(CONTROL_STATE, on_state, last=True)


class ControlGate:
    """Admits or refuses commands; see the table of the module.

    Attributes:
        refused: Number of commands refused since the module started.
    """

    def __init__(
        self, client: Client, changed: Callable[[ControlState, int], None] = lambda *_: None
    ) -> None:
        """Subscribe to the state of control.

        Args:
            client: The module's connection.
            changed: Called when the owner changes, with the new state and the number of the
                owner before (0: none).
        """
        self._client = client
        self._changed = changed
        self._state = ControlState()
        self._modules: frozenset[int] = frozenset()
        self._reported_at: dict[int, float] = {}
        self.refused = 0
        client.define(CONTROL_REFUSAL)
        follow_control(client, self._on_state)

    def obeys(self, sender: int) -> bool:
        """Whether the gate admits commands of this sender, by its number at central."""
        return self._state.owner in (0, sender) or sender in self._modules

    def admits(self, definition: MessageDefinition[Any], reception: MessageInfo) -> bool:
        """Whether the module follows a command; if not, the gate reports why to its sender."""
        sender = reception.publisher
        if self.obeys(sender):
            return True
        self.refused += 1
        now = time.monotonic()
        if now - self._reported_at.get(sender, -REPORT_INTERVAL_S) >= REPORT_INTERVAL_S:
            if len(self._reported_at) >= _MOST_SENDERS:
                self._reported_at.clear()
            self._reported_at[sender] = now
            self._report(definition, sender)
        return False

    def _report(self, definition: MessageDefinition[Any], sender: int) -> None:
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

    def _on_state(self, state: ControlState) -> None:
        before, self._state = self._state.owner, state
        self._modules = frozenset(state.modules.tolist())
        if state.owner != before:
            self._changed(state, before)
