"""TCP ports that a test can take, leave, and take again."""

from __future__ import annotations

import os
import socket


def free_port() -> int:
    """The first of a row of neighbouring TCP ports that nobody uses.

    They lie below the range from which the system takes ports for connections. A client that keeps
    trying to reach a port of that range is sooner or later given it as its own, is then connected
    to itself, and holds it against the server that wants to come back.
    """
    for port in range(10_000 + os.getpid() % 1_000 * 20, 32_000, 10):
        held: list[socket.socket] = []
        try:
            for offset in range(10):
                held.append(socket.socket())
                held[-1].bind(("127.0.0.1", port + offset))
        except OSError:
            continue
        finally:
            for one in held:
                one.close()
        return port
    text = "no ten free ports"
    raise AssertionError(text)
