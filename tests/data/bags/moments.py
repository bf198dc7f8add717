"""When the messages of the recordings of this folder were written."""

from __future__ import annotations

START = 1_700_000_000_000_000_000
"""The first stamp [ns]."""
STAMPS = tuple(START + tick * 100_000_000 for tick in range(10))
"""The stamps of all messages that come again and again [ns]."""
