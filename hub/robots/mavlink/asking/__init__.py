"""Asks a vehicle without driving it: neither heartbeats nor sticks of a station are sent."""
