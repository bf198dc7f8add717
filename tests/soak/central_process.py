"""Central in a process of its own: python -m tests.soak.central_process ENDPOINT...

It writes one JSON line when it listens, and ends with SIGTERM or, so that none is left behind, with
its standard input.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
import threading
import time

from hub.ipc.broker.central import Central
from hub.nonblocking_logging import start_logging


def main() -> None:
    start_logging("central", logging.WARNING)
    central = Central(sys.argv[1:])
    listening_ns = time.monotonic_ns()
    found = {
        "endpoints": central.endpoints,
        "ports": central.entrances[0].ports,
        "paths": central.entrances[0].paths,
        "listening_ns": listening_ns,
    }
    sys.stdout.write(json.dumps(found) + "\n")
    sys.stdout.flush()
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    threading.Thread(target=lambda: (os.read(0, 1), ended.set()), daemon=True).start()
    ended.wait()
    central.close()


if __name__ == "__main__":
    main()
