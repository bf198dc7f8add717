"""The gateway for other machines: a copy of central's sockets, with keys (CURVE)."""
