"""Commands that run on beside a hub: they say when it stops answering, and when it is back."""

from __future__ import annotations

from hub.command_output import print_error
from hub.ipc import endpoints
from hub.ipc.client import Client


class HubWatch:
    """Serves a client, and says once that the hub does not answer: silence is no answer.

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
        state = "answers again" if self.answers else "does not answer; what it has is not known"
        print_error(f"the hub ({where}) {state}")
