"""Reports when the hub of a command that runs on stops answering, and when it answers again."""

from __future__ import annotations

from hub.command_output import print_error
from hub.ipc import endpoints
from hub.ipc.client import Client


class HubWatch:
    """Serves a client, and writes each loss and each return of its hub once.

    Attributes:
        answers: Whether the hub answers now.
    """

    def __init__(self, client: Client) -> None:
        """Watch the hub of a connected client."""
        self._client = client
        self.answers = True

    def listen(self, timeout: float) -> None:
        """Serve for up to `timeout` [s]."""
        self._client.listen(timeout)
        if self.answers == self._client.connected:
            return
        self.answers = not self.answers
        where = endpoints.shown(self._client.endpoint)
        state = "answers again" if self.answers else "does not answer; its state is not known"
        print_error(f"the hub ({where}) {state}")
