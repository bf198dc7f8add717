"""Central's list of all peers, and a client's requests to central."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from hub.errors import NotAllowedError, UnknownModuleError
from hub.ipc.node.connection import Connection
from hub.ipc.wire import control


class _Wait(Protocol):
    def __call__(self, done: Callable[[], object], timeout: float, why: str) -> None:
        """Serves until `done` is true; raises CentralUnreachableError after `timeout` [s]."""


class Directory:
    """Central's list, for one client."""

    def __init__(
        self, connection: Connection, wait: _Wait, attend: Callable[[], None], endpoint: str
    ) -> None:
        """Ask nothing yet.

        Args:
            connection: To central.
            wait: Serves the client until a condition is true.
            attend: Called before each request.
            endpoint: Address of central.
        """
        self._connection = connection
        self._wait = wait
        self._attend = attend
        self._silence = f"the hub at {endpoint} does not answer"
        self._listings: list[control.Listing] = []
        self._asked: Any = None
        self._closing: str | None = None
        self._closings: dict[str, control.Close | control.Refused] = {}
        self._watchers: list[Callable[[control.Presence], None]] = []
        self._followed: dict[str, Callable[[int], None]] = {}
        self._actions: dict[type, Callable[[Any], bool]] = {
            control.Presence: self._on_presence,
            control.Listing: self._on_listing,
            control.Close: self._on_close,
            control.Refused: self._on_refused,
        }

    def listing(self, timeout: float) -> control.Listing:
        """Central's listing: modules, messages, their users, and dropped messages.

        Raises:
            CentralUnreachableError: It did not answer within `timeout` [s].
        """
        self._attend()
        self._listings.clear()
        self._ask(control.List(), lambda: self._listings, timeout)
        return self._listings[-1]

    def watch(self, handler: Callable[[control.Presence], None]) -> None:
        """Call `handler` when a module connects, leaves, defines, publishes, subscribes or answers.

        `listing` has those that are connected already.
        """
        self._watchers.append(handler)
        self.ask_again()

    def follow(self, module: str, learn: Callable[[int], None]) -> None:
        """Call `learn` with the number of the module of this name; 0 while it is not connected.

        This number comes from central. A number in a frame may be forged.
        """
        self._followed[module] = learn
        self._ask_for(module)

    def ask_again(self) -> None:
        """Send the open requests to a new central."""
        if self._watchers and self._connection.publisher:
            self._connection.send(control.Watch())
        for module, learn in self._followed.items():
            learn(0)  # central reports at once if it is connected
            self._ask_for(module)
        if self._asked is not None:
            self._connection.send(self._asked)

    def close_module(self, name: str, *, timeout: float) -> None:
        """Have central disconnect the module of this name for good.

        Raises:
            UnknownModuleError: There is none.
            NotAllowedError: This client's key does not let it close modules.
            CentralUnreachableError: Central did not answer within `timeout` [s].
        """
        self._attend()
        self._closings.pop(name, None)
        self._closing = name
        try:
            self._ask(control.Close(name=name), lambda: name in self._closings, timeout)
        finally:
            self._closing = None
        outcome = self._closings.pop(name)
        if isinstance(outcome, control.Refused):
            forbidden = outcome.error == NotAllowedError.__name__
            raise (NotAllowedError if forbidden else UnknownModuleError)(outcome.text)

    def set_log_level(self, level: str) -> None:
        """Have central log from this level on: debug, info, warning or error."""
        self._attend()
        self._connection.send(control.LogLevel(level=level))

    def _ask_for(self, module: str) -> None:
        if self._connection.publisher:
            self._connection.send(control.Watch(module=module))

    def _ask(self, pending: Any, answered: Callable[[], object], timeout: float) -> None:
        self._connection.send(pending)
        self._asked = pending
        try:
            self._wait(answered, timeout, self._silence)
        finally:
            self._asked = None

    def on_control_message(self, message: Any) -> bool:
        """Handle a control message; whether it was for the directory."""
        action = self._actions.get(type(message))
        return action is not None and action(message)

    def _on_presence(self, presence: control.Presence) -> bool:
        learn = self._followed.get(presence.module)
        if learn is not None and presence.change is control.Change.CONNECTED:
            learn(presence.publisher)
        elif learn is not None and presence.change is control.Change.DISCONNECTED:
            learn(0)
        for watcher in self._watchers:
            watcher(presence)
        return True

    def _on_listing(self, listing: control.Listing) -> bool:
        self._listings.append(listing)
        return True

    def _on_close(self, close: control.Close) -> bool:
        self._closings[close.name] = close
        return True

    def _on_refused(self, refused: control.Refused) -> bool:
        unknown = refused.error == UnknownModuleError.__name__
        if not (unknown or refused.subject == self._closing):
            return False
        self._closings[refused.subject] = refused
        return True
