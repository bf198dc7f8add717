"""Clients that come, say something and go, some without a word.

python -m tests.misbehaving.passers_by ENDPOINT ATONCE SECONDS SEED: so many at once; it writes how
many there were as a JSON line.
"""

from __future__ import annotations

import collections
import json
import os
import random
import sys
import time

from hub.errors import HubError
from hub.ipc.client import Client
from tests.soak import vocabulary as v

_REST_S = 0.01
_STAY_S = (0.2, 3.0)


class Crowd:
    """So many clients at once, all served by one thread."""

    def __init__(self, endpoint: str, at_once: int, seed: int) -> None:
        self._endpoint = endpoint
        self._at_once = at_once
        self._chance = random.Random(seed)
        self._present: list[tuple[float, Client]] = []
        self.counts: collections.Counter[str] = collections.Counter()

    def turn(self) -> None:
        """Serve each once; who has stayed long enough goes, others come."""
        now = time.monotonic()
        for leaves, client in list(self._present):
            client.listen(0.0)
            if now > leaves:
                self._present.remove((leaves, client))
                self._leave(client)
        for _ in range(min(5, self._at_once - len(self._present))):
            self._present.append((now + self._chance.uniform(*_STAY_S), self._come()))

    def close(self) -> None:
        """All go."""
        for _, client in self._present:
            self._leave(client)

    def _come(self) -> Client:
        self.counts["came"] += 1
        client = Client(f"passer-by {os.getpid()} {self.counts['came']}", self._endpoint)
        # Of a name nobody publishes, so that they load no good traffic.
        client.subscribe(v.PICTURE, lambda _value, _how: None)
        client.define(v.COMMAND)
        return client

    def _leave(self, client: Client) -> None:
        self.counts["were connected"] += client.connected
        if self._chance.random() < 0.5:
            self.counts["went silently"] += 1
            client.session.connection.publisher = 0  # it says no goodbye
        try:
            client.close()
        except HubError:
            self.counts["faults"] += 1


def main() -> None:
    os.nice(10)
    endpoint, at_once, seconds, seed = sys.argv[1:5]
    crowd = Crowd(endpoint, int(at_once), int(seed))
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        crowd.turn()
        time.sleep(_REST_S)
    crowd.close()
    sys.stdout.write(json.dumps(crowd.counts) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
