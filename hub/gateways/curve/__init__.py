"""The gateway for other machines: the sockets of central once more, with keys (CURVE)."""
