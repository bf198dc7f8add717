"""Fleets over Zenoh: keys and headers (pure), and sessions; only this room imports `zenoh`."""
