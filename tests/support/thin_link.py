"""A thin link in front of a hub, or of any TCP ports in a row: the link shaper, without a hub.

`hub.shaper.shaped_link` needs a hub, and a profile in a file. Tests and benchmarks give numbers.
"""

from __future__ import annotations

import os
import subprocess
import sys

from hub.shaper.profile import DirectionSpec, LinkProfile
from hub.shaper.relay import Relay

ADDRESS = "127.0.0.2"
PORTS = 7


class ThinLink:
    """The process.

    Attributes:
        endpoint: The hub's at the near end.
    """

    def __init__(
        self, hub: str, *, rate: float, delay: float = 0.02, room: int = 64_000, ports: int = PORTS
    ) -> None:
        """Start it, and wait until it listens.

        Args:
            hub: The hub's endpoint, tcp://127.0.0.1:PORT.
            rate: Each way [bit/s].
            delay: Each way [s].
            room: Bytes that may wait in it, each way.
            ports: How many there are in a row.
        """
        port = int(hub.rpartition(":")[2])
        self.endpoint = f"tcp://{ADDRESS}:{port}"
        arguments = [str(port), str(ports), str(rate), str(delay), str(room)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.thin_link", *arguments],
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == b"ready\n"

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()


def main() -> None:
    """Carry as `ThinLink` says."""
    first, count = int(sys.argv[1]), int(sys.argv[2])
    rate, delay, room = float(sys.argv[3]), float(sys.argv[4]), int(sys.argv[5])
    way = DirectionSpec(rate=rate, delay=delay, queue=room)
    hub = [("127.0.0.1", port) for port in range(first, first + count)]
    relay = Relay(ADDRESS, hub, LinkProfile(up=way, down=way), seed=1)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    relay.run(lambda: False)


if __name__ == "__main__":
    main()
